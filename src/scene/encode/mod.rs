//! Components as plugins of a document. Reading uses this to know what saving would write for a thing that nobody
//! edited.

mod into_object;
pub mod lights;
pub mod objects;
pub mod poses;
