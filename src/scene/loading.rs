//! Scene files: asked for, read by the asset server, turned into entities.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::asset::{AssetLoadFailedEvent, AssetPath};
use bevy::ecs::message::{MessageCursor, Messages};
use bevy::prelude::*;

use super::assets::gltf_scene::check_scene_file;
use super::assets::scene_asset::one_error;
use super::assets::{SceneAsset, SceneDefines, cause};
use super::pictures::PicturePlaces;
use super::read::settle;
use super::spawn::ReloadSummary;
use super::{OpenScene, SceneDescription, SceneState, SceneStatus, spawn};
use crate::document::Diagnostics;

/// The scene file asked for last, and the one the entities are from.
#[derive(Resource, Debug, Default)]
pub struct SceneFile {
    /// Kept so that it stays loaded.
    pub(super) handle: Option<Handle<SceneAsset>>,
    pub(super) path: PathBuf,
    /// The next good load replaces everything instead of updating.
    opens: bool,
    /// What the spans of the entities' sources point into.
    pub(super) good_diagnostics: Arc<Diagnostics>,
    /// Into the same.
    picture_places: PicturePlaces,
}

impl SceneFile {
    /// `file:line:column: ` of where a picture is named first; empty for one that the file does not name.
    pub(super) fn place_of_picture(&self, path: &Path) -> String {
        let span = self.picture_places.get(path);
        match span.and_then(|&span| self.good_diagnostics.locate(span)) {
            Some((path, line, column)) => format!("{}:{line}:{column}: ", path.display()),
            None => String::new(),
        }
    }
}

pub(super) fn open_scenes(
    mut requests: MessageReader<OpenScene>,
    mut file: ResMut<SceneFile>,
    mut status: ResMut<SceneStatus>,
    defines: Res<SceneDefines>,
    server: Res<AssetServer>,
) {
    // Of several in one frame the last one counts.
    let Some(request) = requests.read().last() else {
        return;
    };
    let path = settle(&request.path);
    if let Err(error) = check_scene_file(&path) {
        status.path = Some(path);
        status.state = SceneState::Failed;
        status.diagnostics = Arc::new(one_error(error.to_string()));
        return;
    }
    defines.set(path.clone(), request.defines.clone());
    let asset_path = AssetPath::from_path_buf(path.clone());
    if file.handle.is_some() && file.path == path {
        server.reload(asset_path);
    } else {
        file.handle = Some(server.load(asset_path));
    }
    file.path.clone_from(&path);
    file.opens = true;
    status.path = Some(path);
    status.state = SceneState::Loading;
}

/// Runs alone: a scene touches everything.
pub(super) fn apply_scenes(
    world: &mut World,
    mut arrived: Local<MessageCursor<AssetEvent<SceneAsset>>>,
    mut failed: Local<MessageCursor<AssetLoadFailedEvent<SceneAsset>>>,
) {
    let Some(id) = world.resource::<SceneFile>().handle.as_ref().map(Handle::id) else {
        return;
    };
    let has_arrived = arrived
        .read(world.resource::<Messages<AssetEvent<SceneAsset>>>())
        .filter(|event| event.is_added(id) || event.is_modified(id))
        .count()
        > 0;
    let failure = failed
        .read(world.resource::<Messages<AssetLoadFailedEvent<SceneAsset>>>())
        .filter(|event| event.id == id)
        .last()
        .map(|event| cause(&event.error));
    if let Some(cause) = failure {
        let message = format!("the scene cannot be read: {cause}");
        let mut diagnostics = one_error(message);
        diagnostics.sources.push(crate::document::SourceFile {
            path: world.resource::<SceneFile>().path.clone(),
            text: Arc::from(""),
            byte_order_mark: false,
        });
        fail(world, Arc::new(diagnostics));
    }
    if !has_arrived {
        return;
    }
    let Some(asset) = world.resource::<Assets<SceneAsset>>().get(id).cloned() else {
        return;
    };
    if asset.diagnostics.has_errors() {
        fail(world, asset.diagnostics);
        return;
    }
    let fresh = std::mem::take(&mut world.resource_mut::<SceneFile>().opens);
    let reload = if fresh {
        spawn::spawn_fresh(world, &asset.description);
        ReloadSummary::default()
    } else {
        spawn::update(world, &asset.description)
    };
    let mut file = world.resource_mut::<SceneFile>();
    file.good_diagnostics = asset.diagnostics.clone();
    file.picture_places.clone_from(&asset.description.picture_places);
    let path = file.path.clone();
    let mut status = world.resource_mut::<SceneStatus>();
    // A request that failed since may have put another there.
    status.path = Some(path);
    status.state = SceneState::Ready;
    status.diagnostics = asset.diagnostics;
    status.revision += 1;
    status.fresh_load = fresh;
    status.reload = reload;
}

/// The entities are the scene of this file, which has just been written and read again.
pub(super) fn follow_file(world: &mut World, path: &Path, diagnostics: Arc<Diagnostics>, written: SceneDescription) {
    let server = world.get_resource::<AssetServer>().cloned();
    if let Some(mut file) = world.get_resource_mut::<SceneFile>() {
        if file.path != path {
            let asset_path = AssetPath::from_path_buf(path.to_owned());
            file.handle = server.map(|server| server.load(asset_path));
            file.path = path.to_owned();
            file.opens = false;
        }
        file.good_diagnostics = diagnostics.clone();
        file.picture_places = written.picture_places;
    }
    if let Some(mut status) = world.get_resource_mut::<SceneStatus>() {
        status.path = Some(path.to_owned());
        status.state = SceneState::Ready;
        status.diagnostics = diagnostics;
    }
}

/// An empty scene of no file, in place of what was there: a camera that looks at the origin, and a grey sky.
pub fn new_scene(world: &mut World) {
    spawn::spawn_fresh(world, &SceneDescription::empty());
    world.insert_resource(SceneFile::default());
    let mut status = world.resource_mut::<SceneStatus>();
    *status = SceneStatus {
        state: SceneState::Ready,
        revision: status.revision + 1,
        fresh_load: true,
        ..SceneStatus::default()
    };
}

fn fail(world: &mut World, diagnostics: Arc<Diagnostics>) {
    let mut status = world.resource_mut::<SceneStatus>();
    status.state = SceneState::Failed;
    status.diagnostics = diagnostics;
}
