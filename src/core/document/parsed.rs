//! A scene file once it is read: its tree of plugins and all that the text said beside them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::paths::file_candidates;
use super::{Crowd, Diagnostics, Object, SourceId, Span};
use crate::files::Access;

/// An `<include>`, once for each time it was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Include {
    /// The place of the file's name in the tag.
    pub span: Span,
    /// The included file.
    pub source: SourceId,
}

/// A parsed scene file with its includes and defaults resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// The path of the main file, as it was opened or as it will be written.
    pub path: PathBuf,
    /// The `<scene>` without its crowds. It is shared, because saving needs what was read, which may be very large.
    pub root: Arc<Object>,
    /// The crowds in the order of their positions among the children of the root. An imported document has none.
    pub crowds: Vec<Crowd>,
    /// The moment in seconds whose values the properties have.
    pub time: f64,
    /// The folders in which files are looked for besides the folders of the scene's own files: the `<path>`s,
    /// absolute, in file order.
    pub search_folders: Vec<PathBuf>,
    /// The files that were read because of an `<include>`, in the order of reading.
    pub includes: Vec<Include>,
    /// Whether the text uses `$length_unit`, or has a `<default>` of that name that is no unit. Then the unit of the
    /// scene must be neither added nor removed.
    pub uses_unit_name: bool,
    /// Whether the document was made from a file of another format. Spans then tell where things come from, but there
    /// is no such text.
    pub imported: bool,
    /// The id of the light that stands in where nothing lights the scene of a file of another format. It is no part of
    /// the file's content.
    pub stand_in_light: Option<String>,
    /// Permits the files that the scene may read.
    pub access: Access,
    /// The problems with the file, and the texts that messages and revisions point into.
    pub diagnostics: Diagnostics,
}

impl Document {
    /// One that was not read from a file; `path` is where it will be written.
    pub fn new(path: impl Into<PathBuf>, root: Object) -> Self {
        Self {
            path: path.into(),
            root: Arc::new(root),
            crowds: Vec::new(),
            time: 0.0,
            search_folders: Vec::new(),
            includes: Vec::new(),
            uses_unit_name: false,
            imported: false,
            stand_in_light: None,
            access: Access::everywhere(),
            diagnostics: Diagnostics::default(),
        }
    }

    /// The paths that a file named at `span` may have, most likely first: beside the file that names it, beside the
    /// main file, then in the search folders, the last one first. An absolute name is its own only candidate.
    pub(crate) fn file_candidates(&self, name: &str, span: Span) -> Vec<PathBuf> {
        let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).to_owned();
        let beside = self.diagnostics.source(span.source).map(|source| folder(&source.path));
        let folders: Vec<PathBuf> = beside.into_iter().chain([folder(&self.path)]).collect();
        file_candidates(name, &folders, &self.search_folders)
    }

    /// The first of the places in that order where there is a file that the scene may read.
    pub fn find_file(&self, name: &str, span: Span) -> Option<PathBuf> {
        self.access.find(&self.file_candidates(name, span)).cloned()
    }
}
