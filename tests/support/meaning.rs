//! Scenes without what their files looked like.

use std::path::PathBuf;

use sunroom::scene::{AuthoredScene, SceneDescription};

/// Without what the file looked like: two files that mean the same are equal.
pub fn meaning(scene: &SceneDescription) -> SceneDescription {
    let mut scene = scene.clone();
    scene.remains = AuthoredScene::default();
    scene.sources.clear();
    scene.picture_places.clear();
    scene.volume_places.clear();
    scene.missing.clear();
    scene.path = PathBuf::new();
    let sensors = scene.sensors.iter_mut().map(|item| &mut item.identity);
    let media = scene.media.iter_mut().map(|item| &mut item.identity);
    let materials = scene.materials.iter_mut().map(|item| &mut item.identity);
    let shapes = scene.shapes.iter_mut().map(|item| &mut item.identity);
    let emitters = scene.emitters.iter_mut().map(|item| &mut item.identity);
    let groups = scene.groups.iter_mut().map(|item| &mut item.identity);
    let mut all: Vec<_> = sensors
        .chain(media)
        .chain(materials)
        .chain(shapes)
        .chain(emitters)
        .chain(groups)
        .collect();
    all.sort_by_key(|identity| identity.order);
    for (rank, identity) in (0..).zip(all) {
        identity.order = rank;
        identity.span = Default::default();
        identity.authored = None;
    }
    scene
}
