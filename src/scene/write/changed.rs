//! Finds files of a scene that others changed since they were read here. Saving checks for them before it writes, so
//! that two windows (or a window and a text editor) on one file do not overwrite each other's work.
//!
//! Contents are compared, not times: a file that was written again with the same content has not changed. Among windows
//! of this program the folder is locked from the comparison until the files are replaced; a write by a text editor
//! between the last comparison and the replacement cannot be detected.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use bevy::prelude::*;

use super::error::SaveError;
use crate::document::source::read_text;
use crate::document::{Severity, SourceError, SourceFile};
use crate::files::{Access, FileError, FileSet, FolderBusy, FolderLock, lock_folder};
use crate::scene::assets::SceneDefines;
use crate::scene::assets::scene_asset::load_document;
use crate::scene::components::moment::shown_time;
use crate::scene::file::file_moment::follow_file;
use crate::scene::file::known::{KnownTexts, is_text_of};
use crate::scene::load::loading;
use crate::scene::load::spawn;
use crate::scene::read::{self, settle};
use crate::scene::{AuthoredScene, SceneAccess};

/// The treatment of files that were changed by others since they were read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnChange {
    /// Merges their changes first. An error if a thing was edited both there and here.
    Refuse,
    /// Merges their changes first. If a thing was edited on both sides the file's edit counts, as in a reload.
    TakeIn,
    /// Overwrites the files with the scene as it is here. The changes of others are lost.
    Overwrite,
}

/// A file that saving may replace, with its expected content.
pub(super) struct Expected {
    path: PathBuf,
    /// The file as it was read; None if the scene was not read from it.
    read: Option<SourceFile>,
    known: Vec<Option<String>>,
}

#[derive(Debug, PartialEq)]
enum Found {
    AsRead,
    /// With a text that was written here, but could not be read again.
    AsKnown,
    Gone,
    Changed,
}

/// The files that saving at `target` replaces, with their expected content: all files that the scene was read from, if
/// it keeps its path.
pub(super) fn expected_files(world: &World, target: &Path) -> Vec<Expected> {
    let known = world.get_resource::<KnownTexts>().cloned().unwrap_or_default();
    let known_of = |path: &Path| -> Vec<Option<String>> {
        let of_path = known.0.iter().filter(|(known, _)| known == path);
        of_path.map(|(_, text)| text.clone()).collect()
    };
    let origin = world
        .get_resource::<AuthoredScene>()
        .and_then(|scene| scene.origin.clone());
    let origin = origin.filter(|origin| !origin.imported && settle(&origin.path) == target);
    let Some(origin) = origin else {
        let known = known_of(target);
        let path = target.to_owned();
        let read = None;
        return match known.is_empty() {
            true => Vec::new(),
            false => vec![Expected { path, read, known }],
        };
    };
    let sources = origin.diagnostics.sources.iter();
    sources
        .map(|source| {
            let path = settle(&source.path);
            let known = known_of(&path);
            let read = Some(source.clone());
            Expected { path, read, known }
        })
        .collect()
}

impl Expected {
    /// Whether it is the file at this settled path.
    pub(super) fn is(&self, path: &Path) -> bool {
        self.path == path
    }

    /// Whether it is the file at this path, and had this text when it was read.
    pub(super) fn is_read_as(&self, path: &Path, source: &SourceFile) -> bool {
        let is_same = |read: &SourceFile| (&read.text, read.byte_order_mark) == (&source.text, source.byte_order_mark);
        self.is(path) && self.read.as_ref().is_some_and(is_same)
    }

    /// Reads the present file. An error if there is a folder or a device, which must not be replaced.
    fn look(&self) -> Result<Found, SaveError> {
        let text = match read_text(&self.path) {
            Ok(text) => text,
            Err(SourceError::Unreadable { source, .. }) if source.is_not_found() => return Ok(Found::Gone),
            Err(error) if is_no_file(&error) => return Err(SaveError::NoFile(error)),
            // The file has other content now.
            Err(_) => return Ok(Found::Changed),
        };
        let is_as_read = self.read.as_ref().is_some_and(|source| is_text_of(source, &text));
        let is_known = self.known.iter().any(|known| known.as_ref() == Some(&text));
        Ok(match (is_as_read, is_known) {
            (true, _) => Found::AsRead,
            (false, true) => Found::AsKnown,
            (false, false) => Found::Changed,
        })
    }
}

fn is_no_file(error: &SourceError) -> bool {
    let SourceError::Unreadable { source, .. } = error else {
        return false;
    };
    matches!(source, FileError::Folder | FileError::NotRegular { .. })
}

/// The permission of the scene after it is saved at `target`.
pub(super) fn access(world: &World, target: &Path) -> Access {
    let mut access = SceneAccess::of(world);
    if let Some(folder) = target.parent() {
        access.allow(folder);
        // The target may be a link, which the user has named.
        access.allow(target);
    }
    access
}

/// Merges changes by others in the files of the scene before it is saved at `target`.
pub(super) fn take_in_changes(world: &mut World, target: &Path, on_change: OnChange) -> Result<(), SaveError> {
    let expected = expected_files(world, target);
    let mut changed = Vec::new();
    for file in &expected {
        if file.look()? == Found::Changed {
            changed.push(file);
        }
    }
    let Some(first) = changed.first() else {
        return Ok(());
    };
    let path = first.path.clone();
    if first.read.is_none() {
        let edited_twice = None;
        return Err(SaveError::Changed { path, edited_twice });
    }
    let defines = world.get_resource::<SceneDefines>();
    let defines = defines.map_or_else(Vec::new, |all| all.get(target));
    let access = access(world, target);
    let document = load_document(target, &defines, access).map_err(|error| SaveError::Broken {
        path: path.clone(),
        reason: error.to_string(),
    })?;
    let mut document = document.at(shown_time(world));
    let scene = read::read(&mut document);
    let diagnostics = document.diagnostics;
    let mut errors = diagnostics.list.iter();
    if let Some(error) = errors.find(|diagnostic| diagnostic.severity == Severity::Error) {
        let reason = diagnostics.line(error);
        return Err(SaveError::Broken { path, reason });
    }
    follow_file(world);
    let names = spawn::edited_twice(world, &scene);
    if on_change == OnChange::Refuse && !names.is_empty() {
        let edited_twice = Some(names);
        return Err(SaveError::Changed { path, edited_twice });
    }
    loading::take_in_read(world, scene, diagnostics.into());
    Ok(())
}

/// Writes the files and those of the set unless an expected one has changed; returns the written texts, or None.
/// Missing expected files are written again, also those that an unreadable save has left otherwise than they were read,
/// and with `overwrites` changed ones are replaced.
pub(super) fn replace_files(
    expected: &[Expected],
    files: Vec<(PathBuf, String)>,
    mut set: FileSet,
    overwrites: bool,
) -> Result<Option<Vec<(PathBuf, String)>>, SaveError> {
    let mut all = Vec::new();
    for file in expected {
        match file.look()? {
            Found::AsRead => continue,
            Found::Changed if !overwrites => return Ok(None),
            Found::AsKnown | Found::Changed | Found::Gone => {}
        }
        let is_written = files.iter().any(|(path, _)| *path == file.path);
        if let Some(source) = file.read.as_ref().filter(|_| !is_written) {
            all.push((file.path.clone(), source.with_mark()));
        }
    }
    all.extend(files);
    for (path, text) in &all {
        set.add(path, text)?;
    }
    set.replace()?;
    Ok(Some(all))
}

/// The longest wait for another window, which needs a fraction of it for a save.
const LONGEST_WAIT: Duration = Duration::from_secs(5);

/// Locks the folders in which a save may write. Waits for other windows that are saving there, but not for ever: one of
/// them may hang.
pub(super) fn lock_folders(world: &World, target: &Path) -> Result<Vec<FolderLock>, SaveError> {
    let origin = world.get_resource::<AuthoredScene>();
    let origin = origin.and_then(|scene| scene.origin.as_ref());
    let sources = origin.into_iter().flat_map(|origin| &origin.diagnostics.sources);
    let files = sources.map(|source| settle(&source.path)).chain([target.to_owned()]);
    // All windows lock the folders in the same order, so that no two wait for each other.
    let folders: BTreeSet<PathBuf> = files
        .filter_map(|file| {
            let file = file.canonicalize().unwrap_or(file);
            Some(file.parent()?.to_owned())
        })
        .collect();
    let lock = |folder: PathBuf| lock_folder(&folder, LONGEST_WAIT).map_err(|FolderBusy| SaveError::Locked { folder });
    folders.into_iter().map(lock).collect()
}
