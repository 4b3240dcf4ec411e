//! The scene file as a tree of plugins with named properties: the XML format of Mitsuba 3, read and written.
//!
//! This layer knows syntax and value types (`<float>`, `<transform>`, `<default>`, `$name`, `<include>`, `<ref>`) and where each thing
//! stands in its file; which plugins and parameters exist is `scene`'s knowledge, read through [`Reader`].

pub mod diagnostic;
pub mod index;
pub mod object;
pub mod reader;
mod suggest;
pub mod transform;

pub use diagnostic::{Diagnostic, Diagnostics, Severity, SourceFile, SourceId, Span};
pub use index::Index;
pub use object::{Category, Child, Document, Object, Property, Value};
pub use reader::Reader;
pub use transform::TransformOp;
