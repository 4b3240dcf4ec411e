//! Drawn and cut blocks, in a world without a window.

use super::*;
use crate::app::editor::command::blocking::block::Block;
use crate::app::editor::command::blocking::{BlockKind, Reshaping};
use crate::app::editor::command::{HistoryCommand, SceneEdit, ToolCommand};
use crate::scene::{Declared, MemberOf, Opening, ParameterMut, Solid};

#[test]
fn a_wall_gets_no_more_openings_than_a_file_may_have() {
    let mut world = bare_world();
    let entity = add(&mut world, AdditionKind::Solid("wall"));
    let with = |count| {
        let wall = Solid::Wall {
            length: 4.0,
            height: 2.5,
            thickness: 0.2,
            openings: vec![Opening::DOOR; count],
        };
        let kind = ShapeKind::Solid(wall);
        let shape = Shape {
            kind,
            ..Shape::default()
        };
        Command::from(SceneEdit::Reshape(entity, shape, Affine3A::IDENTITY, Reshaping::Cut))
    };
    assert!(apply(&mut world, with(Solid::MOST_OPENINGS)).is_ok());
    let before = ObjectState::of(&world, entity);
    let refused = apply(&mut world, with(Solid::MOST_OPENINGS + 1));
    assert!(refused.is_err_and(|error| error.to_string().contains("at most 64 openings")));
    assert_eq!(ObjectState::of(&world, entity), before);
}

#[test]
fn walls_are_joined_to_those_that_one_sees_and_undo_parts_them() {
    let draw = |from, to| Command::from(SceneEdit::Build(Box::new(Block::wall(from, to))));
    let length = |world: &World, wall: Entity| match world.get::<Shape>(wall).map(|shape| shape.kind.clone()) {
        Some(ShapeKind::Solid(Solid::Wall { length, .. })) => length,
        other => panic!("{other:?}"),
    };
    // The lengths of two walls that meet, and that of the first one after an undo.
    let lengths = |change: &dyn Fn(&mut World, Entity)| {
        let mut world = bare_world();
        say(&mut world, draw(Vec3::ZERO, Vec3::X * 4.0));
        let first = world.resource::<Selection>().active().expect("it is selected");
        change(&mut world, first);
        say(&mut world, draw(Vec3::X * 4.0, Vec3::new(4.0, 0.0, 3.0)));
        let second = world.resource::<Selection>().active().expect("it is selected");
        let joined = [length(&world, first), length(&world, second)];
        say(&mut world, HistoryCommand::Undo);
        [joined[0], joined[1], length(&world, first)]
    };
    let are = |lengths: [f32; 3], expected: [f32; 3]| {
        let off = lengths
            .iter()
            .zip(expected)
            .map(|(length, expected)| (length - expected).abs());
        assert!(off.fold(0.0, f32::max) < 1e-5, "{lengths:?}");
    };
    are(lengths(&|_, _| {}), [4.1, 2.9, 4.0]);
    let hide = |world: &mut World, first: Entity| {
        world.entity_mut(first).insert(Hidden);
    };
    are(lengths(&hide), [4.0, 3.0, 4.0]);
    let group = |world: &mut World, first: Entity| {
        let group = world.spawn_empty().id();
        world.entity_mut(first).insert(MemberOf(group));
    };
    are(lengths(&group), [4.0, 3.0, 4.0]);
}

#[test]
fn the_step_stays_while_one_builds_and_is_no_preference() {
    let mut world = bare_world();
    let set_size = |world: &mut World, size: f32| {
        world.resource_mut::<ViewSettings>().navigation.scene_size = size;
    };
    let step = |world: &World| world.resource::<ViewSettings>().length_step();
    set_size(&mut world, 5.0);
    say(&mut world, ToolCommand::SetTool(Tool::Draw(BlockKind::Wall)));
    set_size(&mut world, 50.0);
    assert_eq!(step(&world), 0.1);
    say(&mut world, ToolCommand::SetTool(Tool::Push));
    assert_eq!(step(&world), 0.1);
    let steps = world.resource::<ViewSettings>().gizmo.steps;
    assert_eq!(steps.length, None, "the next scene has a step of its own");
    let with = |length| {
        let gizmo = GizmoSettings {
            steps: Steps { length, ..steps },
            ..GizmoSettings::default()
        };
        Command::from(ToolCommand::SetGizmo(gizmo))
    };
    say(&mut world, with(Some(0.3)));
    assert_eq!(step(&world), 0.3, "what is chosen counts");
    say(&mut world, with(None));
    assert_eq!(step(&world), 1.0, "and then again what suits the scene");
}

#[test]
fn what_is_built_has_short_numbers() {
    let mut world = bare_world();
    let (low, high) = (Vec3::new(-4.7, 0.0, 0.7), Vec3::new(4.3, 0.0, 6.7));
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z);
    let ring = [low, corner(high.x, low.z), high, corner(low.x, high.z), low];
    for ends in ring.windows(2) {
        say(&mut world, SceneEdit::Build(Box::new(Block::wall(ends[0], ends[1]))));
    }
    let floor = Block {
        kind: BlockKind::Floor,
        height: 0.1,
        ..Block::wall(low, high)
    };
    say(&mut world, SceneEdit::Build(Box::new(floor)));
    let mut shapes = world.query::<(&Shape, &ToWorld)>();
    for (shape, ToWorld(pose)) in shapes.iter(&world) {
        let mut numbers = Vec3::from(pose.translation).to_array().to_vec();
        if let ShapeKind::Solid(part) = &shape.kind {
            part.clone().visit_lengths(&mut |length| numbers.push(*length));
        }
        assert!(
            numbers.iter().all(|number| number.to_string().len() <= 5),
            "{numbers:?}"
        );
    }
}

#[test]
fn a_roof_covers_the_selected_walls() {
    let mut world = bare_world();
    // Four walls of 2.5 around 4 x 8; they are 0.2 thick.
    let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 8.0), (0.0, 8.0)].map(|(x, z)| Vec3::new(x, 0.0, z));
    let mut walls = Vec::new();
    for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        say(&mut world, SceneEdit::Build(Box::new(Block::wall(*from, *to))));
        walls.extend(world.resource::<Selection>().active());
    }
    say(&mut world, SelectionCommand::Select(walls, Extend::Replace));
    for plugin in ["gableroof", "hiproof", "shedroof"] {
        let before = world.resource::<Selection>().clone();
        say(&mut world, SceneEdit::Cover(plugin));
        let roof = world.resource::<Selection>().active().expect("it was added");
        let Some(ShapeKind::Solid(part)) = world.get::<Shape>(roof).map(|shape| shape.kind.clone()) else {
            panic!("no roof");
        };
        assert_eq!(part.plugin(), plugin);
        let numbers = part.roof().expect("a roof");
        assert!(
            (numbers.width - 8.2).abs() < 1e-4 && (numbers.depth - 4.2).abs() < 1e-4,
            "{numbers:?}"
        );
        let pose = world.get::<ToWorld>(roof).expect("a pose").0;
        assert!(
            Vec3::from(pose.translation).abs_diff_eq(Vec3::new(2.0, 2.5, 4.0), 1e-3),
            "{pose:?}"
        );
        // The ridge runs along the longer side, and the slopes rise.
        let [x, z] = [pose.matrix3.x_axis, pose.matrix3.z_axis].map(Vec3::from);
        assert!(
            x.z.abs() > 0.999 && z.y > 0.999 && pose.matrix3.determinant() > 0.999,
            "{pose:?}"
        );
        say(&mut world, HistoryCommand::Undo);
        assert!(!ObjectState::is_in_scene(&world, roof));
        world.insert_resource(before);
    }
    say(&mut world, SelectionCommand::Select(Vec::new(), Extend::Replace));
    assert!(apply_now(&mut world, SceneEdit::Cover("hiproof")).is_err());
}

#[test]
fn another_form_of_roof_changes_roofs_alone_and_keeps_their_lengths() {
    let mut world = bare_world();
    let roof = |width: f32| {
        let mut part = Solid::of_plugin("gableroof").expect("a roof");
        part.visit_mut(&mut |info, value| {
            if let (ParameterMut::Length(length), "width") = (value, info.name) {
                *length = width;
            }
        });
        part
    };
    let kinds = [
        ShapeKind::Solid(Solid::default()),
        ShapeKind::Cube,
        ShapeKind::Solid(roof(4.0)),
        ShapeKind::Solid(roof(9.0)),
    ];
    let shapes = kinds.clone().map(|kind| {
        let shape = Shape {
            kind,
            ..Shape::default()
        };
        world.spawn((shape, ToWorld::default())).id()
    });
    say(&mut world, SelectionCommand::Select(shapes.to_vec(), Extend::Replace));
    let hip = |width: f32| ShapeKind::Solid(roof(width).roof_as("hiproof").expect("a roof"));
    let edited = Shape {
        kind: hip(9.0),
        ..Shape::default()
    };
    let edit = ValueEdit::SetShape(shapes[3], edited);
    say(&mut world, EditCommand::OnSelection(Box::new(edit)));
    let now = shapes.map(|shape| world.get::<Shape>(shape).expect("a shape").kind.clone());
    assert_eq!(now, [kinds[0].clone(), ShapeKind::Cube, hip(4.0), hip(9.0)]);
}
