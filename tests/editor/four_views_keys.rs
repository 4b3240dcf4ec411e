//! Drives the keys in the side views: each acts on the view under the pointer.

use bevy::math::{Affine3A, Vec3};
use bevy_egui::egui::{self, Key, Modifiers, PointerButton, Pos2, vec2};
use sunroom::app::editor::command::tool::Tool;
use sunroom::app::editor::command::{Command, ViewCommand};

use crate::four_views::{FRONT, RIGHT, TOP, at, go, places, press, window};

#[test]
fn keys_that_frame_act_on_the_view_under_the_pointer() {
    let mut harness = window(Tool::Select);
    let pointer = at(&harness, FRONT, 3.0 * Vec3::ONE);
    go(&mut harness, pointer);
    for key in [Key::F, Key::Home] {
        harness.key_press(key);
        harness.run_steps(2);
        let height = harness.state().views.places[FRONT].map(|place| place.height);
        assert!(height.is_some_and(|height| (2.0..3.0).contains(&height)), "{height:?}");
        harness.state_mut().views.places = places();
    }
    harness.state_mut().commands.clear();
    go(&mut harness, Pos2::new(250.0, 380.0));
    harness.key_press(Key::F);
    harness.run_steps(2);
    let framed = Command::from(ViewCommand::FrameSelection);
    assert!(
        harness.state().commands.contains(&framed),
        "{:?}",
        harness.state().commands
    );
}

#[test]
fn a_light_without_extent_is_framed_in_its_view_alone() {
    let mut harness = window(Tool::Select);
    let pointer = at(&harness, FRONT, 3.0 * Vec3::ONE);
    go(&mut harness, pointer);
    let place = Vec3::new(3.0, 2.0, 1.0);
    let target = &mut harness.state_mut().target;
    (target.bounds, target.to_world) = (None, Affine3A::from_translation(place));
    for (is_selected, center, count) in [(false, Vec3::ZERO, 0), (true, place, 1)] {
        harness.state_mut().is_selected = is_selected;
        harness.state_mut().commands.clear();
        harness.key_press(Key::F);
        harness.run_steps(2);
        assert_eq!(harness.state().commands.len(), count, "{:?}", harness.state().commands);
        let shown = harness.state().views.places[FRONT].expect("a place");
        assert_eq!((shown.center, shown.height), (center.into(), 10.0));
    }
}

#[test]
fn arrow_keys_move_things_across_the_view_under_the_pointer() {
    for (side, key, by) in [
        (TOP, Key::ArrowUp, Vec3::NEG_Z),
        (FRONT, Key::ArrowUp, Vec3::Y),
        (FRONT, Key::ArrowRight, Vec3::X),
        (RIGHT, Key::ArrowLeft, Vec3::Z),
    ] {
        let mut harness = window(Tool::Select);
        let pointer = at(&harness, side, 3.0 * Vec3::ONE);
        go(&mut harness, pointer);
        harness.key_press(key);
        harness.run_steps(2);
        let moved = Vec3::from(harness.state().target.to_world.translation);
        assert!(moved.abs_diff_eq(0.5 * by, 1e-5), "view {side}, {key:?}: {moved}");
    }
}

#[test]
fn arrow_keys_move_across_the_view_with_every_tool_that_leaves_them() {
    for tool in [Tool::Ruler, Tool::PlaceTexture] {
        let mut harness = window(tool);
        let pointer = at(&harness, FRONT, 3.0 * Vec3::ONE);
        go(&mut harness, pointer);
        // Both keys go down in one frame.
        for key in [Key::ArrowUp, Key::ArrowRight] {
            harness.input_mut().events.push(egui::Event::Key {
                key,
                physical_key: None,
                pressed: true,
                repeat: false,
                modifiers: Modifiers::NONE,
            });
        }
        harness.run_steps(2);
        let moved = Vec3::from(harness.state().target.to_world.translation);
        assert!(
            moved.abs_diff_eq(Vec3::new(0.5, 0.5, 0.0), 1e-5),
            "{tool:?}: {moved}, {:?}",
            harness.state().commands
        );
    }
}

#[test]
fn a_drag_that_pans_ends_with_its_view() {
    let mut harness = window(Tool::Select);
    let from = at(&harness, TOP, 3.0 * Vec3::ONE);
    go(&mut harness, from);
    press(&mut harness, PointerButton::Middle, from, true);
    go(&mut harness, from + vec2(20.0, 10.0));
    let moved = harness.state().views.places;
    assert_ne!(moved, places());
    harness.key_press(Key::V);
    harness.run_steps(2);
    assert!(!harness.state().views.shown);
    go(&mut harness, from + vec2(60.0, 50.0));
    press(&mut harness, PointerButton::Middle, from + vec2(60.0, 50.0), false);
    let moves = |command: &Command| matches!(command, Command::View(ViewCommand::MoveView(_)));
    assert!(!harness.state().commands.iter().any(moves));
    assert_eq!(harness.state().views.places, moved);
}
