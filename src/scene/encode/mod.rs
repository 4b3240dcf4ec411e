//! Converts components to plugins of a document. Reading uses this to know what saving would write for an unedited
//! thing.

mod into_object;
pub mod lights;
pub mod objects;
pub mod poses;
