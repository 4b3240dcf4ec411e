//! The question to the user when a file was changed by others since it was read.

use std::path::{Path, PathBuf};

use crate::scene::write::SaveError;

/// The question. It is shown until it is answered; meanwhile changes of the file are not read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SaveQuestion {
    /// The path to which the scene was to be saved.
    pub path: PathBuf,
    /// What has happened to the file, without a full stop.
    pub reason: String,
    /// The changes of the file can be taken in.
    pub can_merge: bool,
    /// The user is choosing another file.
    pub is_naming: bool,
}

impl SaveQuestion {
    /// The question about an error. `path` is where the scene was to be saved. None for errors that saving in another way would not solve.
    pub fn about(error: &SaveError, path: &Path) -> Option<Self> {
        let can_merge = match error {
            SaveError::Changed { edited_twice, .. } => edited_twice.is_some(),
            SaveError::Broken { .. } => false,
            _ => return None,
        };
        Some(Self {
            path: path.to_owned(),
            reason: error.to_string(),
            can_merge,
            is_naming: false,
        })
    }

    /// The question as an error message, for where the user cannot be asked.
    pub(crate) fn refusal(&self) -> String {
        let merge = match self.can_merge {
            true => "`save-to FILE merge` takes in what the file changed, ",
            false => "",
        };
        format!(
            "{}; it was not saved ({merge}`save-to FILE overwrite` replaces it)",
            self.reason
        )
    }
}
