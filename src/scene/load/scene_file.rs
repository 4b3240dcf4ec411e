//! The file of the scene.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::prelude::*;

use crate::document::{Diagnostics, Span};
use crate::scene::assets::SceneAsset;
use crate::scene::components::description::PicturePlaces;
use crate::scene::components::missing::sentence;
use crate::scene::{FileKind, FileProblem, MissingFiles, VolumeFormat};

/// The file that the entities are from, and the one that was requested since.
#[derive(Resource, Debug, Default)]
pub struct SceneFile {
    /// The handle, which keeps the asset loaded; None for a scene of no file.
    pub(in crate::scene) handle: Option<Handle<SceneAsset>>,
    /// The path; empty for a scene of no file.
    pub(in crate::scene) path: PathBuf,
    /// The requested file; None once it was read, or could not be.
    pub(in crate::scene) asked: Option<Asked>,
    /// The texts that the spans of the entities' sources point into.
    pub(in crate::scene) good_diagnostics: Arc<Diagnostics>,
    /// The places of pictures in the same texts.
    pub(in crate::scene) picture_places: PicturePlaces,
    /// The places of volumes in the same texts, by the paths of their assets.
    pub(in crate::scene) volume_places: PicturePlaces,
    /// The files that were missing when the same texts were read.
    pub(in crate::scene) missing: MissingFiles,
    /// It was written here, and nothing has been read of it since: what arrives may have been read before.
    pub(in crate::scene) was_written: bool,
    /// Whether changes are held back, see [`Self::hold`].
    pub(in crate::scene) is_held: bool,
}

/// A file that is to become the scene.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Asked {
    pub handle: Handle<SceneAsset>,
    pub path: PathBuf,
    /// Whether edits since the file was last read are kept.
    pub keeps_edits: bool,
}

impl SceneFile {
    /// Whether there is a file whose changes become changes of the entities.
    pub(crate) fn is_followed(&self) -> bool {
        self.handle.is_some()
    }

    /// Sets whether changes of this file are held back: the user is being asked about them.
    pub fn hold(&mut self, held: bool) {
        self.is_held = held;
    }

    pub(crate) fn is_held(&self) -> bool {
        self.is_held
    }

    /// Stops following the file that the entities were read from.
    pub(crate) fn leave(&mut self) {
        (self.handle, self.path) = (None, PathBuf::new());
    }

    /// A problem with a picture, at the place where it is named first, if the file names it.
    pub(in crate::scene) fn picture_problem(&self, path: &Path, what: &str) -> FileProblem {
        let what = sentence(FileKind::Picture, path, what);
        let span = self.picture_places.get(path).copied();
        FileProblem::new(path, span, what, &self.good_diagnostics)
    }

    /// A picture that is not there, at the place where it is named first, if the file names it.
    pub(in crate::scene) fn missing_picture(&self, path: &Path) -> FileProblem {
        let span = self.picture_places.get(path).copied();
        self.missing_file(FileKind::Picture, path, span)
    }

    /// The file of a volume that is not there, whose asset has this path.
    pub(in crate::scene) fn missing_volume(&self, asset: &Path) -> FileProblem {
        let (path, _) = VolumeFormat::of_asset(asset);
        let span = self.volume_places.get(asset).copied();
        self.missing_file(FileKind::Volume, path, span)
    }

    /// A file that is not there, named at this place.
    pub(in crate::scene) fn missing_file(&self, kind: FileKind, path: &Path, span: Option<Span>) -> FileProblem {
        FileProblem::of_missing(kind, path, span, self.missing.get(path), &self.good_diagnostics)
    }

    /// Where the scene file names a volume first, whose asset has this path: file, line and column.
    pub(crate) fn place_of_volume(&self, asset: &Path) -> Option<String> {
        let (file, line, column) = self.good_diagnostics.locate(*self.volume_places.get(asset)?)?;
        Some(format!("{}:{line}:{column}", file.display()))
    }

    /// A problem with the file of a volume, whose asset has this path, at the place where it is named first.
    pub(in crate::scene) fn volume_problem(&self, asset: &Path, what: &str) -> FileProblem {
        let (path, _) = VolumeFormat::of_asset(asset);
        let what = sentence(FileKind::Volume, path, what);
        let span = self.volume_places.get(asset).copied();
        FileProblem::new(path, span, what, &self.good_diagnostics)
    }
}
