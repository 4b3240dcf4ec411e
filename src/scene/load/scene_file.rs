//! The file of the scene.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::prelude::*;

use crate::document::{Diagnostics, Span};
use crate::scene::assets::SceneAsset;
use crate::scene::components::description::PicturePlaces;
use crate::scene::components::missing::sentence;
use crate::scene::{FileKind, FileProblem, MissingFiles, VolumeFormat};

/// The file of the entities, and a requested one.
#[derive(Resource, Debug, Default)]
pub struct SceneFile {
    /// The handle, which keeps the asset loaded; None for a scene without a file.
    pub(in crate::scene) handle: Option<Handle<SceneAsset>>,
    /// The path; empty for a scene without a file.
    pub(in crate::scene) path: PathBuf,
    /// The requested file; None after it was read, or could not be.
    pub(in crate::scene) asked: Option<Asked>,
    /// The texts into which the spans of the entities' sources point.
    pub(in crate::scene) good_diagnostics: Arc<Diagnostics>,
    /// The spans of pictures in the same texts.
    pub(in crate::scene) picture_places: PicturePlaces,
    /// The spans of volumes in the same texts, by the paths of their assets.
    pub(in crate::scene) volume_places: PicturePlaces,
    /// The files that were missing when the same texts were read.
    pub(in crate::scene) missing: MissingFiles,
    /// Whether it was written here and not read since: an arriving reading may be older.
    pub(in crate::scene) was_written: bool,
    /// Whether changes are held back, see [`Self::hold`].
    pub(in crate::scene) is_held: bool,
}

/// A file that is to replace the scene.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Asked {
    pub handle: Handle<SceneAsset>,
    pub path: PathBuf,
    /// Whether edits since the file was last read are kept.
    pub keeps_edits: bool,
}

impl SceneFile {
    /// Whether changes of the file become changes of the entities.
    pub(crate) fn is_followed(&self) -> bool {
        self.handle.is_some()
    }

    /// Sets whether changes of this file are held back, while the user is asked about them.
    pub fn hold(&mut self, held: bool) {
        self.is_held = held;
    }

    pub(crate) fn is_held(&self) -> bool {
        self.is_held
    }

    /// Stops following the file from which the entities were read.
    pub(crate) fn leave(&mut self) {
        (self.handle, self.path) = (None, PathBuf::new());
    }

    /// A problem with a picture, at the span where it is named first, if the file names it.
    pub(in crate::scene) fn picture_problem(&self, path: &Path, what: &str) -> FileProblem {
        let what = sentence(FileKind::Picture, path, what);
        let span = self.picture_places.get(path).copied();
        FileProblem::new(path, span, what, &self.good_diagnostics)
    }

    /// A missing picture, at the span where it is named first, if the file names it.
    pub(in crate::scene) fn missing_picture(&self, path: &Path) -> FileProblem {
        let span = self.picture_places.get(path).copied();
        self.missing_file(FileKind::Picture, path, span)
    }

    /// The missing file of a volume, whose asset has this path.
    pub(in crate::scene) fn missing_volume(&self, asset: &Path) -> FileProblem {
        let (path, _) = VolumeFormat::of_asset(asset);
        let span = self.volume_places.get(asset).copied();
        self.missing_file(FileKind::Volume, path, span)
    }

    /// A missing file, named at this span.
    pub(in crate::scene) fn missing_file(&self, kind: FileKind, path: &Path, span: Option<Span>) -> FileProblem {
        FileProblem::of_missing(kind, path, span, self.missing.get(path), &self.good_diagnostics)
    }

    /// The place where the scene file names a volume first, whose asset has this path: file, line and column.
    pub(crate) fn place_of_volume(&self, asset: &Path) -> Option<String> {
        let (file, line, column) = self.good_diagnostics.locate(*self.volume_places.get(asset)?)?;
        Some(format!("{}:{line}:{column}", file.display()))
    }

    /// A problem with the file of a volume, whose asset has this path, at the span where it is named first.
    pub(in crate::scene) fn volume_problem(&self, asset: &Path, what: &str) -> FileProblem {
        let (path, _) = VolumeFormat::of_asset(asset);
        let what = sentence(FileKind::Volume, path, what);
        let span = self.volume_places.get(asset).copied();
        FileProblem::new(path, span, what, &self.good_diagnostics)
    }
}
