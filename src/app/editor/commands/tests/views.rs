//! Views and the cameras that take them.

use super::*;
use crate::app::editor::command::{CameraEdit, HistoryCommand, ViewCommand};
use crate::scene::FreeView;

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
