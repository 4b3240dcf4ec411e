//! The reasons why a scene cannot be saved.

use std::path::PathBuf;

use crate::document::{self, SourceError};
use crate::files::WriteError;
use crate::scene::assets::without_patterns::PatternError;
use crate::scene::listed::listed;

/// The reason why a scene is not saved. In all cases the file is unchanged.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum SaveError {
    #[error(transparent)]
    Write(#[from] document::WriteError),
    #[error(
        "{} is not of the format that is written: save the scene under another name, such as {}",
        path.display(),
        proposal.display()
    )]
    Foreign { path: PathBuf, proposal: PathBuf },
    #[error("{}: the scene is made of this file; choose another name", path.display())]
    InUse { path: PathBuf },
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
    /// The grid of a `.vdb` file cannot be written as a `.vol` file.
    #[error("volume {}: {reason}", path.display())]
    Volume { path: PathBuf, reason: String },
    /// A pattern cannot be turned into a picture.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// There is a folder or a device, which is not replaced.
    #[error(transparent)]
    NoFile(SourceError),
    /// The file was changed by others since it was read. `edited_twice` are the names of things edited both there and
    /// here; None if unknown.
    #[error("{} was changed elsewhere{}", path.display(), also_edited(edited_twice.as_deref()))]
    Changed {
        path: PathBuf,
        edited_twice: Option<Vec<String>>,
    },
    #[error("{} was changed elsewhere and cannot be read as it is now: {reason}", path.display())]
    Broken { path: PathBuf, reason: String },
    #[error("another window has been saving in {} for seconds: try again", folder.display())]
    Locked { folder: PathBuf },
    #[error("{} is being changed elsewhere again and again", path.display())]
    Restless { path: PathBuf },
}

/// The most things that the message names.
const MOST_NAMED: usize = 5;

fn also_edited(names: Option<&[String]>) -> String {
    let Some(names) = names else {
        return String::new();
    };
    let was = if names.len() == 1 { "was" } else { "were" };
    format!(", and {} {was} edited both there and here", listed(names, MOST_NAMED))
}

impl From<WriteError> for SaveError {
    fn from(WriteError { path, source }: WriteError) -> Self {
        Self::File { path, source }
    }
}
