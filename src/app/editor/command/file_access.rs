//! Files outside a scene's folder that the user is asked to allow.

use std::path::{Path, PathBuf};

use super::SceneEdit;
use super::scene::Replacement;
use crate::document::paths::settle;

/// The files and folders that a scene names outside its own folder.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// The paths as the scene gives them, made absolute.
    pub files: Vec<PathBuf>,
    /// The paths of `files` as the user reads them, without `..`.
    pub shown: Vec<PathBuf>,
    /// The folders that would be allowed, with all below them.
    pub folders: Vec<PathBuf>,
    /// Whether the scene could not be read without them.
    pub is_needed: bool,
    /// The edit that needs them, for a file names them; None if the open scene does, or one to be opened.
    pub edit: Option<SceneEdit>,
}

impl Question {
    /// The question about these files; None if there are none.
    pub fn about(files: Vec<PathBuf>) -> Option<Self> {
        let mut folders: Vec<PathBuf> = files.iter().filter_map(|file| folder_of(file)).collect();
        folders.sort();
        folders.dedup_by(|folder, before| folder.starts_with(before));
        let mut shown: Vec<PathBuf> = files.iter().map(|file| settle(file)).collect();
        shown.sort();
        shown.dedup();
        (!files.is_empty()).then_some(Self {
            files,
            shown,
            folders,
            is_needed: false,
            edit: None,
        })
    }

    /// The file of the edit, which names the others.
    pub fn file(&self) -> Option<&Path> {
        let (SceneEdit::Import(path) | SceneEdit::Replace(Replacement::File(path))) = self.edit.as_ref()? else {
            return None;
        };
        Some(path)
    }
}

/// The folder to allow for a file, with links resolved; for a folder it is the folder itself. None if it does not
/// exist.
fn folder_of(file: &Path) -> Option<PathBuf> {
    let target = file.canonicalize().ok()?;
    match target.is_dir() {
        true => Some(target),
        false => target.parent().map(Path::to_owned),
    }
}
