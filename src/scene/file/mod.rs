//! The file of the scene: what is known of its content and of the files that things name.

pub(crate) mod changes;
pub(crate) mod entities;
pub(super) mod file_base;
pub(super) mod file_moment;
pub(super) mod files_in_use;
pub mod keep_source;
pub(crate) mod known;
