//! The question to the user when others have changed a file since it was read, or when there are newer edits of it to
//! recover.

use std::path::{Path, PathBuf};

use super::recovery_words::time_and_age;
use crate::app::editor::command::recovery_offer::Offer;
use crate::scene::write::SaveError;

/// The question. It is shown until it is answered; meanwhile changes of the file are not loaded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SaveQuestion {
    /// The path of the save.
    pub path: PathBuf,
    /// The change of the file, as a sentence without a full stop.
    pub reason: String,
    /// Whether the changes of the file can be merged.
    pub can_merge: bool,
    /// An autosave by an earlier run with edits that the file does not have.
    pub copy: Option<Offer>,
    /// Whether the user is choosing another file.
    pub is_naming: bool,
}

impl SaveQuestion {
    /// The question about an error. `path` is the path of the save. None for errors that another choice would not
    /// solve.
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
            copy: None,
            is_naming: false,
        })
    }

    /// The question before a scene is saved at `path` over a file with a newer autosave.
    pub fn about_copy(copy: Offer, path: &Path) -> Self {
        Self {
            path: path.to_owned(),
            reason: format!(
                "There are edits of {} that were never saved: a copy of them was written {}",
                path.display(),
                time_and_age(&copy.note)
            ),
            can_merge: false,
            copy: Some(copy),
            is_naming: false,
        }
    }

    /// The question as an error message, for callers that cannot ask the user.
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
