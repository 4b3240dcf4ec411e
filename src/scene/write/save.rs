//! Saves the entities as a file, which becomes the file of the scene.
//!
//! A save has three parts. The scene is copied from the world ([`Save::copy`]), all at once or step by step. The files
//! are written and read again, possibly on another thread ([`Save::write`]). Then the world follows the new files
//! ([`Written::follow`]), step by step as well. The scene may be edited in between: edits before the copy is complete
//! are in it, and later ones are edits of the new file. No other code may read or write files of the scene meanwhile.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::prelude::World;

use super::changed::{Expected, OnChange, access, expected_files, lock_folders, replace_files, take_in_changes};
use super::error::SaveError;
use super::past::{GivenId, PastFile};
use super::rebase::{Marks, Old, Pairing, Rebase};
use super::snapshot::Snapshot;
use super::{copy_parts, home, plan};
use crate::document::{self, Diagnostics};
use crate::files::{Access, FileSet, FolderLock};
use crate::scene::assets::SceneDefines;
use crate::scene::assets::scene_asset::load_document;
use crate::scene::file::known::KnownTexts;
use crate::scene::load::loading;
use crate::scene::read::{self, settle};
use crate::scene::{SceneDescription, SceneWatch};

/// How often files are read again that change between reading and replacing them.
pub(crate) const MOST_ATTEMPTS: usize = 5;

/// [`save_with`] using [`OnChange::Refuse`].
pub fn save(world: &mut World, path: &Path) -> Result<Option<String>, SaveError> {
    save_with(world, path, OnChange::Refuse)
}

/// Saves the entities, see [`super::save_description`]; they become the scene of that file. Changes by others to the
/// files of the scene since they were read are treated according to `on_change`. Returns a sentence if the file cannot
/// be opened again: nothing is lost, but something in it needs repair.
pub fn save_with(world: &mut World, path: &Path, on_change: OnChange) -> Result<Option<String>, SaveError> {
    save_over(world, path, on_change, |_| None).map(|saved| saved.trouble)
}

/// [`save_with`] over the text of the past file that `choose` returns.
pub(crate) fn save_over(
    world: &mut World,
    path: &Path,
    on_change: OnChange,
    choose: impl Fn(&mut World) -> Option<Arc<PastFile>>,
) -> Result<Saved, SaveError> {
    for _ in 0..MOST_ATTEMPTS {
        let mut save = Save::begin(world, path, on_change)?;
        save.past = choose(world);
        while !save.copy(world, usize::MAX) {}
        if let Some(written) = save.write()? {
            let mut following = written.follow(world);
            while !following.step(world, usize::MAX) {}
            return Ok(following.finish().0);
        }
    }
    Err(SaveError::Restless { path: settle(path) })
}

/// The result of a save.
pub(crate) struct Saved {
    /// The reason why the file cannot be opened again as it is.
    pub trouble: Option<String>,
    /// The former file.
    pub before: Option<PastFile>,
    /// The ids that things got.
    pub given: Vec<GivenId>,
}

/// A save in progress.
pub(crate) struct Save {
    target: PathBuf,
    overwrites: bool,
    scene: Snapshot,
    /// Further data of the world, once the scene is copied.
    rest: Option<Rest>,
    /// A former state of the file, whose text is closer to the scene than the present one.
    pub past: Option<Arc<PastFile>>,
    /// The locked folders, until the world follows.
    locks: Vec<FolderLock>,
}

struct Rest {
    marks: Marks,
    expected: Vec<Expected>,
    /// The values of the scene's `$name`s at its former path.
    defines: Option<Vec<(String, String)>>,
    access: Access,
}

impl Save {
    /// Begins to copy the scene. Changes by others to its files since they were read are treated first, according to
    /// `on_change`.
    pub fn begin(world: &mut World, path: &Path, on_change: OnChange) -> Result<Self, SaveError> {
        let target = settle(path);
        // The content of an include or a mesh would be lost, and the new file would include itself.
        let watch = world.get_resource::<SceneWatch>();
        if watch.is_some_and(|watch| watch.has_part(&target)) {
            return Err(SaveError::InUse { path: target });
        }
        let locks = lock_folders(world, &target)?;
        let overwrites = on_change == OnChange::Overwrite;
        if !overwrites {
            take_in_changes(world, &target, on_change)?;
        }
        Ok(Self {
            target,
            overwrites,
            scene: Snapshot::begin(world),
            rest: None,
            past: None,
            locks,
        })
    }

    /// Copies this number of things. True once the copy is complete; then the save has to be written.
    pub fn copy(&mut self, world: &mut World, things: usize) -> bool {
        if self.rest.is_none() && self.scene.step(world, things) {
            let defines = world.get_resource::<SceneDefines>();
            self.rest = Some(Rest {
                defines: defines.map(|all| all.get(&home(self.scene.settings(), &self.target))),
                marks: Marks::of(world),
                expected: expected_files(world, &self.target),
                access: access(world, &self.target),
            });
        }
        self.rest.is_some()
    }

    /// Writes the files, and reads them again. None, without writing, if the scene is not copied, or if others have
    /// changed the files since the save began.
    pub fn write(self) -> Result<Option<Written>, SaveError> {
        let Self { target, rest, past, .. } = self;
        let Some(rest) = rest else {
            return Ok(None);
        };
        let (mut scene, entities) = self.scene.describe();
        let past = past
            .filter(|past| past.is_at(&target))
            .filter(|past| past.put_under(&mut scene, &entities, &rest.expected));
        let time = scene.time;
        let (mut files, moves) = plan(&scene, &target)?;
        if let Some(past) = past {
            files = past.with_others(files, &rest.expected);
        }
        let mut set = FileSet::new(&target);
        copy_parts(&moves, &mut set)?;
        let Some(files) = replace_files(&rest.expected, files, set, self.overwrites)? else {
            return Ok(None);
        };
        let defines = rest.defines.as_deref().unwrap_or_default();
        let reading = read_again(&target, defines, rest.access, time).map(|(read, diagnostics)| {
            let pairing = Pairing::new(scene, entities, rest.marks, read);
            (pairing.rebase(), Arc::new(diagnostics))
        });
        Ok(Some(Written {
            target,
            files,
            defines: rest.defines,
            reading,
            locks: self.locks,
        }))
    }
}

/// Reads the written file at the shown time. An error if it cannot be read.
fn read_again(
    target: &Path,
    defines: &[(String, String)],
    access: Access,
    time: f64,
) -> Result<(SceneDescription, Diagnostics), String> {
    let document = load_document(target, defines, access).map_err(|error| error.to_string())?;
    let mut document = document.at(time);
    let read = read::read(&mut document);
    let diagnostics = document.diagnostics;
    let is_error = |diagnostic: &&document::Diagnostic| diagnostic.severity == document::Severity::Error;
    match diagnostics.list.iter().find(is_error) {
        Some(first) => Err(diagnostics.line(first)),
        None => Ok((read, diagnostics)),
    }
}

/// The written files, with their content read again.
pub(crate) struct Written {
    target: PathBuf,
    files: Vec<(PathBuf, String)>,
    defines: Option<Vec<(String, String)>>,
    reading: Result<(Result<Rebase, Box<Pairing>>, Arc<Diagnostics>), String>,
    locks: Vec<FolderLock>,
}

impl Written {
    /// Begins to update the entities to the file.
    pub fn follow(self, world: &mut World) -> Following {
        world.get_resource_or_init::<KnownTexts>().note_written(self.files);
        if let Some((all, defines)) = world.get_resource::<SceneDefines>().zip(self.defines) {
            all.set(self.target.clone(), defines);
        }
        let reading = self.reading.map(|(rebase, diagnostics)| {
            let rebase = rebase.unwrap_or_else(|pairing| pairing.rebase_with(|| world.spawn_empty().id()));
            (rebase, diagnostics)
        });
        let (rest, trouble) = match reading {
            Ok(rest) => (Some(rest), None),
            Err(trouble) => (None, Some(trouble)),
        };
        Following {
            target: self.target,
            rest,
            trouble,
            old: None,
            _locks: self.locks,
        }
    }
}

/// The last part of a save, which updates the entities to the file.
pub(crate) struct Following {
    target: PathBuf,
    /// None after that, or if the file could not be read.
    rest: Option<(Rebase, Arc<Diagnostics>)>,
    trouble: Option<String>,
    /// The known state of the former file.
    old: Option<Old>,
    _locks: Vec<FolderLock>,
}

impl Following {
    /// Updates this number of things; true once all are done.
    pub fn step(&mut self, world: &mut World, things: usize) -> bool {
        let Some((rebase, _)) = &mut self.rest else {
            return true;
        };
        if !rebase.step(world, things) {
            return false;
        }
        if let Some((rebase, diagnostics)) = self.rest.take() {
            let (written, old) = rebase.finish(world);
            self.old = Some(old);
            world.get_resource_or_init::<KnownTexts>().forget();
            loading::follow_file(world, &self.target, diagnostics, &written);
        }
        true
    }

    /// The result of the save, and unused data, which takes time to drop after saving a large scene.
    pub fn finish(self) -> (Saved, impl Send + use<>) {
        let mut old = self.old;
        let saved = Saved {
            trouble: self.trouble,
            before: old.as_ref().and_then(Old::file),
            given: old
                .as_mut()
                .map(|old| std::mem::take(&mut old.given))
                .unwrap_or_default(),
        };
        (saved, old)
    }
}
