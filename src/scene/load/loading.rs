//! Loads scene files: the asset server reads them, and they are turned into entities.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::asset::{AssetLoadFailedEvent, AssetPath};
use bevy::ecs::message::{MessageCursor, Messages};
use bevy::prelude::*;

use super::opening::{Arrived, Opening};
use super::scene_file::{Asked, SceneFile};
use super::spawn;
use super::spawn::Spawning;
use crate::document::paths::settle;
use crate::document::source::unreadable;
use crate::document::{Diagnostics, SourceFile};
use crate::files;
use crate::scene::assets::gltf_scene::largest;
use crate::scene::assets::scene_asset::one_error;
use crate::scene::assets::{SceneAsset, SceneDefines, cause};
use crate::scene::edits::posing;
use crate::scene::file::file_base::FileBase;
use crate::scene::file::known::{KnownTexts, are_as_read};
use crate::scene::{
    KeepSource, OpenScene, ReloadSummary, SceneAccess, SceneDescription, SceneState, SceneStatus, Trust,
};

/// Requests a scene. From now on it counts as being read, so that no conflicting work, such as a save, begins in this
/// frame.
pub(crate) fn ask_for(world: &mut World, request: OpenScene) {
    if let Some(mut status) = world.get_resource_mut::<SceneStatus>() {
        status.state = SceneState::Loading;
    }
    world.write_message(request);
}

pub(in crate::scene) fn open_scenes(
    mut requests: MessageReader<OpenScene>,
    mut file: ResMut<SceneFile>,
    mut status: ResMut<SceneStatus>,
    defines: Res<SceneDefines>,
    trust: Res<Trust>,
    access: Res<SceneAccess>,
    server: Res<AssetServer>,
) {
    // The last of several requests in a frame counts.
    let Some(request) = requests.read().last() else {
        return;
    };
    let path = settle(&request.path);
    // A missing file may appear later: the asset server waits for it.
    if let Err(error) = files::check(&path, largest(&path))
        && !error.is_not_found()
    {
        let error = unreadable(&path, error);
        status.asked = Some(path);
        status.state = SceneState::Failed;
        status.failures += 1;
        status.diagnostics = Arc::new(one_error(error.to_string()));
        file.asked = None;
        return;
    }
    defines.set(path.clone(), request.defines.clone());
    access.ask(path.clone(), trust.access(&path));
    let asset_path = AssetPath::from_path_buf(path.clone());
    let known = file.asked.as_ref().filter(|asked| asked.path == path);
    let known = known.map(|asked| asked.handle.clone());
    let own = file.handle.clone().filter(|_| file.path == path);
    let keeps_edits = request.keeps_edits && own.is_some();
    let handle = match own.or(known) {
        Some(handle) => {
            server.reload(asset_path);
            handle
        }
        None => server.load(asset_path),
    };
    status.asked = Some(path.clone());
    status.state = SceneState::Loading;
    file.asked = Some(Asked {
        handle,
        path,
        keeps_edits,
    });
}

/// The scene files that were read, or could not be read, since the last frame.
#[derive(Default)]
pub(in crate::scene) struct Readings {
    arrived: HashSet<AssetId<SceneAsset>>,
    failed: HashMap<AssetId<SceneAsset>, String>,
}

/// Runs exclusively: a scene changes everything.
pub(in crate::scene) fn apply_scenes(
    world: &mut World,
    mut arrived: Local<MessageCursor<AssetEvent<SceneAsset>>>,
    mut failed: Local<MessageCursor<AssetLoadFailedEvent<SceneAsset>>>,
    mut readings: Local<Readings>,
) {
    for event in arrived.read(world.resource::<Messages<AssetEvent<SceneAsset>>>()) {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } = event {
            readings.arrived.insert(*id);
        }
    }
    for event in failed.read(world.resource::<Messages<AssetLoadFailedEvent<SceneAsset>>>()) {
        readings.failed.insert(event.id, cause(&event.error));
    }
    if let Some(opening) = world.remove_resource::<Opening>() {
        go_on_opening(world, opening);
        // A scene that is read meanwhile waits until this one is complete.
        return;
    }
    let file = world.resource::<SceneFile>();
    let asked = file.asked.as_ref().map(|asked| asked.handle.id());
    let own = file.handle.as_ref().map(Handle::id).filter(|own| Some(*own) != asked);
    let held = own.filter(|_| file.is_held);
    let mut now = std::mem::take(&mut *readings);
    if let Some(held) = held {
        readings.arrived.extend(now.arrived.take(&held));
        readings.failed.extend(now.failed.remove_entry(&held));
    }
    for id in own.into_iter().chain(asked) {
        if let Some(cause) = now.failed.get(&id) {
            fail(world, id, |path| {
                let mut diagnostics = one_error(cause.clone());
                diagnostics.sources.push(SourceFile {
                    path: path.to_owned(),
                    text: Arc::default(),
                    byte_order_mark: false,
                });
                Arc::new(diagnostics)
            });
        }
        if now.arrived.contains(&id)
            && let Some(asset) = world.resource::<Assets<SceneAsset>>().get(id).cloned()
        {
            if Some(id) == own && (is_known(world, &asset) || is_outdated(world, &asset)) {
                continue;
            }
            if asset.diagnostics.has_errors() {
                fail(world, id, |_| asset.diagnostics.clone());
            } else {
                take_in(world, id, asset);
            }
        }
    }
}

/// Whether the asset equals the known state of the scene's file since it was written here.
fn is_known(world: &mut World, asset: &SceneAsset) -> bool {
    let file = world.resource::<SceneFile>();
    let base = world.get_resource::<FileBase>();
    let are_same = |(one, other): (&SourceFile, &SourceFile)| (&one.path, &one.text) == (&other.path, &other.text);
    let (known, read) = (&file.good_diagnostics.sources, &asset.diagnostics.sources);
    let is_known = file.was_written
        && known.len() == read.len()
        && known.iter().zip(read).all(are_same)
        // A file that has appeared since is read.
        && base.is_some_and(|base| base.scene.missing == asset.description.missing);
    if is_known {
        world.resource_mut::<SceneFile>().was_written = false;
        share_description(world);
    }
    is_known
}

/// Replaces the description of the scene file's asset by the known one, so that a large scene is in memory once.
fn share_description(world: &mut World) {
    let (Some(file), Some(base)) = (world.get_resource::<SceneFile>(), world.get_resource::<FileBase>()) else {
        return;
    };
    let known = SceneAsset {
        description: base.scene.clone(),
        diagnostics: file.good_diagnostics.clone(),
    };
    let Some(id) = file.handle.as_ref().map(Handle::id) else {
        return;
    };
    if let Some(mut assets) = world.get_resource_mut::<Assets<SceneAsset>>()
        && let Some(asset) = assets.get_mut_untracked(id)
    {
        *asset = known;
    }
}

/// Whether the asset was read before the scene's file was written here. Then it is read again, because otherwise the
/// file would seem to revert the edits.
fn is_outdated(world: &mut World, asset: &SceneAsset) -> bool {
    let file = world.resource::<SceneFile>();
    let is_outdated = file.was_written && !are_as_read(&asset.diagnostics.sources);
    if is_outdated {
        let path = AssetPath::from_path_buf(file.path.clone());
        world.resource::<AssetServer>().reload(path);
    } else {
        world.resource_mut::<SceneFile>().was_written = false;
    }
    is_outdated
}

/// Updates the entities to the file.
fn take_in(world: &mut World, id: AssetId<SceneAsset>, asset: SceneAsset) {
    let is_asked = |asked: &mut Asked| asked.handle.id() == id;
    let asked = world.resource_mut::<SceneFile>().asked.take_if(is_asked);
    if asked.is_some() {
        world.resource::<SceneAccess>().take_over();
    }
    let fresh = asked.as_ref().is_some_and(|asked| !asked.keeps_edits);
    if fresh {
        let spawning = Spawning::begin(world, asset.description.clone());
        let opening = Opening::new(spawning, (id, asset, asked));
        go_on_opening(world, opening);
    } else {
        let reload = posing::update(world, &asset.description);
        taken_in(world, (id, asset, asked), None, reload);
    }
}

/// Continues opening a scene for as long as a frame may take.
fn go_on_opening(world: &mut World, mut opening: Opening) {
    match opening.go_on(world) {
        false => {
            world.resource_mut::<SceneStatus>().is_opening = true;
            world.insert_resource(opening);
        }
        true => {
            world.resource_mut::<SceneStatus>().is_opening = false;
            let (spawning, arrived) = opening.into_parts();
            taken_in(world, arrived, Some(spawning), ReloadSummary::default());
        }
    }
}

/// Records which file was read, once the entities exist. `spawned`: a newly opened scene.
fn taken_in(world: &mut World, arrived: Arrived, spawned: Option<Spawning>, reload: ReloadSummary) {
    let (id, asset, asked) = arrived;
    let fresh = spawned.is_some();
    if let Some(spawned) = spawned {
        spawned.finish(world);
    }
    if let Some(mut known) = world.get_resource_mut::<KnownTexts>() {
        known.forget();
    }
    let mut file = world.resource_mut::<SceneFile>();
    let files_read_again = files_that_differ(&file.good_diagnostics, &asset.diagnostics);
    file.good_diagnostics = asset.diagnostics.clone();
    file.picture_places.clone_from(&asset.description.picture_places);
    file.volume_places.clone_from(&asset.description.volume_places);
    file.missing.clone_from(&asset.description.missing);
    if let Some(asked) = asked {
        (file.handle, file.path) = (Some(asked.handle), asked.path);
        file.was_written = false;
    }
    let path = file.path.clone();
    let waits = file.asked.is_some();
    if !world.resource::<KeepSource>().get() {
        // Only the entities are needed from now on.
        world.resource_mut::<SceneFile>().handle = None;
        world.resource_mut::<Assets<SceneAsset>>().remove(id);
        world.insert_resource(FileBase::default());
    }
    let mut status = world.resource_mut::<SceneStatus>();
    status.path = Some(path);
    status.file_is_broken = false;
    status.revision += 1;
    status.fresh_load = fresh;
    status.files_read_again = files_read_again;
    status.reload = reload;
    if !waits {
        status.asked = None;
        status.state = SceneState::Ready;
        status.diagnostics = asset.diagnostics.clone();
    }
}

/// The files of `now` whose text is new since `before`.
fn files_that_differ(before: &Diagnostics, now: &Diagnostics) -> Vec<PathBuf> {
    let is_known = |source: &&SourceFile| {
        let mut known = before.sources.iter();
        known.any(|known| (&known.path, &known.text) == (&source.path, &source.text))
    };
    let sources = now.sources.iter().filter(|source| !is_known(source));
    sources.map(|source| source.path.clone()).collect()
}

/// Updates the entities to a new reading of the scene's own file, without the asset server. Edits are kept as in a
/// reload.
pub(in crate::scene) fn take_in_read(world: &mut World, scene: SceneDescription, diagnostics: Arc<Diagnostics>) {
    let scene = Arc::new(scene);
    let reload = posing::update(world, &scene);
    if let Some(mut known) = world.get_resource_mut::<KnownTexts>() {
        known.forget();
    }
    let mut files_read_again = Vec::new();
    if let Some(mut file) = world.get_resource_mut::<SceneFile>() {
        files_read_again = files_that_differ(&file.good_diagnostics, &diagnostics);
        file.good_diagnostics = diagnostics.clone();
        file.picture_places.clone_from(&scene.picture_places);
        file.volume_places.clone_from(&scene.volume_places);
        file.missing.clone_from(&scene.missing);
    }
    if let Some(mut status) = world.get_resource_mut::<SceneStatus>() {
        status.file_is_broken = false;
        status.revision += 1;
        status.fresh_load = false;
        status.files_read_again = files_read_again;
        status.reload = reload;
        status.state = SceneState::Ready;
        status.diagnostics = diagnostics;
    }
}

/// Makes the entities follow this file, which has just been written from them and read again.
pub(in crate::scene) fn follow_file(
    world: &mut World,
    path: &Path,
    diagnostics: Arc<Diagnostics>,
    written: &SceneDescription,
) {
    let server = world.get_resource::<AssetServer>().cloned();
    share_description(world);
    if let (Some(access), Some(folder)) = (world.get_resource::<SceneAccess>(), path.parent()) {
        access.allow(folder);
    }
    if let Some(mut file) = world.get_resource_mut::<SceneFile>() {
        if file.path != path {
            let asset_path = AssetPath::from_path_buf(path.to_owned());
            file.handle = server.map(|server| server.load(asset_path));
            file.path = path.to_owned();
        }
        file.asked = None;
        file.was_written = true;
        file.good_diagnostics = diagnostics.clone();
        file.picture_places.clone_from(&written.picture_places);
        file.volume_places.clone_from(&written.volume_places);
        file.missing.clone_from(&written.missing);
    }
    share_description(world);
    if let Some(mut status) = world.get_resource_mut::<SceneStatus>() {
        status.path = Some(path.to_owned());
        status.asked = None;
        status.file_is_broken = false;
        status.state = SceneState::Ready;
        status.diagnostics = diagnostics;
    }
}

/// Replaces the open scene by an empty one without a file: a camera that looks at the origin, and a grey sky.
pub(crate) fn new_scene(world: &mut World) {
    if let (Some(access), Some(trust)) = (world.get_resource::<SceneAccess>(), world.get_resource::<Trust>()) {
        access.set(trust.access(Path::new("")));
    }
    spawn::spawn_fresh(world, &Arc::new(SceneDescription::empty()));
    world.insert_resource(SceneFile::default());
    world.insert_resource(KnownTexts::default());
    let mut status = world.resource_mut::<SceneStatus>();
    *status = SceneStatus {
        state: SceneState::Ready,
        revision: status.revision + 1,
        failures: status.failures,
        fresh_load: true,
        ..SceneStatus::default()
    };
}

/// Keeps the open scene with its file. Only if there was none, the broken file is watched until it is repaired.
fn fail(world: &mut World, id: AssetId<SceneAsset>, diagnostics: impl FnOnce(&Path) -> Arc<Diagnostics>) {
    let has_scene = world.resource::<SceneStatus>().revision > 0;
    let mut file = world.resource_mut::<SceneFile>();
    let is_own = file.handle.as_ref().is_some_and(|own| own.id() == id);
    let is_asked = |asked: &Asked| asked.handle.id() == id;
    let asked = file.asked.clone().filter(is_asked);
    if asked.is_some() && has_scene {
        file.asked = None;
    }
    let path = asked.map_or_else(|| file.path.clone(), |asked| asked.path);
    let is_waiting = file.asked.is_some() && has_scene;
    let mut status = world.resource_mut::<SceneStatus>();
    status.file_is_broken |= is_own;
    if !is_waiting {
        status.state = SceneState::Failed;
        status.failures += 1;
        status.diagnostics = diagnostics(&path);
        status.asked = Some(path);
    }
}
