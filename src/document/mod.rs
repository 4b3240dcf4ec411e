//! The scene file as a tree of plugins with named properties: the XML format of Mitsuba 3, read and written.
//!
//! This layer knows syntax and value types (`<float>`, `<transform>`, `<default>`, `$name`, `<include>`, `<ref>`) and where each thing
//! stands in its file; which plugins and parameters exist is `scene`'s knowledge.

pub mod diagnostic;
pub mod object;
pub mod transform;

pub use diagnostic::{Diagnostic, Diagnostics, Severity, SourceFile, SourceId, Span};
pub use object::{Category, Child, Document, Object, Property, Value};
pub use transform::TransformOp;
