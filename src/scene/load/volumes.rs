//! Loads the volume files of media.

use std::collections::BTreeSet;

use bevy::asset::{AssetLoadFailedEvent, LoadState};
use bevy::prelude::*;

use super::scene_file::SceneFile;
use crate::scene::assets::{VolumeMap, cause, is_missing};
use crate::scene::file::files_in_use::FilesInUse;
use crate::scene::{Medium, SceneStatus};

/// The grids in use, by the paths of their assets.
pub type Volumes = FilesInUse<VolumeMap>;

/// Loads the volumes of the present media.
pub(in crate::scene) fn follow_volumes(
    mut volumes: ResMut<Volumes>,
    server: Res<AssetServer>,
    media: Query<&Medium>,
    changed: Query<(), Changed<Medium>>,
    mut removed: RemovedComponents<Medium>,
) {
    if removed.read().count() == 0 && changed.is_empty() {
        return;
    }
    let mut wanted = BTreeSet::new();
    for medium in &media {
        medium.for_each_grid(&mut |grid| {
            wanted.insert(grid.asset_path());
        });
    }
    Volumes::keep(&mut volumes, wanted, &server);
}

/// Updates the messages about volumes.
pub(in crate::scene) fn report_volumes(
    mut status: ResMut<SceneStatus>,
    volumes: Res<Volumes>,
    file: Res<SceneFile>,
    server: Res<AssetServer>,
    assets: Res<Assets<VolumeMap>>,
    mut events: MessageReader<AssetEvent<VolumeMap>>,
    mut failures: MessageReader<AssetLoadFailedEvent<VolumeMap>>,
) {
    let news = events.read().count() + failures.read().count();
    if news == 0 && status.volumes_loading == 0 && !volumes.is_changed() {
        return;
    }
    let (mut errors, mut warnings, mut loading) = (Vec::new(), Vec::new(), 0);
    for (path, handle) in volumes.iter() {
        match server.load_state(handle) {
            LoadState::Failed(error) if is_missing(&error) && !assets.contains(handle) => {
                errors.push(file.missing_volume(path));
            }
            LoadState::Failed(error) => errors.push(file.volume_problem(path, &cause(&error))),
            LoadState::Loaded => {}
            LoadState::NotLoaded | LoadState::Loading => loading += usize::from(!assets.contains(handle)),
        }
        let warning = assets.get(handle).and_then(VolumeMap::warning);
        warnings.extend(warning.map(|warning| file.volume_problem(path, &warning)));
    }
    for problem in errors.iter().filter(|problem| !status.volume_errors.contains(problem)) {
        error!("{}", problem.message);
    }
    let is_known = status.volume_errors == errors && status.volume_warnings == warnings;
    if !is_known || status.volumes_loading != loading {
        status.volume_errors = errors;
        status.volume_warnings = warnings;
        status.volumes_loading = loading;
    }
}
