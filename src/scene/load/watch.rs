//! Reloads files of the open scene when they change on disk: the scene with its includes, meshes, material libraries,
//! pictures, volumes.
//!
//! Bevy watches only its own asset root, so this watch is ours; it only tells the asset server what to reload. Folders
//! are watched, not files: editors replace files by renaming others over them. A partially written file fails to load,
//! which keeps the old content; the end of the writing makes another event. One file is never read twice at the same
//! time, so that the last reading wins.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bevy::asset::{AssetLoadFailedEvent, AssetPath};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use crossbeam_channel::{Receiver, unbounded};
use notify_debouncer_full::notify::event::{AccessKind, AccessMode, MetadataKind, ModifyKind};
use notify_debouncer_full::notify::{EventKind, RecommendedWatcher, RecursiveMode};
use notify_debouncer_full::{DebounceEventResult, Debouncer, NoCache, new_debouncer_opt};

use super::pictures::Pictures;
use super::scene_file::SceneFile;
use crate::document::paths::settle;
use crate::files::SameFiles;
use crate::scene::assets::SceneAsset;
use crate::scene::components::presence::Presence;
use crate::scene::{
    FileReadAgain, MeshHandle, SceneStatus, Shape, ShapeKind, TextureMap, TriangleMesh, VolumeFormat, VolumeMap,
    Volumes,
};

/// The time for which events are held back, so that one save is one event.
const DEBOUNCE: Duration = Duration::from_millis(100);

/// The time after which a reload without any message counts as lost.
const PATIENCE: Duration = Duration::from_secs(20);

/// The watch, and the files that are watched.
#[derive(Resource, Default)]
pub struct SceneWatch {
    watcher: Option<Watcher>,
    /// The file of the scene itself.
    scene: PathBuf,
    /// The error if the system refuses to watch; hot reload is off then.
    pub error: Option<String>,
    folders: HashSet<PathBuf>,
    /// The assets to reload when a file changes.
    reloads: HashMap<PathBuf, Vec<PathBuf>>,
    /// The changed files whose reload was not requested yet.
    waiting: HashSet<PathBuf>,
    /// The requested reloads without a result, with the time of the request.
    on_their_way: HashMap<PathBuf, Instant>,
    presence: Presence,
}

struct Watcher {
    debouncer: Debouncer<RecommendedWatcher, NoCache>,
    events: Receiver<DebounceEventResult>,
}

impl SceneWatch {
    /// Whether all known changes of files have been reloaded.
    pub fn is_idle(&self) -> bool {
        self.waiting.is_empty() && self.on_their_way.is_empty()
    }

    /// The files of the open scene, and the paths where it searches for missing ones.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        self.reloads.keys().map(PathBuf::as_path)
    }

    /// Whether the open scene uses this file, under any name.
    pub fn has_file(&self, path: &Path) -> bool {
        SameFiles::of(self.files()).has(path)
    }

    /// Whether the open scene uses this file besides its own, under any name.
    pub(in crate::scene) fn has_part(&self, path: &Path) -> bool {
        SameFiles::of(self.files().filter(|file| *file != self.scene)).has(path)
    }

    fn start(&mut self) {
        if self.watcher.is_some() || self.error.is_some() {
            return;
        }
        let (sender, events) = unbounded();
        let handler = move |result: DebounceEventResult| {
            // The receiver is gone only when the program ends.
            let _ = sender.send(result);
        };
        match new_debouncer_opt(DEBOUNCE, None, handler, NoCache::new(), Default::default()) {
            Ok(debouncer) => self.watcher = Some(Watcher { debouncer, events }),
            Err(error) => {
                warn!("files are not watched: {error}");
                self.error = Some(error.to_string());
            }
        }
    }

    /// Watches the folders of all listed files, or the nearest existing folder above.
    fn watch_folders(&mut self) {
        let Some(watcher) = &mut self.watcher else {
            return;
        };
        let parents: HashSet<&Path> = self.reloads.keys().filter_map(|file| file.parent()).collect();
        let wanted: HashSet<PathBuf> = parents
            .into_iter()
            .filter_map(|parent| parent.ancestors().find(|folder| folder.is_dir()))
            .map(Path::to_owned)
            .collect();
        for folder in self.folders.difference(&wanted) {
            // This fails for deleted folders, which need no watch any more.
            let _ = watcher.debouncer.unwatch(folder);
        }
        let mut watched: HashSet<PathBuf> = self.folders.intersection(&wanted).cloned().collect();
        for folder in wanted.difference(&self.folders) {
            match watcher.debouncer.watch(folder, RecursiveMode::NonRecursive) {
                Ok(()) => {
                    watched.insert(folder.clone());
                }
                Err(error) => warn!("{} is not watched: {error}", folder.display()),
            }
        }
        self.folders = watched;
    }

    fn look_for_files(&mut self) {
        self.presence.look(self.reloads.keys());
    }
}

/// Keeps the list of files up to date.
pub(in crate::scene) fn list_files(
    mut watch: ResMut<SceneWatch>,
    file: Res<SceneFile>,
    status: Res<SceneStatus>,
    scenes: Res<Assets<SceneAsset>>,
    meshes: Res<Assets<TriangleMesh>>,
    pictures: Res<Pictures>,
    volumes: Res<Volumes>,
    shapes: Query<(&Shape, &MeshHandle)>,
    mut mesh_events: MessageReader<AssetEvent<TriangleMesh>>,
    changed: Query<(), Changed<MeshHandle>>,
) {
    let news = mesh_events.read().count() + changed.iter().count();
    if news == 0 && !status.is_changed() && !file.is_changed() && !pictures.is_changed() && !volumes.is_changed() {
        return;
    }
    let mut reloads: HashMap<PathBuf, Vec<PathBuf>> = HashMap::new();
    let mut add = |changed: &Path, asset: &Path| {
        let assets = reloads.entry(changed.to_owned()).or_default();
        if !assets.iter().any(|known| known == asset) {
            assets.push(asset.to_owned());
        }
    };
    let own = file.handle.as_ref().map(|handle| (&file.path, handle));
    let asked = file.asked.as_ref().map(|asked| (&asked.path, &asked.handle));
    for (path, handle) in own.into_iter().chain(asked) {
        add(path, path);
        if let Some(scene) = scenes.get(handle) {
            // A missing mesh, picture or volume that appears is loaded without reloading the scene.
            let missing = scene.description.missing.values();
            let elsewhere = missing.flat_map(|file| &file.others);
            for source in scene.description.sources.iter().chain(elsewhere) {
                add(source, path);
            }
        }
    }
    for (shape, handle) in &shapes {
        let ShapeKind::Mesh(mesh) = &shape.kind else {
            continue;
        };
        add(&mesh.path, &mesh.path);
        for library in meshes.get(&handle.0).into_iter().flat_map(|mesh| &mesh.dependencies) {
            add(&settle(library), &mesh.path);
        }
    }
    for file in pictures.paths() {
        add(file, file);
    }
    for grid in volumes.paths() {
        add(VolumeFormat::of_asset(grid).0, grid);
    }
    watch.scene = file.path.clone();
    if watch.reloads != reloads {
        watch.reloads = reloads;
        watch.start();
        watch.watch_folders();
        watch.look_for_files();
    }
}

pub(in crate::scene) fn report_gone_files(watch: Res<SceneWatch>, mut status: ResMut<SceneStatus>) {
    let gone = watch.presence.gone();
    if status.files_gone != gone {
        status.files_gone = gone;
    }
}

/// The messages of the asset server about one kind of asset.
#[derive(SystemParam)]
pub(in crate::scene) struct Arrivals<'w, 's, A: Asset> {
    events: MessageReader<'w, 's, AssetEvent<A>>,
    failures: MessageReader<'w, 's, AssetLoadFailedEvent<A>>,
}

impl<A: Asset> Arrivals<'_, '_, A> {
    /// Removes arrived and failed files from the list of requested reloads. Returns the requested ones that have
    /// arrived.
    fn take_in(&mut self, watch: &mut SceneWatch, server: &AssetServer) -> Vec<PathBuf> {
        let mut arrived = Vec::new();
        for event in self.events.read() {
            if let AssetEvent::Added { id } | AssetEvent::Modified { id } = event
                && let Some(path) = server.get_path(*id)
                && watch.on_their_way.remove(path.path()).is_some()
            {
                arrived.push(path.path().to_owned());
            }
        }
        for failure in self.failures.read() {
            watch.on_their_way.remove(failure.path.path());
        }
        arrived
    }
}

pub(in crate::scene) fn reload_changed_files(
    mut watch: ResMut<SceneWatch>,
    server: Res<AssetServer>,
    mut scenes: Arrivals<SceneAsset>,
    mut meshes: Arrivals<TriangleMesh>,
    mut pictures: Arrivals<TextureMap>,
    mut volumes: Arrivals<VolumeMap>,
    mut read_again: MessageWriter<FileReadAgain>,
) {
    // Messages about a scene are sent where it is applied.
    scenes.take_in(&mut watch, &server);
    let meshes = meshes.take_in(&mut watch, &server);
    let pictures = pictures.take_in(&mut watch, &server);
    let volumes = volumes.take_in(&mut watch, &server);
    let volumes = volumes
        .into_iter()
        .map(|grid| VolumeFormat::of_asset(&grid).0.to_owned());
    read_again.write_batch(meshes.into_iter().chain(pictures).chain(volumes).map(FileReadAgain));

    take_events(&mut watch);
    let ready: Vec<PathBuf> = watch
        .waiting
        .iter()
        .filter(|asset| {
            watch
                .on_their_way
                .get(*asset)
                .is_none_or(|since| since.elapsed() > PATIENCE)
        })
        .cloned()
        .collect();
    for asset in ready {
        watch.waiting.remove(&asset);
        watch.on_their_way.insert(asset.clone(), Instant::now());
        debug!("reading {} again", asset.display());
        server.reload(AssetPath::from_path_buf(asset));
    }
}

fn take_events(watch: &mut SceneWatch) {
    let Some(watcher) = &watch.watcher else {
        return;
    };
    let mut folders_changed = false;
    let mut changed: HashSet<PathBuf> = HashSet::new();
    for result in watcher.events.try_iter() {
        let events = match result {
            Ok(events) => events,
            Err(errors) => {
                for error in errors {
                    warn!("watching files: {error}");
                }
                continue;
            }
        };
        for event in events {
            let is_change = match event.kind {
                // Times and permissions are no content; only polling watchers report new content by its time.
                EventKind::Modify(ModifyKind::Metadata(kind)) => kind == MetadataKind::WriteTime,
                EventKind::Create(_) | EventKind::Modify(_) => true,
                EventKind::Access(kind) => kind == AccessKind::Close(AccessMode::Write),
                // A file is gone: its content stays until another file replaces it. `Presence` reports that it is gone.
                _ => false,
            };
            // Events were lost, so everything may have changed.
            if event.need_rescan() {
                changed.extend(watch.reloads.keys().cloned());
            }
            folders_changed |= !matches!(event.kind, EventKind::Access(_));
            if is_change {
                changed.extend(event.paths.iter().cloned());
            }
        }
    }
    for file in changed {
        let assets = watch.reloads.get(&file).filter(|_| file.is_file());
        watch.waiting.extend(assets.into_iter().flatten().cloned());
    }
    if folders_changed {
        watch.look_for_files();
        // A new folder may already contain files.
        let before = watch.folders.clone();
        watch.watch_folders();
        let brought = |file: &Path| {
            file.parent()
                .is_some_and(|folder| is_new(folder, &before, &watch.folders))
                && file.is_file()
        };
        let found: Vec<PathBuf> = watch
            .reloads
            .iter()
            .filter(|(file, _)| brought(file))
            .flat_map(|(_, assets)| assets.clone())
            .collect();
        watch.waiting.extend(found);
    }
}

fn is_new(folder: &Path, before: &HashSet<PathBuf>, now: &HashSet<PathBuf>) -> bool {
    now.contains(folder) && !before.contains(folder)
}
