//! Saves the entities as a file. From then on the scene is that of the file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::prelude::World;

use super::changed::{OnChange, access, expected_files, lock_folders, replace_files, take_in_changes};
use super::error::SaveError;
use super::gather::{self, Entities};
use super::known::KnownTexts;
use super::{copy_parts, home, plan};
use crate::document;
use crate::scene::assets::SceneDefines;
use crate::scene::assets::scene_asset::load_document;
use crate::scene::read::{self, settle};
use crate::scene::{SceneDescription, loading, rebase};

/// The number of times that files are read again which change between reading and replacing them.
const MOST_ATTEMPTS: usize = 5;

/// Saves as [`save_with`] and [`OnChange::Refuse`].
pub fn save(world: &mut World, path: &Path) -> Result<Option<String>, SaveError> {
    save_with(world, path, OnChange::Refuse)
}

/// Saves the entities: see [`super::save_description`]. From then on they are the scene of that file. What others changed in the files of the scene since
/// they were read is treated as `on_change` says. A sentence if the file cannot be opened again: nothing is lost, but something in it
/// needs mending.
pub fn save_with(world: &mut World, path: &Path, on_change: OnChange) -> Result<Option<String>, SaveError> {
    let target = settle(path);
    let _locks = lock_folders(world, &target)?;
    let overwrites = on_change == OnChange::Overwrite;
    for _ in 0..MOST_ATTEMPTS {
        if !overwrites {
            take_in_changes(world, &target, on_change)?;
        }
        let (scene, entities) = gather::describe_entities(world);
        let (files, moves) = plan(&scene, &target)?;
        copy_parts(&moves)?;
        if let Some(written) = replace_files(&expected_files(world, &target), files, overwrites)? {
            return Ok(follow(world, &target, &scene, &entities, written));
        }
    }
    Err(SaveError::Restless { path: target })
}

/// The entities are the scene of the file that was just written of them. The error is that it cannot be read again.
fn follow(
    world: &mut World,
    target: &Path,
    scene: &SceneDescription,
    entities: &Entities,
    written: Vec<(PathBuf, String)>,
) -> Option<String> {
    let mut known = world.get_resource_or_init::<KnownTexts>();
    known.note_written(written);
    let defines = world.get_resource::<SceneDefines>().map(|all| {
        let of_old = all.get(&home(scene, target));
        all.set(target.to_owned(), of_old.clone());
        of_old
    });
    let access = access(world, target);
    let mut document = match load_document(target, &defines.unwrap_or_default(), access) {
        Ok(document) => document,
        Err(error) => return Some(error.to_string()),
    };
    let read = read::read(&mut document);
    let diagnostics = document.diagnostics;
    let is_error = |diagnostic: &&document::Diagnostic| diagnostic.severity == document::Severity::Error;
    if let Some(first) = diagnostics.list.iter().find(is_error) {
        return Some(diagnostics.line(first));
    }
    let read = Arc::new(read);
    rebase::rebase(world, scene, entities, read.clone());
    world.resource_mut::<KnownTexts>().forget();
    loading::follow_file(world, target, diagnostics.into(), &read);
    None
}
