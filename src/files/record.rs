//! Remembers which files are read through an [`Access`](super::Access) and those that are noted, so that a program can tell what a scene consists of.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

static OPENED: Mutex<Option<BTreeSet<PathBuf>>> = Mutex::new(None);

/// Has every file of scenes remembered that this process reads from now on.
pub fn record_reads() {
    let mut opened = OPENED.lock().unwrap_or_else(PoisonError::into_inner);
    opened.get_or_insert_default();
}

/// The files that were read since [`record_reads`], in the order of their names.
pub fn recorded_reads() -> Vec<PathBuf> {
    let opened = OPENED.lock().unwrap_or_else(PoisonError::into_inner);
    opened.iter().flatten().cloned().collect()
}

/// Remembers a file that a scene consists of, if that was asked for.
pub fn note_read(path: &Path) {
    if let Some(opened) = &mut *OPENED.lock().unwrap_or_else(PoisonError::into_inner) {
        opened.insert(path.to_owned());
    }
}
