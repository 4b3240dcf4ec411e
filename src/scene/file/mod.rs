//! The file of the scene: its known content, and the files used by things.

pub(crate) mod changes;
pub(crate) mod entities;
pub(super) mod file_base;
pub(super) mod file_moment;
pub(super) mod files_in_use;
pub mod keep_source;
pub(crate) mod known;
