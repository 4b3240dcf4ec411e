//! Tests of alignment, distribution and series of copies.

use bevy::math::{Affine3A, Quat};

use super::*;
use crate::app::editor::command::arrange::{Reference, Series, Side, Spacing, Way};
use crate::app::editor::command::{
    ArrangeEdit, HistoryCommand, OutlineEdit, SceneEdit, SelectionCommand, ValueEdit, ViewCommand,
};
use crate::scene::{InstanceOf, MemberOf, ShapeGroup};

/// Cubes of these half sizes at these places along x, all selected.
fn cubes(world: &mut World, sizes_and_places: &[(f32, f32)]) -> Vec<Entity> {
    let made = sizes_and_places.iter().map(|(half, place)| {
        let addition = Addition {
            at: Some(Vec3::X * *place),
            size: Some(*half),
            ..AdditionKind::Cube.into()
        };
        say(world, SceneEdit::Add(addition));
        world.resource::<Selection>().active().expect("it was added")
    });
    let made: Vec<Entity> = made.collect();
    say(world, SelectionCommand::Select(made.clone(), Extend::Replace));
    made
}

fn places(world: &World, things: &[Entity]) -> Vec<f32> {
    let place = |thing: &Entity| world.get::<ToWorld>(*thing).expect("a pose").0.translation.x;
    things.iter().map(place).collect()
}

fn selected(world: &World) -> Vec<Entity> {
    world.resource::<Selection>().entities().to_vec()
}

#[test]
fn a_camera_is_added_at_a_place_or_where_the_view_is() {
    let mut world = bare_world();
    let camera = add(&mut world, AdditionKind::Camera);
    say(&mut world, ViewCommand::LookThrough(camera));
    let view = Affine3A::from_rotation_translation(Quat::from_rotation_y(0.5), Vec3::new(1.0, 2.0, 3.0));
    say(&mut world, ViewCommand::MoveView(view));
    for (at, expected) in [(None, Vec3::new(1.0, 2.0, 3.0)), (Some(Vec3::Y), Vec3::Y)] {
        let kind = AdditionKind::Camera;
        say(&mut world, SceneEdit::Add(Addition { at, ..kind.into() }));
        let added = world.resource::<Selection>().active().expect("it was added");
        let pose = world.get::<ToWorld>(added).expect("a pose").0;
        assert_eq!(Vec3::from(pose.translation), expected);
        assert_eq!(pose.matrix3, view.matrix3);
    }
}

#[test]
fn sides_are_brought_in_line() {
    for (side, to, expected) in [
        (Side::Low, Reference::Bounds, [-0.9, -0.8, -0.5]),
        (Side::High, Reference::Bounds, [5.4, 5.3, 5.0]),
        (Side::Middle, Reference::Active, [5.0, 5.0, 5.0]),
    ] {
        let mut world = bare_world();
        let things = cubes(&mut world, &[(0.1, 0.0), (0.2, -0.8), (0.5, 5.0)]);
        say(&mut world, ArrangeEdit::Align(0, side, to));
        assert_eq!(places(&world, &things), expected, "{side:?} {to:?}");
        say(&mut world, HistoryCommand::Undo);
        assert_eq!(places(&world, &things), [0.0, -0.8, 5.0]);
    }
}

#[test]
fn each_thing_gets_the_size_that_was_typed() {
    let mut world = bare_world();
    let things = cubes(&mut world, &[(0.1, 0.0), (0.2, -0.8), (0.5, 5.0)]);
    let before = things
        .clone()
        .into_iter()
        .map(|thing| pose(&world, thing))
        .collect::<Vec<_>>();
    let turned = before[2] * Affine3A::from_rotation_z(0.3);
    say(&mut world, ValueEdit::Transform(vec![(things[2], turned)]));
    say(&mut world, ArrangeEdit::Resize(0, 0.7));
    for (thing, before) in things.iter().zip(&before).take(2) {
        let now = pose(&world, *thing);
        assert_eq!((now.matrix3.x_axis.x, now.translation), (0.35, before.translation));
        assert_eq!(
            (now.matrix3.y_axis, now.matrix3.z_axis),
            (before.matrix3.y_axis, before.matrix3.z_axis)
        );
    }
    assert_eq!(pose(&world, things[2]), turned);
    say(&mut world, HistoryCommand::Undo);
    assert_eq!(pose(&world, things[0]), before[0]);
    for size in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(apply_now(&mut world, ArrangeEdit::Resize(0, size)).is_err(), "{size}");
    }
}

fn pose(world: &World, thing: Entity) -> Affine3A {
    world.get::<ToWorld>(thing).expect("a pose").0
}

#[test]
fn a_group_is_aligned_as_one() {
    let mut world = bare_world();
    let [a, b] = cubes(&mut world, &[(0.5, 0.0), (0.5, 2.0)])[..] else {
        panic!("two cubes");
    };
    say(&mut world, OutlineEdit::Group);
    let group = selected(&world);
    let far = cubes(&mut world, &[(0.5, 10.0)])[0];
    let all = group.iter().copied().chain([far]).collect();
    say(&mut world, SelectionCommand::Select(all, Extend::Replace));
    say(&mut world, ArrangeEdit::Align(0, Side::High, Reference::Active));
    assert_eq!(places(&world, &[a, b, group[2], far]), [8.0, 10.0, 9.0, 10.0]);
    say(&mut world, SelectionCommand::Select(vec![group[2]], Extend::Replace));
    say(&mut world, ArrangeEdit::SnapToGrid);
    say(&mut world, ArrangeEdit::Nudge(Direction::Up));
    let heights = [a, b, group[2]].map(|it| world.get::<ToWorld>(it).expect("a pose").0.translation.y);
    assert_eq!(heights[0], heights[1]);
    assert!(heights[0] > 0.5, "{heights:?}");
    // A direction of the world moves the whole group by a step along the nearest axis, whatever the view.
    let before = [a, b, group[2]].map(|it| world.get::<ToWorld>(it).expect("a pose").0.translation);
    let step = world.resource::<ViewSettings>().length_step();
    say(&mut world, ArrangeEdit::NudgeAlong(Vec3::new(0.1, 0.2, -0.9)));
    for (thing, before) in [a, b, group[2]].into_iter().zip(before) {
        let moved = Vec3::from(world.get::<ToWorld>(thing).expect("a pose").0.translation - before);
        assert!(moved.abs_diff_eq(-step * Vec3::Z, 1e-6), "{moved}");
    }
}

#[test]
fn steps_along_a_direction_add_up_to_round_numbers() {
    let mut world = bare_world();
    let thing = cubes(&mut world, &[(0.5, 0.5)]);
    let steps = Steps {
        length: Some(0.1),
        ..Steps::default()
    };
    let gizmo = GizmoSettings {
        steps,
        ..GizmoSettings::default()
    };
    say(&mut world, ToolCommand::SetGizmo(gizmo));
    for _ in 0..7 {
        say(&mut world, ArrangeEdit::NudgeAlong(2.0 * Vec3::X));
    }
    assert_eq!(places(&world, &thing), [1.2]);
}

#[test]
fn gaps_or_distances_become_equal() {
    for (by, expected) in [(Spacing::Gaps, [0.0, 2.25, 6.0]), (Spacing::Middles, [0.0, 3.0, 6.0])] {
        let mut world = bare_world();
        let things = cubes(&mut world, &[(0.5, 0.0), (0.5, 1.2), (2.0, 6.0)]);
        say(&mut world, ArrangeEdit::Distribute(0, by));
        assert_eq!(places(&world, &things), expected, "{by:?}");
    }
}

#[test]
fn a_copy_stands_beside_its_original_and_the_next_ones_go_on_like_it() {
    let mut world = bare_world();
    let first = cubes(&mut world, &[(0.5, 0.0)])[0];
    say(&mut world, SceneEdit::Duplicate);
    let second = selected(&world)[0];
    let step = places(&world, &[second])[0].abs();
    assert!(step > 1.0 && step < 1.5, "{step}");
    // The copy is moved and turned, and the next copy is moved and turned from it by the same transform.
    let turn = Quat::from_rotation_y(0.5);
    let pose = Affine3A::from_scale_rotation_translation(Vec3::splat(0.5), turn, Vec3::new(2.0, 0.5, 0.0));
    say(&mut world, ValueEdit::Transform(vec![(second, pose)]));
    say(&mut world, SceneEdit::Duplicate);
    let third = selected(&world)[0];
    let poses = [first, second, third].map(|thing| world.get::<ToWorld>(thing).expect("a pose").0);
    let steps = [poses[1] * poses[0].inverse(), poses[2] * poses[1].inverse()];
    assert!(steps[0].abs_diff_eq(steps[1], 1e-3), "{steps:?}");
    // After something else a copy is beside its original again.
    say(&mut world, OutlineEdit::Rename(third, "last".into()));
    say(&mut world, SceneEdit::Duplicate);
    let fourth = world.get::<ToWorld>(selected(&world)[0]).expect("a pose").0;
    assert!(fourth.translation.distance(poses[2].translation) < 2.0);
}

#[test]
fn rows_and_rings_are_made() {
    let mut world = bare_world();
    cubes(&mut world, &[(0.5, 0.1)]);
    let series = |way, instances| {
        Command::from(SceneEdit::MakeSeries(Series {
            count: 4,
            way,
            instances,
        }))
    };
    say(&mut world, series(Way::Along(Vec3::X * 0.1), false));
    let row = places(&world, &selected(&world));
    assert_eq!(
        row.iter().map(f32::to_string).collect::<Vec<_>>(),
        ["0.1", "0.2", "0.3", "0.4"]
    );
    let mut world = bare_world();
    cubes(&mut world, &[(0.5, 2.0)]);
    let ring = Way::Around {
        axis: 1,
        degrees: 360.0,
        center: Vec3::ZERO,
    };
    say(&mut world, series(ring, false));
    assert_eq!(places(&world, &selected(&world)), [2.0, 0.0, -2.0, 0.0]);
    assert!(
        apply(
            &mut world,
            SceneEdit::MakeSeries(Series {
                count: 1,
                way: ring,
                instances: false
            })
        )
        .is_err()
    );
}

#[test]
fn instances_share_a_group_and_all_of_it_is_undone() {
    let mut world = bare_world();
    let things = cubes(&mut world, &[(0.5, 0.0), (0.5, 3.0)]);
    let series = Series {
        count: 3,
        way: Way::Along(Vec3::Z),
        instances: true,
    };
    say(&mut world, SceneEdit::MakeSeries(series));
    let instances = selected(&world);
    assert_eq!(instances.len(), 3);
    let group = world.get::<InstanceOf>(instances[2]).expect("an instance").0;
    assert!(world.get::<ShapeGroup>(group).is_some());
    for thing in &things {
        assert_eq!(world.get::<MemberOf>(*thing).map(|member| member.0), Some(group));
        let light = Command::from(ValueEdit::SetAreaLight(*thing, Some(AreaLight::default())));
        assert!(apply(&mut world, light).is_err());
    }
    // The members are where they were, as seen through the first instance.
    let first = world.get::<ToWorld>(instances[0]).expect("a pose").0;
    let member = world.get::<ToWorld>(things[0]).expect("a pose").0;
    assert!(
        (first * member)
            .translation
            .abs_diff_eq(Vec3::new(0.0, 0.5, 0.0).into(), 1e-5)
    );
    let text = crate::document::to_xml(&crate::scene::write::to_document(
        &crate::scene::write::gather::describe(&mut world),
        Path::new("/series.xml"),
    ));
    let text = text.expect("it can be written");
    assert!(
        text.contains("shapegroup") && text.matches("type=\"instance\"").count() == 3,
        "{text}"
    );
    say(&mut world, HistoryCommand::Undo);
    assert!(world.get::<MemberOf>(things[0]).is_none());
    assert_eq!(places(&world, &things), [0.0, 3.0]);
    // A light cannot be an instance, and nothing is left of the attempt.
    say(
        &mut world,
        ValueEdit::SetAreaLight(things[0], Some(AreaLight::default())),
    );
    let before = world.resource::<History>().len();
    assert!(apply(&mut world, SceneEdit::MakeSeries(series)).is_err());
    assert_eq!(world.resource::<History>().len(), before);
}
