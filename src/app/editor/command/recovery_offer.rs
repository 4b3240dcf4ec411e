//! Autosaved edits that can be recovered after a crash.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The description of an autosave.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Note {
    /// The file of the scene. None: it was never saved.
    pub scene: Option<PathBuf>,
    /// The time of the autosave in seconds since 1970.
    pub time: u64,
    /// The number of shapes, lights and cameras; None in notes of older versions.
    #[serde(default)]
    pub things: Option<usize>,
    /// The hash of the file's content at that time. None if there was no file, and in notes of older versions.
    #[serde(default)]
    pub file: Option<u64>,
}

/// The offer to recover an autosave.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Offer {
    /// The folder of the note and the autosaved scene.
    pub folder: PathBuf,
    /// The scene and the time of the autosave.
    pub note: Note,
    /// Whether the note cannot be read, so that only the time is known.
    pub is_damaged: bool,
    /// Whether the file of the scene was changed after the autosave.
    pub is_outdated: bool,
}
