//! What of a file joins a scene, and what stays with the file.

use bevy::prelude::*;
use sunroom::app::editor::command::SceneEdit;
use sunroom::app::editor::commands::apply;
use sunroom::app::editor::commands::bare_world::bare_world;
use sunroom::scene::{Emitter, Shape};

use crate::numbers::Window;

/// A triangle, and perhaps a light.
const CARD: &str = r#"{"asset": {"version": "2.0"}, "materials": [{"name": "red"}],
  "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}], "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}], "nodes": [{"mesh": 0}, LIGHT],
  "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "name": "studio"}]}}}"#;

fn count<C: Component>(world: &mut World) -> usize {
    world.query::<&C>().iter(world).count()
}

/// A file that nothing lights is opened with a studio around it, which is not a part of it.
#[test]
fn what_stands_in_for_light_is_not_imported() {
    let folder = tempfile::tempdir().expect("a folder");
    let lit = r#"{"extensions": {"KHR_lights_punctual": {"light": 0}}}"#;
    for (name, light, expected) in [("dark.gltf", "{}", 0), ("lit.gltf", lit, 1)] {
        let path = folder.path().join(name);
        std::fs::write(&path, CARD.replace("LIGHT", light)).expect("a file");
        let mut world = bare_world();
        for times in 1..=2 {
            apply(&mut world, SceneEdit::Import(path.clone())).expect("it can be imported");
            assert_eq!(count::<Shape>(&mut world), times, "{name}");
            // A light of the file comes along, whatever it is called.
            assert_eq!(count::<Emitter>(&mut world), times * expected, "{name}");
        }
    }
}

/// Files of the same name from several glTF files lie beside a scene under different names, also if they came between
/// two saves.
#[test]
fn a_later_import_leaves_the_files_of_an_earlier_one() {
    let mut window = Window::on("  <shape type=\"sphere\" id=\"ball\"/>");
    let folder = window.path.parent().expect("a folder").to_owned();
    let import = |window: &mut Window, name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).expect("a file");
        apply(&mut window.world, SceneEdit::Import(path)).expect("it can be imported");
        window.saved()
    };
    let card = CARD.replace("LIGHT", "{}");
    let first = import(&mut window, "a.gltf", &card);
    let mesh = folder.join("scene-files/mesh-0.ply");
    let before = std::fs::read(&mesh).expect("it lies beside the scene");
    // Its third corner is at (0, 2, 0).
    let second = import(
        &mut window,
        "b.gltf",
        &card.replace("AAAAAAAAgD8AAAAA", "AAAAAAAAAEAAAAAA"),
    );
    assert!(std::fs::read(&mesh).expect("it is still there") == before);
    assert!(
        first.contains("scene-files/mesh-0.ply") && !first.contains("2-mesh"),
        "{first}"
    );
    assert!(
        second.contains("scene-files/mesh-0.ply") && second.contains("scene-files/2-mesh-0.ply"),
        "{second}"
    );
    assert!(std::fs::read(folder.join("scene-files/2-mesh-0.ply")).expect("the other one") != before);
}
