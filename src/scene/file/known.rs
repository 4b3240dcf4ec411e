//! The known content of the files of a scene.

use std::path::{Path, PathBuf};

use bevy::prelude::*;

use crate::document::SourceFile;
use crate::document::paths::settle;
use crate::document::source::read_text;

/// The contents that files are known to have although the scene was not read from them: the program wrote them but
/// could not read them again, or the scene was recovered and is to be saved there. None: there was no such file.
#[derive(Resource, Clone, Debug, Default)]
pub struct KnownTexts(pub(in crate::scene) Vec<(PathBuf, Option<String>)>);

impl KnownTexts {
    /// Records the present content of the file, if it can be read.
    pub fn note_present(&mut self, path: &Path) {
        self.0 = vec![(settle(path), read_text(path).ok())];
    }

    pub(in crate::scene) fn note_written(&mut self, files: Vec<(PathBuf, String)>) {
        self.0 = files.into_iter().map(|(path, text)| (path, Some(text))).collect();
    }

    pub(in crate::scene) fn forget(&mut self) {
        self.0.clear();
    }
}

pub(in crate::scene) fn is_text_of(source: &SourceFile, text: &str) -> bool {
    let without_mark = text.strip_prefix('\u{feff}');
    without_mark.is_some() == source.byte_order_mark && without_mark.unwrap_or(text) == source.text.as_str()
}

/// Whether the files still have the content that was read from them.
pub(in crate::scene) fn are_as_read(sources: &[SourceFile]) -> bool {
    let is_as_read = |source: &SourceFile| read_text(&source.path).is_ok_and(|text| is_text_of(source, &text));
    sources.iter().all(is_as_read)
}
