//! Loads the volume files that media name. Each is loaded once however often it is used, and released when it is no longer used.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use bevy::asset::{AssetLoadFailedEvent, AssetPath, LoadState};
use bevy::prelude::*;

use super::assets::{VolumeMap, cause};
use super::scene_file::SceneFile;
use super::{Medium, SceneStatus};

/// The volume files in use, by absolute path.
#[derive(Resource, Debug, Default)]
pub struct Volumes(BTreeMap<PathBuf, Handle<VolumeMap>>);

impl Volumes {
    /// The asset of a file, which may still be loading; None for a path that nothing names.
    pub fn get(&self, path: &Path) -> Option<&Handle<VolumeMap>> {
        self.0.get(path)
    }

    /// The absolute paths of all volume files that something in the scene names, sorted.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.0.keys().map(PathBuf::as_path)
    }
}

pub(super) fn follow_volumes(
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
            wanted.insert(grid.path.clone());
        });
    }
    if wanted.iter().eq(volumes.0.keys()) {
        return;
    }
    let mut old = std::mem::take(&mut volumes.0);
    for path in wanted {
        let handle = old
            .remove(&path)
            .unwrap_or_else(|| server.load(AssetPath::from_path_buf(path.clone())));
        volumes.0.insert(path, handle);
    }
}

/// Updates the messages about volumes.
pub(super) fn report_volumes(
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
    for (path, handle) in &volumes.0 {
        match server.load_state(handle) {
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
