//! The files of a scene, which an export must not overwrite.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::files::SameFiles;
use crate::scene::ShapeKind;
use crate::scene::components::description::SceneDescription;
use crate::scene::load::pictures::pictures_of_lights;

/// The first of these files that the scene was read from, or that it names as a mesh or a picture. `of_libraries`: the
/// pictures named by the materials of mesh files.
pub fn first_in_use<'f>(
    scene: &SceneDescription,
    of_libraries: &BTreeSet<PathBuf>,
    mut files: impl Iterator<Item = &'f Path>,
) -> Option<&'f Path> {
    let used = SameFiles::of(used_files(scene).iter().chain(of_libraries));
    // A file that does not exist is not in use.
    files.find(|file| used.has(file))
}

fn used_files(scene: &SceneDescription) -> BTreeSet<PathBuf> {
    let lights = scene.shapes.iter().filter_map(|shape| shape.area_light.as_ref());
    let mut used = pictures_of_lights(lights, scene.emitters.iter().map(|emitter| &emitter.emitter));
    for material in &scene.materials {
        material.material.for_each_texture(&mut |texture| {
            texture.for_each_bitmap(&mut |bitmap| {
                used.insert(bitmap.path.clone());
            });
        });
    }
    for shape in &scene.shapes {
        if let ShapeKind::Mesh(mesh) = &shape.shape.kind {
            used.insert(mesh.path.clone());
        }
    }
    used.extend([scene.path.clone()]);
    used.extend(scene.sources.iter().cloned());
    // glTF files name their buffers and pictures.
    let origin = scene.remains.origin.iter();
    let sources = origin.flat_map(|origin| &origin.diagnostics.sources);
    used.extend(sources.map(|source| source.path.clone()));
    used
}
