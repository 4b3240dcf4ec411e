//! The scene file as a tree of plugins with named properties: the XML format of Mitsuba 3, read and written.
//!
//! This layer knows syntax and value types (`<float>`, `<transform>`, `<default>`, `$name`, `<include>`, `<ref>`) and
//! the place of each element in its file; which plugins and parameters exist is `scene`'s knowledge, read through
//! [`Reader`].

pub mod animation;
mod cie;
mod crowd;
mod define;
pub mod diagnostic;
mod dialect;
mod links;
mod naming;
pub mod object;
pub mod parse;
mod parsed;
pub mod paths;
mod property;
pub mod reader;
pub mod report;
pub mod revision;
pub mod source;
pub mod spectrum;
pub mod suggest;
mod tag;
pub mod transform;
mod unpack;
pub mod value;
pub mod write;

pub use crowd::Crowd;
pub use diagnostic::{Diagnostic, Diagnostics, Severity, SourceFile, SourceId, Span};
pub use object::{Category, Child, Interpolation, Key, Object, Property, Track, Value};
pub use parse::{load, parse_str, parse_within};
pub use parsed::Index;
pub use parsed::{Document, Include, LIGHT_UNITS, UNIT, property_name};
pub use reader::Reader;
pub use source::SourceError;
pub use transform::TransformOp;
pub use write::{WriteError, to_xml};
