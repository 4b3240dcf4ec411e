//! What of a file joins a scene, and what stays with the file.

use bevy::prelude::*;
use sunroom::app::editor::command::Command;
use sunroom::app::editor::commands::apply;
use sunroom::app::editor::commands::bare_world::bare_world;
use sunroom::scene::{Emitter, Shape};

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
            apply(&mut world, Command::Import(path.clone())).expect("it can be imported");
            assert_eq!(count::<Shape>(&mut world), times, "{name}");
            // A light of the file comes along, whatever it is called.
            assert_eq!(count::<Emitter>(&mut world), times * expected, "{name}");
        }
    }
}
