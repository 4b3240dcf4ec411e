//! Views and the cameras that take them.

use std::f32::consts::{FRAC_PI_2, PI};

use super::*;
use crate::accel::Primitive;
use crate::app::editor::camera::navigation::{FlyInput, Navigation};
use crate::app::editor::camera::picking::tests::scene_of;
use crate::app::editor::camera::pose::view_pose;
use crate::app::editor::camera::walking::{Body, Gait};
use crate::app::editor::command::{CameraEdit, HistoryCommand, ViewCommand};
use crate::app::editor::commands::view;
use crate::scene::{FreeView, LengthUnit};

#[test]
fn undo_takes_the_camera_and_the_view_back() {
    let mut world = bare_world();
    let camera = add(&mut world, AdditionKind::Camera);
    say(&mut world, ViewCommand::LookThrough(camera));
    let there = Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0));
    say(&mut world, ViewCommand::MoveView(there));
    let before = (world.get::<ToWorld>(camera).copied(), *world.resource::<FreeView>());
    say(&mut world, CameraEdit::MoveCameraToView);
    assert_eq!(world.get::<ToWorld>(camera), Some(&ToWorld(there)));
    assert_eq!(*world.resource::<FreeView>(), FreeView::default());
    // The view has gone elsewhere since.
    say(&mut world, ViewCommand::MoveView(Affine3A::IDENTITY));
    say(&mut world, HistoryCommand::Undo);
    assert_eq!(
        (world.get::<ToWorld>(camera).copied(), *world.resource::<FreeView>()),
        before
    );
}

/// A floor at the height 0 of 100 x 100 metres in a scene in centimetres, with a wall 3 m away along z.
fn floor_and_wall() -> PackedScene {
    let square = |turn: Quat, center: Vec3| {
        let pose = Affine3A::from_scale_rotation_translation(Vec3::splat(5000.0), turn, center);
        (Primitive::Rectangle, pose)
    };
    let floor = square(Quat::from_rotation_x(-FRAC_PI_2), Vec3::ZERO);
    let wall = square(Quat::from_rotation_y(PI), Vec3::Z * 300.0);
    PackedScene {
        scene: Some(scene_of([floor, wall].into_iter())),
        entity_of_instance: [1, 2]
            .map(|index| Entity::from_raw_u32(index).expect("small"))
            .to_vec()
            .into(),
        ..PackedScene::default()
    }
}

#[test]
fn a_view_that_walks_has_eyes_above_the_floor_and_is_held_by_walls() {
    let mut world = bare_world();
    let camera = add(&mut world, AdditionKind::Camera);
    say(&mut world, ViewCommand::LookThrough(camera));
    say(
        &mut world,
        ViewCommand::MoveView(Affine3A::from_translation(Vec3::Y * 700.0)),
    );
    let walks = |world: &World| world.resource::<ViewSettings>().walks;
    world.insert_resource(LengthUnit::Centimetre);
    assert!(
        view::apply(&mut world, ViewCommand::Walk(true)).is_err(),
        "there is no floor"
    );
    assert!(!walks(&world));
    world.insert_resource(floor_and_wall());
    say(&mut world, ViewCommand::SwitchProjection);
    assert!(
        view::apply(&mut world, ViewCommand::Walk(true)).is_err(),
        "the view is orthographic"
    );
    say(&mut world, ViewCommand::SwitchProjection);
    say(&mut world, ViewCommand::Walk(true));
    assert!(walks(&world));
    let mut pose = view_pose(&world).expect("a view");
    assert!((pose.translation.y - 165.0).abs() < 0.1, "{}", pose.translation);

    let ahead = FlyInput {
        direction: Vec3::Z,
        seconds: 1.0 / 30.0,
        ..FlyInput::default()
    };
    let (body, packed) = (Body::person(LengthUnit::Centimetre), world.resource::<PackedScene>());
    let mut gait = Gait::default();
    for frame in 0..90 {
        pose = gait.follow(&body, &Navigation::default(), pose, &ahead, packed);
        if frame == 29 {
            assert!((pose.translation.z - 150.0).abs() < 1.0, "{}", pose.translation);
        }
    }
    let end = Vec3::from(pose.translation);
    assert!(end.abs_diff_eq(Vec3::new(0.0, 165.0, 275.0), 1.0), "{end}");
    say(&mut world, ViewCommand::Walk(false));
    assert!(!walks(&world));
}
