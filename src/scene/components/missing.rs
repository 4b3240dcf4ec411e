//! The missing files of a scene.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use crate::document::{Diagnostics, Severity, Span};

/// The most other paths that a message names.
const MOST_NAMED: usize = 4;

/// The kinds of files without which a scene can be opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A mesh, which is left out.
    Mesh,
    /// A picture, which grey replaces.
    Picture,
    /// A volume, which is left out.
    Volume,
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Mesh => "mesh",
            Self::Picture => "picture",
            Self::Volume => "volume",
        })
    }
}

/// A file that was not found when the scene was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MissingFile {
    /// The kind of the file.
    pub kind: FileKind,
    /// The span where the scene names it first.
    pub span: Span,
    /// Where it was searched besides the path that is its key; absolute.
    pub others: Vec<PathBuf>,
    /// Advice.
    pub help: Option<String>,
}

/// The missing files of a scene, by the first path at which each was searched, absolute.
pub type MissingFiles = BTreeMap<PathBuf, MissingFile>;

impl MissingFile {
    /// The problem, as a sentence without the file: `no such file`, and where else it was searched.
    pub fn what(&self) -> String {
        let named = self.others.iter().take(MOST_NAMED);
        let named: Vec<String> = named.map(|place| place.display().to_string()).collect();
        let named = named.join(", ");
        match (self.others.len(), self.others.len().saturating_sub(MOST_NAMED)) {
            (0, _) => NOT_THERE.to_owned(),
            (_, 0) => format!("{NOT_THERE}; also looked for as {named}"),
            (_, more) => format!("{NOT_THERE}; also looked for as {named} and in {more} more places"),
        }
    }
}

/// The problem of a missing file.
pub(in crate::scene) const NOT_THERE: &str = "no such file";

/// The problem of a picture that grey replaces, or of the file of a lamp.
pub(in crate::scene) fn with_replacement(path: &Path, what: &str) -> String {
    let extension = path.extension().unwrap_or_default();
    match ["ies", "ldt"].iter().any(|lamp| extension.eq_ignore_ascii_case(lamp)) {
        true => format!("{what}; the lamp stays dark"),
        false => format!("{what}; grey takes its place"),
    }
}

/// The sentence about a file of this kind.
pub(in crate::scene) fn sentence(kind: FileKind, path: &Path, what: &str) -> String {
    format!("{kind} {}: {what}", path.display())
}

/// Adds an error for each missing file to those of a scene that cannot be shown, so that all errors are known at once.
pub(in crate::scene) fn report(missing: &MissingFiles, diagnostics: &mut Diagnostics) {
    let mut all: Vec<_> = missing.iter().collect();
    all.sort_by_key(|(_, file)| (file.span.source.0, file.span.start));
    for (path, file) in all {
        let severity = match file.kind {
            FileKind::Picture => Severity::Warning,
            FileKind::Mesh | FileKind::Volume => Severity::Error,
        };
        let message = sentence(file.kind, path, &file.what());
        diagnostics.push(severity, Some(file.span), message, file.help.clone());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_names_some_of_the_places() {
        let missing = |places: usize| MissingFile {
            kind: FileKind::Mesh,
            span: Span::default(),
            others: (0..places).map(|place| format!("/{place}/a.ply").into()).collect(),
            help: None,
        };
        assert_eq!(missing(0).what(), "no such file");
        assert_eq!(missing(1).what(), "no such file; also looked for as /0/a.ply");
        let many = missing(100).what();
        assert!(many.ends_with("/2/a.ply, /3/a.ply and in 96 more places"), "{many}");
    }
}
