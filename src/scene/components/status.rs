//! The state of the open scene and of its loading, and the request to open another.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::missing::{NOT_THERE, sentence, with_grey};
use crate::document::{Diagnostics, Severity, Span};
use crate::scene::{FileKind, Lens, MissingFile};

/// Asks for a scene file. The open scene is replaced once the new one is read.
#[derive(Message, Clone, Debug, Default, PartialEq, Eq)]
pub struct OpenScene {
    /// Relative paths are meant from the working directory.
    pub path: PathBuf,
    /// The values for the file's `$name` parameters; they override its `<default>`s.
    pub defines: Vec<(String, String)>,
    /// Whether edits since the file was read are kept if it is the open file, as they are when it changes on disk.
    /// Otherwise they are lost.
    pub keeps_edits: bool,
}

/// A mesh, a picture or a volume of the scene has changed on disk, and its new content is in use.
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub struct FileReadAgain(pub PathBuf);

/// The progress of the scene that was requested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SceneState {
    /// Nothing has been opened.
    #[default]
    Empty,
    /// A scene is being read for the first time; entities may still be those of the one before.
    Loading,
    /// The entities are those of the file. Meshes may still be loading: [`SceneStatus::meshes_loading`].
    Ready,
    /// The last attempt failed; the entities are those of the last good scene, if there was one.
    Failed,
}

/// A problem with a mesh, a picture or a volume of the scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileProblem {
    /// The absolute path of the file.
    pub path: PathBuf,
    /// The place where the scene file names it, in the diagnostics of the last good load.
    pub span: Option<Span>,
    /// One sentence that begins with the file.
    pub what: String,
    /// The sentence after its place in the scene file (`file:line:column: `), where it has one.
    pub message: String,
    /// What can be done.
    pub help: Option<String>,
    /// What should be there, if there is no file.
    pub missing: Option<FileKind>,
}

impl FileProblem {
    pub(in crate::scene) fn new(path: &Path, span: Option<Span>, what: String, diagnostics: &Diagnostics) -> Self {
        let message = match span.and_then(|span| diagnostics.locate(span)) {
            Some((file, line, column)) => format!("{}:{line}:{column}: {what}", file.display()),
            None => what.clone(),
        };
        Self {
            path: path.to_owned(),
            span,
            what,
            message,
            help: None,
            missing: None,
        }
    }

    /// The problem of a file that is not there; `noted`: what was found out about it when the scene was read.
    pub(in crate::scene) fn of_missing(
        kind: FileKind,
        path: &Path,
        span: Option<Span>,
        noted: Option<&MissingFile>,
        diagnostics: &Diagnostics,
    ) -> Self {
        let what = noted.map_or_else(|| NOT_THERE.to_owned(), MissingFile::what);
        let what = match kind {
            FileKind::Picture => with_grey(&what),
            FileKind::Mesh | FileKind::Volume => what,
        };
        Self {
            help: noted.and_then(|noted| noted.help.clone()),
            missing: Some(kind),
            ..Self::new(path, span, sentence(kind, path, &what), diagnostics)
        }
    }
}

/// The state of the open scene.
#[derive(Resource, Clone, Debug, Default)]
pub struct SceneStatus {
    /// The file that the entities are from, absolute; None for a scene of no file.
    pub path: Option<PathBuf>,
    /// The file that was requested last, absolute, while it is being read and after it could not be.
    pub asked: Option<PathBuf>,
    /// Whether the file of `path` cannot be read as it is now, such as while it is being edited.
    pub file_is_broken: bool,
    /// The progress of the scene that was requested last.
    pub state: SceneState,
    /// Whether the entities of a scene that is being opened are being made, of which only some are there.
    pub is_opening: bool,
    /// The diagnostics of the last attempt, failed or not.
    pub diagnostics: Arc<Diagnostics>,
    /// The mesh files that could not be read, each once. The shapes that name them are not in the picture, or have the
    /// last mesh that could be read.
    pub mesh_errors: Vec<FileProblem>,
    /// Warnings of the mesh readers about what they left out or mended.
    pub mesh_warnings: Vec<FileProblem>,
    /// The number of meshes whose first load is not over.
    pub meshes_loading: usize,
    /// The pictures that do not exist. A grey replaces them, or the last content that could be read.
    pub picture_problems: Vec<FileProblem>,
    /// The pictures that exist and cannot be read, likewise.
    pub damaged_pictures: Vec<FileProblem>,
    /// The pictures of lights that have negative pixels.
    pub picture_warnings: Vec<FileProblem>,
    /// The number of pictures whose first load is not over.
    pub pictures_loading: usize,
    /// The volume files that could not be read. Where they would be there is nothing, or the last content that could
    /// be read.
    pub volume_errors: Vec<FileProblem>,
    /// The volumes that were mended: they had values that are negative or no numbers.
    pub volume_warnings: Vec<FileProblem>,
    /// The number of volumes whose first load is not over.
    pub volumes_loading: usize,
    /// The files of the scene, itself among them, that existed and are gone from the disk; their content stays.
    pub files_gone: Vec<PathBuf>,
    /// Counts successful loads and reloads.
    pub revision: u64,
    /// The number of attempts that failed.
    pub failures: u64,
    /// The last successful load was of a scene newly opened, not a reload of the one that was there.
    pub fresh_load: bool,
    /// The changes by the last reload.
    pub reload: ReloadSummary,
    /// Whether missing files are warnings: the picture that is wanted is one without them.
    pub allows_missing: bool,
}

impl SceneStatus {
    /// The file that the state and the diagnostics are about.
    pub fn subject(&self) -> Option<&Path> {
        self.asked.as_deref().or(self.path.as_deref())
    }

    /// The number of files that textures, shapes and media wait for.
    pub fn files_loading(&self) -> usize {
        self.meshes_loading + self.pictures_loading + self.volumes_loading
    }

    /// Whether every entity is there and every mesh, picture and volume has arrived or failed.
    pub fn is_complete(&self) -> bool {
        self.state == SceneState::Ready && self.files_loading() == 0
    }

    /// The diagnostics and the problems with meshes, pictures and volumes, as messages of the same kind.
    pub fn all_diagnostics(&self) -> Diagnostics {
        let mut all = Diagnostics::clone(&self.diagnostics);
        let allowed = |problem: &FileProblem| self.allows_missing && problem.missing.is_some();
        for (severity, problems) in [
            (Severity::Error, &self.mesh_errors),
            (Severity::Error, &self.volume_errors),
            (Severity::Error, &self.damaged_pictures),
            (Severity::Warning, &self.mesh_warnings),
            (Severity::Warning, &self.picture_problems),
            (Severity::Warning, &self.picture_warnings),
            (Severity::Warning, &self.volume_warnings),
        ] {
            for problem in problems {
                let severity = if allowed(problem) { Severity::Warning } else { severity };
                all.push(severity, problem.span, problem.what.clone(), problem.help.clone());
            }
        }
        all
    }

    /// Whether something is missing that the files ask for. Pictures that cannot be read do not count, since the rest
    /// is worth seeing.
    pub fn has_errors(&self) -> bool {
        let mut files = self.mesh_errors.iter().chain(&self.volume_errors);
        self.state == SceneState::Failed
            || self.diagnostics.has_errors()
            || files.any(|problem| !self.allows_missing || problem.missing.is_none())
    }

    /// The problems of files that are not there: meshes, then volumes, then pictures.
    pub fn missing_files(&self) -> impl Iterator<Item = &FileProblem> {
        let all = self.mesh_errors.iter().chain(&self.volume_errors);
        all.chain(&self.picture_problems)
            .filter(|problem| problem.missing.is_some())
    }

    /// Whether nothing but missing files keeps the scene from being shown.
    pub fn lacks_only_files(&self) -> bool {
        let mut files = self.mesh_errors.iter().chain(&self.volume_errors);
        self.has_errors()
            && self.state != SceneState::Failed
            && !self.diagnostics.has_errors()
            && self.damaged_pictures.is_empty()
            && files.all(|problem| problem.missing.is_some())
    }
}

/// The sensor the picture is taken with; None without a scene.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ActiveSensor(pub Option<Entity>);

/// The view that was flown away from its sensor. No part of the scene.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct FreeView {
    /// World from camera, as a sensor's [`crate::scene::ToWorld`]; None is the sensor's own.
    pub pose: Option<Affine3A>,
    /// The lens that replaces the sensor's; None is the sensor's own.
    pub lens: Option<Lens>,
}

impl FreeView {
    /// A view with the sensor's lens.
    pub fn at(world_from_camera: Affine3A) -> Self {
        Self {
            pose: Some(world_from_camera),
            lens: None,
        }
    }
}

/// The numbers of things that a reload changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReloadSummary {
    /// The number of things that are new in the file.
    pub added: usize,
    /// The number of things that changed in the file and were not edited here.
    pub changed: usize,
    /// The number of things that are no longer in the file.
    pub removed: usize,
    /// The number of things that stay as they were edited here, unlike in the file.
    pub kept: usize,
    /// The number of things that were edited here and in the file; the file's edit counts.
    pub replaced: usize,
    /// The number of things that were renamed here, because the file has something new with their name.
    pub renamed: usize,
}

impl ReloadSummary {
    /// Whether the entities are as before.
    pub fn is_unchanged(&self) -> bool {
        self.added + self.changed + self.removed + self.replaced + self.renamed == 0
    }

    /// The text, such as "2 things changed, 1 new, 3 edits kept"; empty if there is nothing to tell.
    pub fn text(&self) -> String {
        let parts = [
            (self.changed, "changed"),
            (self.added, "new"),
            (self.removed, "gone"),
            (self.kept, "with edits kept"),
            (self.replaced, "edited on both sides, the file's edit taken"),
            (self.renamed, "renamed here, for the file now has their names"),
        ];
        let parts = parts.iter().filter(|(count, _)| *count > 0);
        parts
            .map(|(count, what)| format!("{count} {what}"))
            .collect::<Vec<_>>()
            .join(", ")
    }
}
