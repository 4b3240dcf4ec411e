//! The one door for files: [`read()`] opens the files that the user or a scene names, [`write_atomically`] replaces files as a whole.
//!
//! No other module opens a file for reading (`tests/layering.rs` holds that), so that no device, pipe or endless file is read anywhere.

mod atomic;
mod locking;
mod reading;

pub use self::atomic::{check_writable, write_atomically};
pub use self::locking::{FolderBusy, FolderLock, lock_folder};
pub use self::reading::{FileError, LARGEST_DATA, LARGEST_NOTE, check, open, read, read_text};
