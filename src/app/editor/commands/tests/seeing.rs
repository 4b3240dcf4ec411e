//! The filters of the view: they follow commands, and are passed to the renderer.

use super::*;
use crate::app::editor::camera::pose::view_pose;
use crate::app::editor::command::axis_view::AxisView;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::seeing::{CutOpen, Seeing, Walls};
use crate::app::editor::command::{SceneEdit, SelectionCommand, ViewCommand};
use crate::engine::SightControl;

fn sight(world: &World) -> SightControl {
    world.resource::<RenderControl>().sight.clone()
}

fn walls(world: &World) -> Walls {
    world.resource::<ViewSettings>().seeing.walls
}

/// A world with a camera in use.
fn with_camera() -> (World, Entity) {
    let mut world = bare_world();
    let camera = world
        .spawn((Sensor::default(), ToWorld(Affine3A::IDENTITY), DocumentOrder(0)))
        .id();
    say(&mut world, ViewCommand::LookThrough(camera));
    (world, camera)
}

#[test]
fn views_along_an_axis_hide_walls_until_another_view() {
    let (mut world, camera) = with_camera();
    assert_eq!(sight(&world), SightControl::default());
    say(&mut world, ViewCommand::LookAlong(AxisView::Top));
    assert!(sight(&world).passes_backs && walls(&world) == Walls::HiddenForAxis);
    say(&mut world, ViewCommand::LookThrough(camera));
    assert!(!sight(&world).passes_backs);

    // Walls that the user has hidden stay hidden.
    let hidden = Seeing::default().with_walls_switched();
    say(&mut world, ViewCommand::SetSeeing(hidden));
    say(&mut world, ViewCommand::LookAlong(AxisView::Front));
    say(&mut world, ViewCommand::LookThrough(camera));
    assert_eq!((sight(&world).passes_backs, walls(&world)), (true, Walls::Hidden));
    say(&mut world, ViewCommand::SetSeeing(hidden.with_walls_switched()));

    world.insert_resource(Preferences {
        axis_views_hide_walls: false,
        ..Preferences::default()
    });
    say(&mut world, ViewCommand::LookAlong(AxisView::Top));
    assert_eq!((sight(&world).passes_backs, walls(&world)), (false, Walls::Shown));
}

#[test]
fn a_stored_view_hides_the_walls_that_it_was_stored_without() {
    let (mut world, camera) = with_camera();
    say(&mut world, ViewCommand::StoreView(1));
    say(&mut world, ViewCommand::LookAlong(AxisView::Top));
    say(&mut world, ViewCommand::StoreView(2));
    say(&mut world, ViewCommand::LookThrough(camera));
    say(&mut world, ViewCommand::RecallView(2));
    assert!(sight(&world).passes_backs && walls(&world) == Walls::HiddenForAxis);
    say(&mut world, ViewCommand::RecallView(1));
    assert!(!sight(&world).passes_backs && walls(&world) == Walls::Shown);
}

#[test]
fn views_along_an_axis_are_about_the_point_that_the_view_was_turned_about() {
    let (mut world, _) = with_camera();
    let looked_at = |world: &World, distance: f32| {
        let pose = view_pose(world).expect("a view");
        Vec3::from(pose.translation) + distance * Vec3::from(pose.matrix3.z_axis)
    };
    let pivot = Vec3::new(0.0, 0.0, 7.0);
    say(&mut world, ViewCommand::TurnAbout(pivot));
    for view in [AxisView::Top, AxisView::Right, AxisView::Back] {
        say(&mut world, ViewCommand::LookAlong(view));
        assert!(looked_at(&world, 7.0).abs_diff_eq(pivot, 1e-4), "{view:?}");
    }
    // The user has turned away from it.
    let away = Affine3A::from_rotation_y(1.0);
    say(&mut world, ViewCommand::MoveView(away));
    say(&mut world, ViewCommand::LookAlong(AxisView::Top));
    let size = world.resource::<ViewSettings>().navigation.scene_size;
    let ahead = Vec3::from(0.5 * size * away.matrix3.z_axis);
    assert!(looked_at(&world, 0.5 * size).abs_diff_eq(ahead, 1e-4));
}

#[test]
fn a_cut_plane_leaves_out_its_side() {
    let mut world = bare_world();
    let cut = |axis, at, above| {
        Command::from(ViewCommand::SetSeeing(Seeing {
            cut: Some(CutOpen { axis, at, above }),
            ..Seeing::default()
        }))
    };
    let sees = |world: &World, at: Vec3| {
        let plane = sight(world).cut.expect("a plane");
        plane.normal.dot(at) < plane.offset
    };
    say(&mut world, cut(1, 2.0, true));
    assert!(sees(&world, Vec3::ZERO) && !sees(&world, 3.0 * Vec3::Y));
    say(&mut world, cut(1, 2.0, false));
    assert!(!sees(&world, Vec3::ZERO) && sees(&world, 3.0 * Vec3::Y));
    // There is no such axis.
    say(&mut world, cut(7, 2.0, false));
    assert_eq!(sight(&world), SightControl::default());
    assert!(apply(&mut world, ViewCommand::CutOpen).is_err(), "the scene is empty");
}

#[test]
fn shapes_are_shown_alone_as_long_as_they_are_there() {
    let (mut world, camera) = with_camera();
    let [a, b] = [add(&mut world, AdditionKind::Cube), add(&mut world, AdditionKind::Disk)];
    assert!(apply(&mut world, ViewCommand::Isolate(vec![camera])).is_err());
    say(&mut world, ViewCommand::Isolate(vec![a, camera]));
    assert_eq!(sight(&world).only, [a]);
    say(&mut world, SelectionCommand::Select(vec![b], Extend::Replace));
    assert_eq!(sight(&world).only, [a], "it is not the selection");
    say(&mut world, SelectionCommand::Select(vec![a], Extend::Replace));
    say(&mut world, SceneEdit::Delete);
    assert_eq!(sight(&world), SightControl::default());
}
