//! The reasons why a scene cannot be saved.

use std::path::PathBuf;

use crate::document::{self, SourceError};
use crate::files::WriteError;
use crate::scene::assets::without_patterns::PatternError;

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
    /// The file was changed by others since it was read. `edited_twice` is the number of things edited both there and
    /// here; None if unknown.
    #[error("{} was changed elsewhere{}", path.display(), also_edited(*edited_twice))]
    Changed { path: PathBuf, edited_twice: Option<usize> },
    #[error("{} was changed elsewhere and cannot be read as it is now: {reason}", path.display())]
    Broken { path: PathBuf, reason: String },
    #[error("another window has been saving in {} for seconds: try again", folder.display())]
    Locked { folder: PathBuf },
    #[error("{} is being changed elsewhere again and again", path.display())]
    Restless { path: PathBuf },
}

fn also_edited(count: Option<usize>) -> String {
    match count {
        None => String::new(),
        Some(1) => ", and one thing was edited both there and here".to_owned(),
        Some(count) => format!(", and {count} things were edited both there and here"),
    }
}

impl From<WriteError> for SaveError {
    fn from(WriteError { path, source }: WriteError) -> Self {
        Self::File { path, source }
    }
}
