//! A parsed scene file: its tree of plugins and all other information in its text.
//!
//! The unit of length of a scene, which a file declares as `<default name="length_unit" value="cm"/>`.
//!
//! It is a `default` because other readers of the format accept unknown names there. In the tree it is a property of
//! the scene.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use smol_str::SmolStr;

use super::paths::file_candidates;
use super::{Category, Child, Crowd, Diagnostics, Object, SourceId, Span};
use crate::files::Access;

/// An `<include>`; there is one for each time that it was read.
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
    /// The `<scene>` without its crowds. It is shared, because saving needs the tree as it was read, which may be very
    /// large.
    pub root: Arc<Object>,
    /// The crowds in the order of their positions among the children of the root. An imported document has none.
    pub crowds: Vec<Crowd>,
    /// The time in seconds at which animated properties are evaluated.
    pub time: f64,
    /// The folders in which files are searched besides the folders of the scene's own files: the `<path>`s, absolute,
    /// in file order.
    pub search_folders: Vec<PathBuf>,
    /// The files that were read because of an `<include>`, in the order of reading.
    pub includes: Vec<Include>,
    /// The names among [`UNIT`] and [`LIGHT_UNITS`] that the text uses as `$name`, or for a `<default>` that is no
    /// unit. These units of the scene must be neither added nor removed.
    pub taken_unit_names: Vec<&'static str>,
    /// Whether the document was imported from another format. Spans then point into the original file, whose text is
    /// not this format.
    pub imported: bool,
    /// The id of the light that is added where nothing lights a scene of another format. It is no part of the file's
    /// content.
    pub stand_in_light: Option<String>,
    /// The access rights of the scene to files.
    pub access: Access,
    /// The messages about the file, and the texts into which messages and revisions point.
    pub diagnostics: Diagnostics,
}

impl Document {
    /// A document that was not read from a file; `path` is where it will be written.
    pub fn new(path: impl Into<PathBuf>, root: Object) -> Self {
        Self {
            path: path.into(),
            root: Arc::new(root),
            crowds: Vec::new(),
            time: 0.0,
            search_folders: Vec::new(),
            includes: Vec::new(),
            taken_unit_names: Vec::new(),
            imported: false,
            stand_in_light: None,
            access: Access::everywhere(),
            diagnostics: Diagnostics::default(),
        }
    }

    /// The candidate paths of a file named at `span`, most likely first: beside the file that names it, beside the main
    /// file, then in the search folders, the last one first. An absolute name is its own only candidate.
    pub(crate) fn file_candidates(&self, name: &str, span: Span) -> Vec<PathBuf> {
        let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).to_owned();
        let beside = self.diagnostics.source(span.source).map(|source| folder(&source.path));
        let folders: Vec<PathBuf> = beside.into_iter().chain([folder(&self.path)]).collect();
        file_candidates(name, &folders, &self.search_folders)
    }

    /// The first of these candidates that exists and that the scene may read.
    pub fn find_file(&self, name: &str, span: Span) -> Option<PathBuf> {
        self.access.find(&self.file_candidates(name, span)).cloned()
    }
}

/// The name of the `default`, and of the property, with the unit of length.
pub const UNIT: &str = "length_unit";
/// The name of the `default`, and of the property, with the units in which lights are shown.
pub const LIGHT_UNITS: &str = "light_units";
/// The units in which a scene is shown and typed, with their values. With another value one is a `default` like any
/// other.
pub(super) const SCENE_UNITS: [(&str, &[&str]); 2] = [
    (UNIT, &["m", "cm", "mm", "in", "ft"]),
    (LIGHT_UNITS, &["radiometric", "photometric"]),
];

/// The unit of the scene that a `default` directly inside `object` declares, by its name; None for another `default`.
pub(super) fn scene_unit(object: &Object, name: &str, value: &str) -> Option<&'static str> {
    let is_it = |(unit, values): &(&str, &[&str])| *unit == name && values.contains(&value);
    let (unit, _) = SCENE_UNITS.into_iter().find(is_it)?;
    (object.category == Category::Scene).then_some(unit)
}

/// The name of the property that a `default` declares in the object around it, as in `<default name="health: integer"
/// value="100"/>`: the property's own name, a colon and its type. None for a plain `default`, whose name has no colon.
/// Other readers of the format take it for an unused name.
pub fn property_name(name: &str) -> Option<SmolStr> {
    let (own, kind) = name.rsplit_once(':')?;
    let (own, kind) = (own.trim(), kind.trim());
    (!own.is_empty() && !kind.is_empty()).then(|| format!("{own}: {kind}").into())
}

/// The objects with ids. In a parsed document ids are unique and references form no cycle; references without target
/// have been reported.
#[derive(Debug, Default)]
pub struct Index<'a> {
    by_id: HashMap<&'a str, &'a Object>,
}

impl<'a> Index<'a> {
    /// Visits the whole tree under `root`. If an id occurs twice, one of the two objects is found.
    pub fn new(root: &'a Object) -> Self {
        let mut by_id = HashMap::new();
        let mut waiting = vec![root];
        while let Some(object) = waiting.pop() {
            if let Some(id) = &object.id {
                by_id.entry(id.as_str()).or_insert(object);
            }
            waiting.extend(object.objects());
        }
        Self { by_id }
    }

    /// Returns the object with this id.
    pub fn get(&self, id: &str) -> Option<&'a Object> {
        self.by_id.get(id).copied()
    }

    /// The object itself or the referenced one. None if the reference has no target.
    pub fn resolve(&self, child: &'a Child) -> Option<&'a Object> {
        match child {
            Child::Object(object) => Some(object),
            Child::Reference { id, .. } => self.get(id),
        }
    }
}

impl Document {
    /// The index of the document, for readers that look up more than one id.
    pub fn index(&self) -> Index<'_> {
        Index::new(&self.root)
    }

    /// The object with this id; visits the whole tree.
    pub fn by_id(&self, id: &str) -> Option<&Object> {
        self.index().get(id)
    }
}
