//! Markers: volumes that nothing refers to in the file, and lights that give no light in the scene.

use std::path::Path;

use bevy::math::{Affine3A, Vec3};
use sunroom::document::{self, parse_str};
use sunroom::scene::description::{EmitterDescription, Identity};
use sunroom::scene::marker::{line_of, points_of, type_of};
use sunroom::scene::read::read;
use sunroom::scene::write::{Extensions, save_description, write_anew};
use sunroom::scene::{Emitter, EmitterKind, SceneDescription};

const SCENE: &str = r#"<scene version="3.0.0">
  <sensor type="perspective"/>
  <volume type="constvolume" id="start">
    <float name="value" value="1"/>
    <default name="marker: form" value="point"/>
    <transform name="to_world"><translate value="0, 0, 4"/></transform>
    <default name="type: text" value="spawn"/>
  </volume>
  <volume type="constvolume" id="patrol">
    <float name="value" value="1"/>
    <default name="marker: form" value="path"/>
    <default name="points: vector list" value="0, 0, 0; 4, 0, 0; 4, 0, 3"/>
    <default name="closed: boolean" value="true"/>
  </volume>
  <volume type="constvolume" id="room/"><float name="value" value="1"/></volume>
</scene>
"#;

fn described(path: &Path) -> SceneDescription {
    let mut document = document::load(path, &[]).unwrap();
    let scene = read(&mut document);
    assert!(document.diagnostics.list.is_empty(), "{}", document.diagnostics);
    scene
}

#[test]
fn markers_are_read_and_saved_as_volumes() {
    let folder = tempfile::tempdir().unwrap();
    let main = folder.path().join("main.xml");
    std::fs::write(&main, SCENE).unwrap();
    let mut scene = described(&main);
    let [start, patrol] = &scene.emitters[..] else {
        panic!("{} markers", scene.emitters.len())
    };
    assert_eq!(start.emitter.kind, EmitterKind::MarkerPoint);
    assert_eq!(type_of(start.identity.properties.as_ref()), "spawn");
    assert_eq!(start.to_world, Affine3A::from_translation(4.0 * Vec3::Z));
    let own = patrol.identity.properties.as_ref();
    assert_eq!(points_of(own), [Vec3::ZERO, 4.0 * Vec3::X, Vec3::new(4.0, 0.0, 3.0)]);
    assert_eq!(line_of(own).len(), 4);
    assert!(
        scene
            .emitters
            .iter()
            .all(|it| it.emitter.is_marker() && !it.emitter.shines())
    );
    // The transform of a folder is no marker.
    assert_eq!(scene.shapes.len(), 1);
    save_description(&scene, &main).unwrap();
    assert_eq!(std::fs::read_to_string(&main).unwrap(), SCENE);

    scene.emitters[0].to_world = Affine3A::from_translation(5.0 * Vec3::Z);
    scene.emitters.push(EmitterDescription {
        identity: Identity {
            id: Some("pit".into()),
            name: "pit".into(),
            order: 100,
            ..Identity::default()
        },
        emitter: Emitter::of_plugin("markerbox").unwrap(),
        to_world: Affine3A::from_scale(Vec3::splat(2.0)),
        medium: None,
    });
    save_description(&scene, &main).unwrap();
    let text = std::fs::read_to_string(&main).unwrap();
    let changed = SCENE.replace("0, 0, 4\"", "0, 0, 5\"");
    assert!(text.starts_with(changed.trim_end_matches("</scene>\n")), "{text}");
    for extensions in [Extensions::Keep, Extensions::Approximate] {
        let anew = folder.path().join("anew.xml");
        write_anew(&scene, &anew, extensions).unwrap();
        let found = |scene: &SceneDescription| -> Vec<(Emitter, Affine3A, _)> {
            let all = scene.emitters.iter();
            all.map(|it| (it.emitter.clone(), it.to_world, it.identity.properties.clone()))
                .collect()
        };
        assert_eq!(found(&described(&anew)), found(&scene));
    }
}

#[test]
fn a_form_that_is_not_known_is_an_error() {
    let text = SCENE.replace("value=\"path\"", "value=\"blob\"");
    let mut document = parse_str(text, Path::new("/scene.xml"), &[]);
    let scene = read(&mut document);
    let messages = document.diagnostics.to_string();
    let expected = "expected a form of markers (point, box, sphere, path), found `blob`";
    assert!(messages.contains(expected) && messages.contains("11:"), "{messages}");
    assert_eq!(scene.emitters.len(), 1);
}
