//! What is drawn and cut, in a world without a window.

use super::*;
use crate::app::editor::command::blocking::block::{Block, Plane};
use crate::app::editor::command::blocking::{BlockKind, Reshaping};
use crate::scene::{MemberOf, Opening, Solid};

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
        Command::Reshape(entity, shape, Affine3A::IDENTITY, Reshaping::Cut)
    };
    assert!(apply(&mut world, with(Solid::MOST_OPENINGS)).is_ok());
    let before = ObjectState::of(&world, entity);
    let refused = apply(&mut world, with(Solid::MOST_OPENINGS + 1));
    assert!(refused.is_err_and(|error| error.to_string().contains("at most 64 openings")));
    assert_eq!(ObjectState::of(&world, entity), before);
}

#[test]
fn walls_reach_around_the_corners_that_one_sees() {
    let draw = |from, to| {
        Command::Build(Box::new(Block {
            kind: BlockKind::Wall,
            name: None,
            from,
            to,
            plane: Plane::of_normal(Vec3::Y, Vec3::Y),
            height: 2.5,
            thickness: 0.2,
        }))
    };
    let second_length = |hide: &dyn Fn(&mut World, Entity)| {
        let mut world = bare_world();
        say(&mut world, draw(Vec3::ZERO, Vec3::X * 4.0));
        let first = world.resource::<Selection>().active().expect("it is selected");
        hide(&mut world, first);
        say(&mut world, draw(Vec3::X * 4.0, Vec3::new(4.0, 0.0, 3.0)));
        let second = world.resource::<Selection>().active().expect("it is selected");
        match world.get::<Shape>(second).map(|shape| shape.kind.clone()) {
            Some(ShapeKind::Solid(Solid::Wall { length, .. })) => length,
            other => panic!("{other:?}"),
        }
    };
    let is = |length: f32, expected: f32| assert!((length - expected).abs() < 1e-5, "{length}");
    is(second_length(&|_, _| {}), 3.1);
    let hide = |world: &mut World, first: Entity| {
        world.entity_mut(first).insert(Hidden);
    };
    is(second_length(&hide), 3.0);
    let group = |world: &mut World, first: Entity| {
        let group = world.spawn_empty().id();
        world.entity_mut(first).insert(MemberOf(group));
    };
    is(second_length(&group), 3.0);
}
