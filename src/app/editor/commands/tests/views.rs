//! Views and the cameras that take them.

use super::*;
use crate::scene::FreeView;

#[test]
fn undo_takes_the_camera_and_the_view_back() {
    let mut world = bare_world();
    let camera = add(&mut world, AdditionKind::Camera);
    say(&mut world, Command::LookThrough(camera));
    let there = Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0));
    say(&mut world, Command::MoveView(there));
    let before = (world.get::<ToWorld>(camera).copied(), *world.resource::<FreeView>());
    say(&mut world, Command::MoveCameraToView);
    assert_eq!(world.get::<ToWorld>(camera), Some(&ToWorld(there)));
    assert_eq!(*world.resource::<FreeView>(), FreeView::default());
    // The view has gone elsewhere since.
    say(&mut world, Command::MoveView(Affine3A::IDENTITY));
    say(&mut world, Command::Undo);
    assert_eq!(
        (world.get::<ToWorld>(camera).copied(), *world.resource::<FreeView>()),
        before
    );
}
