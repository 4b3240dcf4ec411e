//! The state of the open scene and of its loading, and the request to open another.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::listed::listed;
use super::missing::{NOT_THERE, sentence, with_replacement};
use crate::document::{Diagnostics, Severity, Span};
use crate::scene::{FileKind, Lens, MissingFile};

/// Asks for a scene file. The open scene is replaced once the new one is read.
#[derive(Message, Clone, Debug, Default, PartialEq, Eq)]
pub struct OpenScene {
    /// The path of the scene file, relative to the working directory.
    pub path: PathBuf,
    /// The values for the file's `$name` parameters; they override its `<default>`s.
    pub defines: Vec<(String, String)>,
    /// Whether edits since the file was read are kept if it is the open file, as after changes on disk. Otherwise they
    /// are lost.
    pub keeps_edits: bool,
}

/// A mesh, a picture or a volume of the scene has changed on disk, and its new content is in use.
#[derive(Message, Clone, Debug, PartialEq, Eq)]
pub struct FileReadAgain(pub PathBuf);

/// The progress of the scene that was requested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SceneState {
    /// No scene has been opened.
    #[default]
    Empty,
    /// A scene is being read; entities may still belong to the previous one.
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
    /// The span where the scene file names it, in the diagnostics of the last good load.
    pub span: Option<Span>,
    /// One sentence that begins with the file.
    pub what: String,
    /// The sentence with the place in the scene file before it (`file:line:column: `), if known.
    pub message: String,
    /// Advice.
    pub help: Option<String>,
    /// The kind of the file, if it is missing.
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

    /// The problem of a missing file; `noted`: the facts noted when the scene was read.
    pub(in crate::scene) fn of_missing(
        kind: FileKind,
        path: &Path,
        span: Option<Span>,
        noted: Option<&MissingFile>,
        diagnostics: &Diagnostics,
    ) -> Self {
        let what = noted.map_or_else(|| NOT_THERE.to_owned(), MissingFile::what);
        let what = match kind {
            FileKind::Picture => with_replacement(path, &what),
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
    /// The file of the entities, absolute; None for a scene without a file.
    pub path: Option<PathBuf>,
    /// The file that was requested last, absolute, while it is being read and after that has failed.
    pub asked: Option<PathBuf>,
    /// Whether the present content of `path` cannot be read, for instance while it is being edited.
    pub file_is_broken: bool,
    /// The progress of the scene that was requested last.
    pub state: SceneState,
    /// Whether the entities of a scene are being made, so that only some of them exist.
    pub is_opening: bool,
    /// The diagnostics of the last attempt, failed or not.
    pub diagnostics: Arc<Diagnostics>,
    /// The mesh files that could not be read, each once. Their shapes are not in the picture, or have the last readable
    /// mesh.
    pub mesh_errors: Vec<FileProblem>,
    /// Warnings of the mesh readers about parts that were left out or repaired.
    pub mesh_warnings: Vec<FileProblem>,
    /// The number of meshes that are loading for the first time.
    pub meshes_loading: usize,
    /// The missing pictures. Grey replaces them, or their last readable content.
    pub picture_problems: Vec<FileProblem>,
    /// The unreadable pictures. Grey replaces them, or their last readable content.
    pub damaged_pictures: Vec<FileProblem>,
    /// The pictures of lights that have negative pixels.
    pub picture_warnings: Vec<FileProblem>,
    /// The number of pictures that are loading for the first time.
    pub pictures_loading: usize,
    /// The volume files that could not be read. They are left out, or have their last readable content.
    pub volume_errors: Vec<FileProblem>,
    /// The repaired volumes: they had values that are negative or NaN.
    pub volume_warnings: Vec<FileProblem>,
    /// The number of volumes that are loading for the first time.
    pub volumes_loading: usize,
    /// The files of the scene, itself among them, that were removed from the disk; their content stays.
    pub files_gone: Vec<PathBuf>,
    /// Counts successful loads and reloads.
    pub revision: u64,
    /// Counts failed attempts.
    pub failures: u64,
    /// The files of the scene whose text had changed at the last reload: the scene's own file and its includes.
    pub files_read_again: Vec<PathBuf>,
    /// Whether the last successful load opened a new scene, and did not reload the open one.
    pub fresh_load: bool,
    /// The changes by the last reload.
    pub reload: ReloadSummary,
    /// Whether missing files are only warnings, so that the picture is rendered without them.
    pub allows_missing: bool,
}

impl SceneStatus {
    /// The file of the state and the diagnostics.
    pub fn subject(&self) -> Option<&Path> {
        self.asked.as_deref().or(self.path.as_deref())
    }

    /// The number of files that textures, shapes and media wait for.
    pub fn files_loading(&self) -> usize {
        self.meshes_loading + self.pictures_loading + self.volumes_loading
    }

    /// Whether every entity exists and every mesh, picture and volume has arrived or failed.
    pub fn is_complete(&self) -> bool {
        self.state == SceneState::Ready && self.files_loading() == 0
    }

    /// The diagnostics and the problems with meshes, pictures and volumes, all as diagnostics.
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

    /// Whether a part of the scene is missing. Unreadable pictures do not count, since the rest can be shown.
    pub fn has_errors(&self) -> bool {
        let mut files = self.mesh_errors.iter().chain(&self.volume_errors);
        self.state == SceneState::Failed
            || self.diagnostics.has_errors()
            || files.any(|problem| !self.allows_missing || problem.missing.is_none())
    }

    /// The problems of missing files: meshes, then volumes, then pictures.
    pub fn missing_files(&self) -> impl Iterator<Item = &FileProblem> {
        let all = self.mesh_errors.iter().chain(&self.volume_errors);
        all.chain(&self.picture_problems)
            .filter(|problem| problem.missing.is_some())
    }

    /// Whether missing files are all that keeps the scene from being shown.
    pub fn lacks_only_files(&self) -> bool {
        let mut files = self.mesh_errors.iter().chain(&self.volume_errors);
        self.has_errors()
            && self.state != SceneState::Failed
            && !self.diagnostics.has_errors()
            && self.damaged_pictures.is_empty()
            && files.all(|problem| problem.missing.is_some())
    }
}

/// The sensor that takes the picture; None without a scene.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ActiveSensor(pub Option<Entity>);

/// The view after navigation away from its sensor. No part of the scene.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub struct FreeView {
    /// World from camera, as a sensor's [`crate::scene::ToWorld`]; None for the sensor's own.
    pub pose: Option<Affine3A>,
    /// The lens that replaces the sensor's; None for the sensor's own.
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

/// The most things that a message about a reload names.
const MOST_NAMED: usize = 3;

/// What a reload has changed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReloadSummary {
    /// The number of new things in the file.
    pub added: usize,
    /// The number of things that changed in the file and were not edited here.
    pub changed: usize,
    /// The number of things removed from the file.
    pub removed: usize,
    /// The number of things that keep edits which are not in the file.
    pub kept: usize,
    /// The names of things edited both here and in the file; the file's edit counts.
    pub replaced: Vec<String>,
    /// The number of things renamed here, because a new thing in the file has their name.
    pub renamed: usize,
}

impl ReloadSummary {
    /// Whether the entities are unchanged.
    pub fn is_unchanged(&self) -> bool {
        self.added + self.changed + self.removed + self.renamed == 0 && self.replaced.is_empty()
    }

    /// The text, such as "2 things changed, 1 new, 3 edits kept"; empty if there are no changes.
    pub fn text(&self) -> String {
        let parts = [
            (self.changed, "changed"),
            (self.added, "new"),
            (self.removed, "gone"),
            (self.kept, "with edits kept"),
            (self.renamed, "renamed here, for the file now has their names"),
        ];
        let parts = parts.iter().filter(|(count, _)| *count > 0);
        let mut parts: Vec<String> = parts.map(|(count, what)| format!("{count} {what}")).collect();
        if !self.replaced.is_empty() {
            let names = listed(&self.replaced, MOST_NAMED);
            parts.push(format!("{names} edited on both sides, the file's edit taken"));
        }
        parts.join(", ")
    }
}
