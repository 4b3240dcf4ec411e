//! Exports to glTF, with and without waiting for their end.

use super::*;
use crate::app::editor::command::FileCommand;
use crate::app::editor::commands::exporting::{ExportUnderWay, go_on};
use crate::app::editor::session::toasts::Toasts;
use crate::scene::assets::scene_asset::read_scene;
use crate::scene::{Hidden, spawn};

const SCENE: &str = r#"<scene version="3.0.0"><sensor type="perspective"/><emitter type="constant" id="sky"/>
  <shape type="sphere" id="ball"/><shape type="cube" id="secret"/></scene>"#;

fn names(path: &Path) -> Vec<String> {
    let bytes = crate::files::read(path, crate::files::LARGEST_DATA).expect("it is written");
    let scene = read_scene(bytes, path, &[]).description.clone();
    scene
        .shapes
        .iter()
        .map(|shape| shape.identity.name.to_string())
        .collect()
}

#[test]
fn what_is_hidden_is_left_out_and_losses_are_told_until_they_are_dismissed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.xml");
    let mut world = bare_world();
    let scene = read_scene(SCENE.as_bytes().to_vec(), &path, &[]);
    spawn::spawn_fresh(&mut world, &scene.description);
    let mut shapes = world.query::<(Entity, &SceneId)>();
    let secret = shapes
        .iter(&world)
        .find(|(_, id)| id.0 == "secret")
        .expect("it is there")
        .0;
    world.entity_mut(secret).insert(Hidden);
    let steps = world.resource::<crate::app::editor::session::history::History>().len();

    // A script waits for the end.
    let first = folder.path().join("first.glb");
    apply_now(&mut world, FileCommand::ExportScene(first.clone())).expect("it can be written");
    assert_eq!(names(&first), ["ball"]);
    let told = |world: &World| world.resource::<Toasts>().texts().collect::<Vec<_>>().join("\n");
    for expected in ["light `sky` is left out", "shape `secret` is left out: hidden"] {
        assert!(told(&world).contains(expected), "{}", told(&world));
    }
    assert_eq!(world.resource::<Toasts>().wait(), None);

    // The window goes on meanwhile, and does not begin a second one.
    let second = folder.path().join("second.gltf");
    say(&mut world, FileCommand::ExportScene(second.clone()));
    say(&mut world, FileCommand::ExportScene(folder.path().join("third.glb")));
    assert!(told(&world).contains("still under way"), "{}", told(&world));
    while world.contains_resource::<ExportUnderWay>() {
        go_on(&mut world);
    }
    assert_eq!(names(&second), ["ball"]);
    assert!(!folder.path().join("third.glb").exists());
    // The scene itself has not changed.
    let history = world.resource::<crate::app::editor::session::history::History>();
    assert_eq!(history.len(), steps);

    let nowhere = folder.path().join("absent/level.glb");
    let error = apply_now(&mut world, FileCommand::ExportScene(nowhere)).expect_err("there is no folder");
    assert!(error.to_string().contains("there is no folder"), "{error}");
    let error =
        apply_now(&mut world, FileCommand::ExportScene(folder.path().join("level.obj"))).expect_err("another kind");
    assert!(error.to_string().contains("ends with .glb"), "{error}");
}
