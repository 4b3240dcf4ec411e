//! Tests of markers.

use super::*;
use crate::scene::Properties;
use crate::scene::marker::{TYPE, type_of};

#[test]
fn markers_are_added_upright_with_a_type() {
    let mut world = bare_world();
    for (plugin, kind, at) in [
        ("markerpoint", "spawn", Vec3::new(1.0, 0.0, 2.0)),
        ("markerbox", "trigger", Vec3::new(0.0, 1.0, 0.0)),
        ("markersphere", "trigger", Vec3::Y),
        ("markerpath", "waypoint", Vec3::X),
    ] {
        let addition = Addition {
            at: Some(at),
            size: Some(0.5),
            ..AdditionKind::Emitter(plugin).into()
        };
        say(&mut world, SceneEdit::Add(addition));
        let marker = world.resource::<Selection>().active().expect("the marker");
        let pose = world.get::<ToWorld>(marker).expect("a pose").0;
        // A box and a sphere stand on the place.
        let lift = if matches!(plugin, "markerbox" | "markersphere") {
            0.5
        } else {
            0.0
        };
        let expected = at + lift * Vec3::Y;
        assert!(
            Vec3::from(pose.translation).abs_diff_eq(expected, 1e-5),
            "{plugin}: {pose}"
        );
        assert!(
            Vec3::from(pose.matrix3.y_axis).normalize().abs_diff_eq(Vec3::Y, 1e-5),
            "{plugin}"
        );
        assert!(pose.matrix3.determinant() > 0.0, "{plugin}");
        assert_eq!(type_of(world.get::<Properties>(marker)), kind);
        assert!(world.get::<Properties>(marker).expect("some").get(TYPE).is_some());
        say(&mut world, HistoryCommand::Undo);
        assert!(!ObjectState::is_in_scene(&world, marker));
    }
}
