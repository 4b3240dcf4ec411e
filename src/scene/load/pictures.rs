//! Loads the picture files of textures and environments.

use std::collections::BTreeSet;
use std::path::PathBuf;

use bevy::asset::{AssetLoadFailedEvent, LoadState};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::scene_file::SceneFile;
use crate::scene::assets::{cause, is_missing, is_refused_picture};
use crate::scene::components::missing::with_replacement;
use crate::scene::file::changes::Changes;
use crate::scene::file::files_in_use::FilesInUse;
use crate::scene::{
    AreaLight, Emitter, Material, MeshHandle, Parameter, SceneStatus, TextureMap, TriangleMesh, UsesMaterial,
};

/// The pictures in use, by absolute path.
pub type Pictures = FilesInUse<TextureMap>;

/// The things with pictures, and their changes.
#[derive(SystemParam)]
pub(in crate::scene) struct PictureNews<'w, 's> {
    materials: Changes<'w, 's, Material>,
    handles: Changes<'w, 's, MeshHandle>,
    uses: Changes<'w, 's, UsesMaterial>,
    emitters: Changes<'w, 's, Emitter>,
    lights: Changes<'w, 's, AreaLight>,
    removed: RemovedComponents<'w, 's, Material>,
    removed_emitters: RemovedComponents<'w, 's, Emitter>,
    removed_lights: RemovedComponents<'w, 's, AreaLight>,
    bared: RemovedComponents<'w, 's, UsesMaterial>,
    meshes: MessageReader<'w, 's, AssetEvent<TriangleMesh>>,
}

impl PictureNews<'_, '_> {
    /// Whether there are changes. Reads every reader to its end.
    fn any(&mut self) -> bool {
        let counts = [
            self.removed.read().count(),
            self.bared.read().count(),
            self.removed_emitters.read().count(),
            self.removed_lights.read().count(),
            self.meshes.read().count(),
        ];
        let has_changed = self.materials.any() || self.handles.any() || self.uses.any() || self.emitters.any();
        counts != [0; 5] || has_changed || self.lights.any()
    }
}

pub(in crate::scene) fn follow_pictures(
    mut pictures: ResMut<Pictures>,
    server: Res<AssetServer>,
    materials: Query<&Material>,
    lights: Query<&AreaLight>,
    emitters: Query<&Emitter>,
    // Shapes with a material do not use the library of their file.
    libraries: Query<&MeshHandle, Without<UsesMaterial>>,
    meshes: Res<Assets<TriangleMesh>>,
    mut news: PictureNews,
) {
    if !news.any() {
        return;
    }
    let mut wanted = BTreeSet::new();
    for material in &materials {
        material.for_each_texture(&mut |texture| {
            texture.for_each_bitmap(&mut |bitmap| {
                wanted.insert(bitmap.path.clone());
            });
        });
    }
    wanted.extend(pictures_of_lights(lights.iter(), emitters.iter()));
    for mesh in libraries.iter().filter_map(|handle| meshes.get(&handle.0)) {
        let materials = mesh.shapes.iter().flat_map(|shape| &shape.data.materials);
        let maps = materials.flat_map(|material| material.maps.iter());
        wanted.extend(maps.map(|map| map.file.clone()));
    }
    Pictures::keep(&mut pictures, wanted, &server);
}

/// Updates the messages about pictures.
pub(in crate::scene) fn report_pictures(
    mut status: ResMut<SceneStatus>,
    pictures: Res<Pictures>,
    file: Res<SceneFile>,
    server: Res<AssetServer>,
    assets: Res<Assets<TextureMap>>,
    mut events: MessageReader<AssetEvent<TextureMap>>,
    mut failures: MessageReader<AssetLoadFailedEvent<TextureMap>>,
    lights: Query<&AreaLight>,
    emitters: Query<&Emitter>,
    // A light may get a picture that is already loaded.
    changed: Query<(), Or<(Changed<AreaLight>, Changed<Emitter>)>>,
) {
    let news = events.read().count() + failures.read().count() + changed.iter().count();
    if news == 0 && status.pictures_loading == 0 && !pictures.is_changed() {
        return;
    }
    let (mut missing, mut damaged, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
    let mut loading = 0;
    let shining = pictures_of_lights(lights.iter(), emitters.iter());
    for (path, handle) in pictures.iter() {
        let say = |what: String| file.picture_problem(path, &what);
        match server.load_state(handle) {
            // If the scene may not read the picture, the message is the same as for one that does not exist.
            LoadState::Failed(error) if is_missing(&error) && !assets.contains(handle) => {
                missing.push(file.missing_picture(path));
            }
            LoadState::Failed(error) => match path.exists() && !is_refused_picture(&error) {
                true => damaged.push(say(cause(&error))),
                false if assets.contains(handle) => missing.push(say(cause(&error))),
                false => missing.push(say(with_replacement(path, &cause(&error)))),
            },
            LoadState::Loaded => {}
            LoadState::NotLoaded | LoadState::Loading => loading += usize::from(!assets.contains(handle)),
        }
        let warning = assets
            .get(handle)
            .and_then(|picture| picture.warning(shining.contains(path)));
        warnings.extend(warning.map(say));
    }
    let known = [&status.picture_problems, &status.damaged_pictures];
    for problem in missing.iter().chain(&damaged) {
        if !known.iter().any(|known| known.contains(problem)) {
            error!("{}", problem.message);
        }
    }
    let is_known = status.picture_problems == missing
        && status.damaged_pictures == damaged
        && status.picture_warnings == warnings
        && status.pictures_loading == loading;
    if !is_known {
        status.picture_problems = missing;
        status.damaged_pictures = damaged;
        status.picture_warnings = warnings;
        status.pictures_loading = loading;
    }
}

pub(in crate::scene) fn pictures_of_lights<'l>(
    lights: impl Iterator<Item = &'l AreaLight>,
    emitters: impl Iterator<Item = &'l Emitter>,
) -> BTreeSet<PathBuf> {
    let mut paths = BTreeSet::new();
    for light in lights {
        if let Parameter::Texture(texture) = &light.radiance {
            texture.for_each_bitmap(&mut |bitmap| {
                paths.insert(bitmap.path.clone());
            });
        }
    }
    for emitter in emitters {
        emitter.for_each_picture(&mut |path| {
            paths.insert(path.clone());
        });
    }
    paths
}
