//! The one door for files: [`read()`] opens the files that the user or a scene names, [`write_atomically`] replaces
//! files as a whole, and [`FileSet`] several that belong together.
//!
//! Files named by a scene are opened through its [`Access`], which may be limited to some folders.
//!
//! No other module opens a file for reading (`tests/layering` checks that), so that no device, pipe or endless file is
//! read anywhere.

mod access;
mod atomic;
mod exr_compression;
mod folder_names;
mod reading;
mod record;
mod set;

pub use self::access::Access;
pub use self::atomic::{FolderBusy, FolderLock, lock_folder};
pub use self::atomic::{check_writable, write_atomically, write_atomically_with};
pub use self::exr_compression::ExrCompression;
pub use self::folder_names::FolderNames;
pub use self::reading::{FileError, LARGEST_DATA, LARGEST_NOTE, check, open, read, read_text};
pub use self::record::{SameFiles, is_same_file, keep_reads, note_read, record_reads, recorded_reads};
pub use self::set::{FileSet, WriteError, checksum, finish_set, finish_set_within};
