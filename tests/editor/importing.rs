//! What of a file joins a scene, and what stays with the file.

use bevy::prelude::*;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::{HistoryCommand, SceneEdit};
use sunroom::app::editor::commands::apply;
use sunroom::app::editor::commands::bare_world::bare_world;
use sunroom::scene::{Emitter, Shape, ShapeKind};

use crate::numbers::Window;

/// A triangle, and perhaps a light.
const CARD: &str = r#"{"asset": {"version": "2.0"}, "materials": [{"name": "red"}],
  "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}], "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}], "nodes": [{"mesh": 0}, LIGHT],
  "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "name": "studio"}]}}}"#;

/// The number of shapes that are no groups.
fn surfaces(world: &mut World) -> usize {
    let mut shapes = world.query::<&Shape>();
    shapes
        .iter(world)
        .filter(|shape| shape.kind != ShapeKind::Frame)
        .count()
}

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
            assert_eq!(surfaces(&mut world), times, "{name}");
            // A light of the file comes along, whatever it is called.
            assert_eq!(count::<Emitter>(&mut world), times * expected, "{name}");
        }
    }
}

/// The names of all things but materials, and which of them is active.
fn things(world: &mut World) -> (Vec<String>, String) {
    let mut named = world.query_filtered::<&Name, Or<(With<Shape>, With<Emitter>)>>();
    let mut names: Vec<String> = named.iter(world).map(Name::to_string).collect();
    names.sort();
    let active = world.resource::<Selection>().active();
    let active = active.and_then(|active| world.get::<Name>(active));
    (names, active.map_or_else(String::new, Name::to_string))
}

/// Another import of the file gets another group, one step takes it away, and the file with the scene has the group.
#[test]
fn a_gltf_file_comes_as_a_group_of_its_name() {
    let mut window = Window::on("  <shape type=\"sphere\" id=\"ball\"/>");
    let folder = window.path.parent().expect("a folder").to_owned();
    let lamp = r#"{"name": "globe", "extensions": {"KHR_lights_punctual": {"light": 0}}}, {"name": "foot (oak)", "mesh": 0},
        {"name": "shade", "children": [4], "translation": [0, 1, 0]}, {"name": "paper", "mesh": 0}"#;
    let path = folder.join("desk.lamp.gltf");
    let text = CARD.replace(
        r#"{"mesh": 0}, LIGHT"#,
        &format!(r#"{{"name": "cord", "mesh": 0}}, {lamp}"#),
    );
    std::fs::write(&path, text).expect("a file");
    let before = things(&mut window.world).0;
    let import = |world: &mut World| {
        apply(world, SceneEdit::Import(path.clone())).expect("it can be imported");
        things(world)
    };
    let inside = ["", "cord", "foot (oak)", "globe", "shade/", "shade/paper"];
    let (names, active) = import(&mut window.world);
    assert_eq!(active, "desk-lamp/");
    let expected = before
        .iter()
        .cloned()
        .chain(inside.map(|name| format!("desk-lamp/{name}")));
    let mut expected: Vec<String> = expected.collect();
    expected.sort();
    assert_eq!(names, expected);
    let (names, active) = import(&mut window.world);
    assert_eq!(active, "desk-lamp-2/");
    assert!(names.iter().any(|name| name == "desk-lamp-2/shade/paper"), "{names:?}");
    let text = window.saved();
    assert!(
        text.contains("\"desk-lamp-2/foot (oak)\"") && text.contains("\"desk-lamp/\""),
        "{text}"
    );
    apply(&mut window.world, HistoryCommand::Undo).expect("an edit");
    apply(&mut window.world, HistoryCommand::Undo).expect("an edit");
    assert_eq!(things(&mut window.world).0, before);
    // A single thing needs no group.
    let path = folder.join("card.gltf");
    std::fs::write(&path, CARD.replace("LIGHT", "{}")).expect("a file");
    apply(&mut window.world, SceneEdit::Import(path)).expect("it can be imported");
    assert_eq!(things(&mut window.world).1, "card");
}

/// The outermost group has the name of the file already, and a smaller one is inside it.
#[test]
fn the_outermost_group_of_a_gltf_file_is_active() {
    let mut world = bare_world();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("lamp.gltf");
    let nodes = r#"{"name": "lamp", "children": [1, 2], "translation": [1, 0, 0]}, {"name": "foot", "mesh": 0},
        {"name": "shade", "children": [3, 4], "translation": [0, 1, 0]}, {"name": "paper", "mesh": 0}, {"name": "wire", "mesh": 0}"#;
    std::fs::write(&path, CARD.replace(r#"{"mesh": 0}, LIGHT"#, nodes)).expect("a file");
    apply(&mut world, SceneEdit::Import(path)).expect("it can be imported");
    let (names, active) = things(&mut world);
    assert_eq!(active, "lamp/");
    assert!(names.iter().any(|name| name == "lamp/shade/"), "{names:?}");
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
