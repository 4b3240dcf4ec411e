//! Picture files follow the textures and environments that name them: each is loaded once however often it is used, and let go when nobody does.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use bevy::asset::{AssetLoadFailedEvent, AssetPath, LoadState};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::assets::cause;
use super::loading::SceneFile;
use super::{AreaLight, Emitter, Material, MeshHandle, Parameter, SceneStatus, TextureMap, TriangleMesh, UsesMaterial};
use crate::document::Span;

/// Where the scene file first names each picture, by absolute path.
pub type PicturePlaces = HashMap<PathBuf, Span>;

/// The pictures in use, by absolute path.
#[derive(Resource, Debug, Default)]
pub struct Pictures(BTreeMap<PathBuf, Handle<TextureMap>>);

impl Pictures {
    /// The picture's asset, which may still be on its way; None for a path that nobody names.
    pub fn get(&self, path: &Path) -> Option<&Handle<TextureMap>> {
        self.0.get(path)
    }

    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.0.keys().map(PathBuf::as_path)
    }
}

type PictureNamesChanged = Or<(
    Changed<Material>,
    Changed<MeshHandle>,
    Changed<UsesMaterial>,
    Changed<Emitter>,
    Changed<AreaLight>,
)>;

/// What may change which pictures are named.
#[derive(SystemParam)]
pub(super) struct PictureNews<'w, 's> {
    changed: Query<'w, 's, (), PictureNamesChanged>,
    removed: RemovedComponents<'w, 's, Material>,
    removed_emitters: RemovedComponents<'w, 's, Emitter>,
    removed_lights: RemovedComponents<'w, 's, AreaLight>,
    bared: RemovedComponents<'w, 's, UsesMaterial>,
    meshes: MessageReader<'w, 's, AssetEvent<TriangleMesh>>,
}

impl PictureNews<'_, '_> {
    /// Reads every reader to its end.
    fn any(&mut self) -> bool {
        let counts = [
            self.removed.read().count(),
            self.bared.read().count(),
            self.removed_emitters.read().count(),
            self.removed_lights.read().count(),
            self.meshes.read().count(),
        ];
        counts != [0; 5] || !self.changed.is_empty()
    }
}

pub(super) fn follow_pictures(
    mut pictures: ResMut<Pictures>,
    server: Res<AssetServer>,
    materials: Query<&Material>,
    lights: Query<&AreaLight>,
    emitters: Query<&Emitter>,
    // Those with a material of their own do not look at the library of their file.
    libraries: Query<&MeshHandle, Without<UsesMaterial>>,
    meshes: Res<Assets<TriangleMesh>>,
    mut news: PictureNews,
) {
    if !news.any() {
        return;
    }
    let mut wanted = BTreeSet::new();
    for material in &materials {
        material.clone().visit_textures(|_, texture| {
            texture.for_each_bitmap(&mut |bitmap| {
                wanted.insert(bitmap.path.clone());
            });
        });
    }
    for light in &lights {
        if let Parameter::Texture(texture) = &light.radiance {
            texture.for_each_bitmap(&mut |bitmap| {
                wanted.insert(bitmap.path.clone());
            });
        }
    }
    for emitter in &emitters {
        emitter.for_each_picture(&mut |path| {
            wanted.insert(path.clone());
        });
    }
    for mesh in libraries.iter().filter_map(|handle| meshes.get(&handle.0)) {
        let materials = mesh.shapes.iter().flat_map(|shape| &shape.data.materials);
        let maps = materials.flat_map(|material| material.maps.iter());
        wanted.extend(maps.map(|map| map.file.clone()));
    }
    let same = wanted.iter().eq(pictures.0.keys());
    if same {
        return;
    }
    let mut old = std::mem::take(&mut pictures.0);
    for path in wanted {
        let handle = old
            .remove(&path)
            .unwrap_or_else(|| server.load(AssetPath::from_path_buf(path.clone())));
        pictures.0.insert(path, handle);
    }
}

/// Brings what is said of pictures up to date.
pub(super) fn report_pictures(
    mut status: ResMut<SceneStatus>,
    pictures: Res<Pictures>,
    file: Res<SceneFile>,
    server: Res<AssetServer>,
    assets: Res<Assets<TextureMap>>,
    mut events: MessageReader<AssetEvent<TextureMap>>,
    mut failures: MessageReader<AssetLoadFailedEvent<TextureMap>>,
) {
    let news = events.read().count() + failures.read().count();
    if news == 0 && status.pictures_loading == 0 && !pictures.is_changed() {
        return;
    }
    let mut problems = Vec::new();
    let mut loading = 0;
    for (path, handle) in &pictures.0 {
        match server.load_state(handle) {
            LoadState::Failed(error) => problems.push(format!(
                "{}picture {}: {}",
                file.place_of_picture(path),
                path.display(),
                cause(&error)
            )),
            LoadState::Loaded => {}
            LoadState::NotLoaded | LoadState::Loading => loading += usize::from(!assets.contains(handle)),
        }
    }
    for problem in problems
        .iter()
        .filter(|problem| !status.picture_problems.contains(problem))
    {
        error!("{problem}");
    }
    if status.picture_problems != problems || status.pictures_loading != loading {
        status.picture_problems = problems;
        status.pictures_loading = loading;
    }
}
