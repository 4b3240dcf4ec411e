//! Edits that were written aside before a crash and can be recovered.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The description of edits that were written aside.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Note {
    /// The file of the scene. None: it was never saved.
    pub scene: Option<PathBuf>,
    /// Seconds since 1970.
    pub time: u64,
    /// Counts shapes, lights and cameras; None in notes of older versions.
    #[serde(default)]
    pub things: Option<usize>,
    /// The hash of what the file held at that time. None if there was no file, and in notes of older versions.
    #[serde(default)]
    pub file: Option<u64>,
}

/// The offer to recover edits.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Offer {
    /// Holds the note and the scene that was written aside.
    pub folder: PathBuf,
    /// Tells which scene it was and when.
    pub note: Note,
    /// The note cannot be read, so that nothing but the time is known.
    pub is_damaged: bool,
    /// The file of the scene was changed after that.
    pub is_outdated: bool,
}
