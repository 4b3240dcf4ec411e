//! Drives the handles of a selected wall's openings: drags, Escape and Delete in the picture.

use std::f32::consts::FRAC_PI_2;

use bevy::math::{Affine3A, Mat3, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{self, Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::Harness;
use sunroom::app::editor::camera::screen::Screen;
use sunroom::app::editor::command::blocking::Reshaping;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::tool::Tool;
use sunroom::app::editor::command::{Command, EditCommand, SceneEdit};
use sunroom::app::editor::input::actions::ActionContext;
use sunroom::app::editor::viewport::blocking::hand::BlockTarget;
use sunroom::app::editor::viewport::model::ViewportModel;
use sunroom::app::editor::viewport::state::ViewportState;
use sunroom::app::editor::viewport::viewport;
use sunroom::render::camera::Camera;
use sunroom::scene::{Opening, Shape, ShapeKind, Solid};

use crate::support::{ViewportContent, presses};

const SIZE: egui::Vec2 = vec2(800.0, 600.0);

struct Window {
    tool: Tool,
    commands: Vec<Command>,
    state: ViewportState,
    camera: Camera,
    wall: BlockTarget,
}

/// From before the wall and a little above.
fn pose() -> Affine3A {
    let from = Vec3::new(0.0, 2.0, -6.0);
    let forward = (Vec3::Y - from).normalize();
    let left = Vec3::Y.cross(forward).normalize();
    Affine3A::from_mat3_translation(Mat3::from_cols(left, forward.cross(left), forward), from)
}

/// A wall of 4 x 2.5 x 0.2 with a window and a door, upright along x around the origin.
fn wall() -> BlockTarget {
    let door = Opening {
        from: 2.6,
        ..Opening::DOOR
    };
    BlockTarget {
        entity: Entity::from_raw_u32(1).expect("a small index is valid"),
        shape: Shape {
            kind: ShapeKind::Solid(Solid::Wall {
                length: 4.0,
                height: 2.5,
                thickness: 0.2,
                openings: vec![Opening::WINDOW, door],
            }),
            ..Shape::default()
        },
        pose: Affine3A::from_translation(Vec3::NEG_X * 2.0) * Affine3A::from_rotation_x(-FRAC_PI_2),
    }
}

/// A point of the wall's face before the camera, by the lengths along it and upwards.
fn on_wall(along: f32, upward: f32) -> Vec3 {
    Vec3::new(along - 2.0, upward, -0.1)
}

fn window(tool: Tool) -> Harness<'static, Window> {
    let window = Window {
        tool,
        commands: Vec::new(),
        state: ViewportState::default(),
        camera: Camera::new(pose(), 60.0, 4.0 / 3.0, 0.01, 100.0, None),
        wall: wall(),
    };
    let content = ViewportContent {
        selection: Selection::of([wall().entity]),
        ..ViewportContent::default()
    };
    let mut harness = Harness::builder().with_size(SIZE).build_ui_state(
        move |ui, window: &mut Window| {
            let presses = presses(ui);
            let empty = content.model([800, 600], pose(), window.camera, &presses);
            let model = ViewportModel {
                wall: Some(&window.wall),
                keys: ActionContext {
                    tool: window.tool,
                    ..empty.keys
                },
                ..empty
            };
            let mut commands = Vec::new();
            let mut whole = ui.new_child(egui::UiBuilder::new().max_rect(egui::Rect::from_min_size(Pos2::ZERO, SIZE)));
            whole.set_clip_rect(whole.max_rect());
            viewport(&mut whole, &model, &mut window.state, &mut commands);
            window.commands.extend(commands);
        },
        window,
    );
    harness.run_steps(3);
    harness
}

fn at(harness: &Harness<Window>, world: Vec3) -> Pos2 {
    let screen = Screen {
        camera: harness.state().camera,
        picture: egui::Rect::from_min_size(Pos2::ZERO, SIZE),
    };
    screen.project(world).expect("in front")
}

fn go(harness: &mut Harness<Window>, world: Vec3) {
    let to = at(harness, world);
    harness.event(egui::Event::PointerMoved(to));
    harness.run_steps(2);
}

fn press(harness: &mut Harness<Window>, world: Vec3, pressed: bool) {
    let pos = at(harness, world);
    harness.event(egui::Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(1);
}

/// A drag whose button stays down.
fn begin(harness: &mut Harness<Window>, from: Vec3, to: Vec3) {
    go(harness, from);
    press(harness, from, true);
    for step in 1..=4 {
        go(harness, from.lerp(to, step as f32 / 4.0));
    }
}

/// The openings after each command, and why the wall was changed.
fn changes(harness: &Harness<Window>) -> Vec<(Vec<Opening>, Reshaping)> {
    let change = |command: &Command| match command {
        Command::Edit(EditCommand::Scene(SceneEdit::Reshape(_, shape, pose, why))) if *pose == wall().pose => {
            match &shape.kind {
                ShapeKind::Solid(Solid::Wall { openings, .. }) => Some((openings.clone(), *why)),
                _ => None,
            }
        }
        _ => None,
    };
    harness.state().commands.iter().filter_map(change).collect()
}

fn deletes(harness: &Harness<Window>) -> bool {
    let is_it = |command: &Command| matches!(command, Command::Edit(EditCommand::Scene(SceneEdit::Delete)));
    harness.state().commands.iter().any(is_it)
}

fn is(found: &Opening, expected: [f32; 4]) {
    let numbers = [found.from, found.sill, found.width, found.height];
    let off = (0..4).map(|k| (numbers[k] - expected[k]).abs()).fold(0.0, f32::max);
    assert!(off < 1e-4, "{numbers:?} {expected:?}");
}

#[test]
fn the_middle_of_a_window_takes_it_along() {
    let mut harness = window(Tool::Select);
    let (from, to) = (on_wall(1.1, 1.5), on_wall(1.33, 1.08));
    begin(&mut harness, from, to);
    press(&mut harness, to, false);
    harness.run_steps(2);
    let made = changes(&harness);
    assert!(made.iter().all(|(_, why)| *why == Reshaping::Move) && !made.is_empty());
    let (openings, _) = made.last().expect("it moved");
    // On the grid of half a unit; the door stays.
    is(&openings[0], [0.8, 0.5, 1.2, 1.2]);
    is(&openings[1], [2.6, 0.0, 0.9, 2.1]);
}

#[test]
fn an_edge_snaps_to_the_edge_of_another_opening_and_esc_puts_it_back() {
    let mut harness = window(Tool::Select);
    // The window's right edge is dragged near the start of the door, its upper one near the door's top.
    begin(&mut harness, on_wall(1.7, 1.5), on_wall(2.57, 1.5));
    let (openings, _) = changes(&harness).pop().expect("it was resized");
    is(&openings[0], [0.5, 0.9, 2.1, 1.2]);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    let (openings, _) = changes(&harness).pop().expect("it was put back");
    assert_eq!(openings[0], Opening::WINDOW);
    let count = changes(&harness).len();
    go(&mut harness, on_wall(3.0, 1.5));
    assert_eq!(changes(&harness).len(), count);
}

#[test]
fn delete_fills_the_opening_under_the_pointer() {
    let mut harness = window(Tool::Select);
    go(&mut harness, on_wall(3.05, 1.05));
    harness.key_press(Key::Delete);
    harness.run_steps(2);
    assert_eq!(changes(&harness), [(vec![Opening::WINDOW], Reshaping::Fill)]);
    assert!(!deletes(&harness), "the wall itself stays");
    // Beside all handles the key is for the wall, and with another tool nothing is held.
    go(&mut harness, on_wall(2.1, 0.3));
    harness.key_press(Key::Delete);
    harness.run_steps(2);
    assert_eq!((changes(&harness).len(), deletes(&harness)), (1, true));
    let mut harness = window(Tool::Push);
    begin(&mut harness, on_wall(1.1, 1.5), on_wall(1.6, 1.1));
    assert_eq!(changes(&harness), []);
}

#[test]
fn a_click_and_the_jitter_of_a_drag_change_nothing() {
    let mut harness = window(Tool::Select);
    // This edge is not on the grid.
    let edge = on_wall(1.7, 1.5);
    go(&mut harness, edge);
    press(&mut harness, edge, true);
    press(&mut harness, edge, false);
    harness.run_steps(2);
    assert_eq!(changes(&harness), []);
    // The sill is not on the grid either.
    let (from, to) = (on_wall(1.1, 1.5), on_wall(1.33, 1.53));
    begin(&mut harness, from, to);
    press(&mut harness, to, false);
    harness.run_steps(2);
    let (openings, _) = changes(&harness).pop().expect("it moved");
    is(&openings[0], [0.8, 0.9, 1.2, 1.2]);
}

#[test]
fn keys_wait_for_the_end_of_a_drag() {
    let mut harness = window(Tool::Select);
    begin(&mut harness, on_wall(1.1, 1.5), on_wall(1.33, 1.5));
    let count = harness.state().commands.len();
    for key in [Key::Delete, Key::G] {
        harness.key_press(key);
        harness.run_steps(2);
    }
    assert_eq!(harness.state().commands.len(), count);
}

#[test]
fn delete_fills_no_opening_of_a_wall_that_was_selected_later() {
    let mut harness = window(Tool::Select);
    let middle = on_wall(1.1, 1.5);
    go(&mut harness, middle);
    press(&mut harness, middle, true);
    press(&mut harness, middle, false);
    go(&mut harness, on_wall(2.1, 0.3));
    harness.state_mut().wall.entity = Entity::from_raw_u32(2).expect("a small index is valid");
    harness.run_steps(2);
    harness.key_press(Key::Delete);
    harness.run_steps(2);
    assert_eq!((changes(&harness), deletes(&harness)), (vec![], true));
}
