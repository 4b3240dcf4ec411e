//! Drives the tool that places textures: drags of the tile's parts come out as transforms of uv.

use std::sync::Arc;

use bevy::math::{Affine2, Affine3A, Vec2, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{self, Id, Key, Modifiers, PointerButton, Pos2, Rect, Sense, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::accel::{Instance, Primitive, SplitMethod, Tlas};
use sunroom::app::editor::camera::screen::Screen;
use sunroom::app::editor::command::selection::Extend;
use sunroom::app::editor::command::texture_placing::{Placing, TextureGroup};
use sunroom::app::editor::command::tool::Tool;
use sunroom::app::editor::command::{Command, EditCommand, SelectionCommand, TextureEdit};
use sunroom::app::editor::input::actions::ActionContext;
use sunroom::app::editor::viewport::model::ViewportModel;
use sunroom::app::editor::viewport::state::ViewportState;
use sunroom::app::editor::viewport::texturing::{TextureTarget, TexturingModel, TexturingState};
use sunroom::app::editor::viewport::viewport;
use sunroom::engine::PackedScene;
use sunroom::render::camera::Camera;
use sunroom::render::scene::RenderScene;
use sunroom::scene::LengthUnit;

use crate::support::{ViewportContent, presses};

struct Window {
    state: TexturingState,
    target: Option<TextureTarget>,
    commands: Vec<Command>,
}

const SIZE: egui::Vec2 = vec2(800.0, 600.0);

fn entity(index: u32) -> Entity {
    Entity::from_raw_u32(index).expect("a small index is valid")
}

/// A rectangle of 8 x 4 before the camera, and one of 2 x 2 beside it.
fn packed() -> PackedScene {
    let poses = [
        Affine3A::from_scale(Vec3::new(4.0, 2.0, 1.0)),
        Affine3A::from_translation(Vec3::new(6.0, 0.0, 0.0)),
    ];
    let instances = poses.map(|pose| Instance::new(Primitive::Rectangle, pose).expect("a good pose"));
    PackedScene {
        scene: Some(RenderScene {
            media: Arc::default(),
            geometry: Arc::new(Tlas::build(instances.into(), SplitMethod::Sah)),
            surfaces: Arc::default(),
            materials: Arc::default(),
            textures: Arc::default(),
            lights: Arc::default(),
            reach: Default::default(),
        }),
        entity_of_instance: vec![entity(1), entity(2)].into(),
        ..PackedScene::default()
    }
}

fn screen() -> Screen {
    let pose = Affine3A::from_translation(Vec3::new(0.0, 0.0, -10.0));
    Screen {
        camera: Camera::new(pose, 90.0, 4.0 / 3.0, 0.01, 1000.0, None),
        picture: Rect::from_min_size(Pos2::ZERO, SIZE),
    }
}

/// Where texture coordinates of the large rectangle are seen.
fn seen(uv: Vec2) -> Pos2 {
    let local = (2.0 * uv - Vec2::ONE).extend(0.0);
    screen()
        .project(local * Vec3::new(4.0, 2.0, 1.0))
        .expect("it is before the camera")
}

fn group(to_uv: Affine2) -> TextureGroup {
    TextureGroup {
        to_uv,
        parameters: vec![("reflectance", "Reflectance")],
    }
}

fn window(groups: &[Affine2]) -> Harness<'static, Window> {
    let window = Window {
        state: TexturingState::default(),
        target: Some(TextureTarget {
            entity: entity(1),
            groups: groups.iter().copied().map(group).collect(),
            upright: Affine2::IDENTITY,
        }),
        commands: Vec::new(),
    };
    let packed = packed();
    let mut harness = Harness::builder().with_size(SIZE).build_ui_state(
        move |ui, window: &mut Window| {
            let model = TexturingModel {
                target: window.target.as_ref(),
                packed: &packed,
                locked: &Default::default(),
                unit: LengthUnit::default(),
            };
            let response = ui.interact(ui.max_rect(), Id::new("picture"), Sense::click_and_drag());
            let screen = screen();
            let presses = presses(ui);
            let mut commands = Vec::new();
            window
                .state
                .follow_tile(ui, &response, &screen, &model, &presses, &mut commands);
            for command in &commands {
                if let (
                    Command::Edit(EditCommand::Texture(TextureEdit::PlaceTextures { before, after, .. })),
                    Some(target),
                ) = (command, &mut window.target)
                {
                    for group in target.groups.iter_mut().filter(|group| group.to_uv == *before) {
                        group.to_uv = *after;
                    }
                }
            }
            window.commands.extend(commands);
        },
        window,
    );
    harness.run_steps(2);
    harness
}

fn button(harness: &mut Harness<'static, Window>, pos: Pos2, pressed: bool, modifiers: Modifiers) {
    harness.event(egui::Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers,
    });
    harness.run_steps(1);
}

fn go(harness: &mut Harness<'static, Window>, pos: Pos2) {
    harness.event(egui::Event::PointerMoved(pos));
    harness.run_steps(2);
}

fn drag(harness: &mut Harness<'static, Window>, from: Pos2, to: Pos2, modifiers: Modifiers) {
    harness.event(egui::Event::ModifiersChanged(modifiers));
    go(harness, from);
    button(harness, from, true, modifiers);
    for step in 1..=4 {
        go(harness, from.lerp(to, step as f32 / 4.0));
    }
    button(harness, to, false, modifiers);
    harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
    harness.run_steps(2);
}

fn to_uv(harness: &Harness<'static, Window>) -> Affine2 {
    harness.state().target.as_ref().expect("a target").groups[0].to_uv
}

#[track_caller]
fn assert_near(found: Affine2, expected: Affine2) {
    assert!(found.abs_diff_eq(expected, 5e-3), "{found:?}, not {expected:?}");
}

#[test]
fn the_picture_moves_with_the_pointer() {
    let mut harness = window(&[Affine2::from_scale(Vec2::new(4.0, 2.0))]);
    // The tile around the middle goes from (0.5, 0.5) to (0.75, 1) of uv.
    let [from, to] = [Vec2::new(0.6, 0.7), Vec2::new(0.65, 0.6)];
    drag(&mut harness, seen(from), seen(to), Modifiers::NONE);
    let expected = Affine2::from_scale_angle_translation(Vec2::new(4.0, 2.0), 0.0, Vec2::new(-0.2, 0.2));
    assert_near(to_uv(&harness), expected);
    // With Control to tenths of a tile.
    let mut harness = window(&[Affine2::from_scale(Vec2::new(4.0, 2.0))]);
    drag(&mut harness, seen(from), seen(to + 0.01), Modifiers::COMMAND);
    let offset = to_uv(&harness).translation;
    assert_eq!(offset, (offset * 10.0).round() / 10.0);
    assert!(offset != Vec2::ZERO, "{offset}");
}

#[test]
fn a_corner_scales_evenly_from_the_opposite_one() {
    let mut harness = window(&[Affine2::from_scale(Vec2::new(4.0, 2.0))]);
    // To a third of the size.
    let [fixed, held] = [Vec2::new(0.5, 0.5), Vec2::new(0.75, 1.0)];
    drag(&mut harness, seen(held), seen(fixed.lerp(held, 0.5)), Modifiers::NONE);
    let after = to_uv(&harness);
    assert_near(
        Affine2 {
            translation: Vec2::ZERO,
            ..after
        },
        Affine2::from_scale(Vec2::new(8.0, 4.0)),
    );
    assert!(
        after.transform_point2(fixed).abs_diff_eq(Vec2::new(2.0, 1.0), 1e-2),
        "what is opposite stays"
    );
}

#[test]
fn an_edge_scales_along_one_axis() {
    let mut harness = window(&[Affine2::from_scale(Vec2::new(4.0, 2.0))]);
    drag(
        &mut harness,
        seen(Vec2::new(0.75, 0.75)),
        seen(Vec2::new(0.7, 0.8)),
        Modifiers::NONE,
    );
    // From a quarter to a fifth of u.
    let expected = Affine2::from_scale_angle_translation(Vec2::new(5.0, 2.0), 0.0, Vec2::new(-0.5, 0.0));
    assert_near(to_uv(&harness), expected);
}

/// The point of the arm's end above the tile around the middle.
fn arm() -> Pos2 {
    // The picture's upper edge is where its v is least.
    let [foot, middle] = [Vec2::new(0.625, 0.5), Vec2::new(0.625, 0.75)].map(seen);
    foot + 34.0 * (foot - middle).normalized()
}

#[test]
fn the_arm_turns_the_picture_and_keeps_its_shape() {
    let start = Affine2::from_scale(Vec2::new(4.0, 2.0));
    let mut harness = window(&[start]);
    let middle = seen(Vec2::new(0.625, 0.75));
    let from = arm();
    let to = middle + (from - middle).rot90();
    drag(&mut harness, from, to, Modifiers::NONE);
    let after = to_uv(&harness);
    // A tile of 2 x 2 in the world is one after a quarter of a turn as well, although u and v are not equally long.
    let lengths = |map: Affine2| {
        let world_from_texture = bevy::math::Mat2::from_diagonal(Vec2::new(8.0, 4.0)) * map.matrix2.inverse();
        [world_from_texture.x_axis, world_from_texture.y_axis]
    };
    let [along, across] = lengths(after);
    assert!(
        (along.length() - 2.0).abs() < 0.02 && (across.length() - 2.0).abs() < 0.02,
        "{after:?}"
    );
    assert!(along.dot(across).abs() < 0.05 && along.x.abs() < 0.05, "{after:?}");
    let tile_middle = start.transform_point2(Vec2::new(0.625, 0.75));
    assert!(
        after
            .transform_point2(Vec2::new(0.625, 0.75))
            .abs_diff_eq(tile_middle, 1e-2)
    );
    // Angles are rounded with Control.
    let mut harness = window(&[Affine2::from_scale(Vec2::new(2.0, 1.0))]);
    let middle = seen(Vec2::new(0.75, 0.5));
    let [foot, end] = [seen(Vec2::new(0.75, 0.0)), seen(Vec2::new(0.75, 0.25))];
    let from = foot + 34.0 * (foot - end).normalized();
    let turned = |degrees: f32| middle + egui::emath::Rot2::from_angle(degrees.to_radians()) * (from - middle);
    drag(&mut harness, from, turned(40.0), Modifiers::COMMAND);
    let degrees = Placing::of(&to_uv(&harness)).expect("an extent").degrees.abs();
    // Half of the rectangle is square, so that the angle in uv is that of tan 45 degrees with u half as long as v.
    let [along, _] = lengths(to_uv(&harness));
    let angle = along.to_angle().to_degrees().abs();
    assert!((angle % 15.0).min(15.0 - angle % 15.0) < 0.01, "{angle}, {degrees}");
    assert!((angle - 45.0).abs() < 0.1, "{angle}");
}

#[test]
fn numbers_can_be_typed_in_a_drag_and_escape_puts_it_back() {
    let start = Affine2::from_scale(Vec2::new(4.0, 2.0));
    let mut harness = window(&[start]);
    let inside = seen(Vec2::new(0.6, 0.7));
    go(&mut harness, inside);
    button(&mut harness, inside, true, Modifiers::NONE);
    for key in [Key::Num0, Key::Period, Key::Num5] {
        harness.key_press(key);
        harness.run_steps(1);
    }
    assert_eq!(to_uv(&harness).translation, Vec2::new(-0.5, 0.0));
    harness.key_press(Key::Escape);
    harness.run_steps(1);
    assert_eq!(to_uv(&harness), start);
    button(&mut harness, inside, false, Modifiers::NONE);
    assert_eq!(to_uv(&harness), start);
}

#[test]
fn a_click_on_another_shape_selects_it() {
    let mut harness = window(&[Affine2::IDENTITY]);
    let beside = screen()
        .project(Vec3::new(6.0, 0.0, 0.0))
        .expect("it is before the camera");
    go(&mut harness, beside);
    button(&mut harness, beside, true, Modifiers::NONE);
    button(&mut harness, beside, false, Modifiers::NONE);
    assert_eq!(
        harness.state().commands,
        [Command::from(SelectionCommand::Select(
            vec![entity(2)],
            Extend::Replace
        ))]
    );
}

#[test]
fn textures_that_are_passed_are_not_taken_along() {
    let [start, other] =
        [4.0, 5.0].map(|scale| Affine2::from_scale_angle_translation(Vec2::new(scale, 2.0), 0.0, Vec2::ZERO));
    let passed = Affine2 {
        translation: Vec2::new(-0.1, 0.0),
        ..start
    };
    let mut harness = window(&[start, passed, other]);
    // In steps of a tenth the first comes to where the second is, and goes on.
    let [from, to] = [Vec2::new(0.6, 0.7), Vec2::new(0.65, 0.7)];
    drag(&mut harness, seen(from), seen(to), Modifiers::COMMAND);
    let groups = &harness.state().target.as_ref().expect("a target").groups;
    assert_eq!([groups[1].to_uv, groups[2].to_uv], [passed, other]);
    assert!(groups[0].to_uv.translation.abs_diff_eq(Vec2::new(-0.2, 0.0), 1e-4));
}

/// The whole viewport with the tool, on a shape that is locked or not.
fn whole_viewport(is_locked: bool) -> Harness<'static, Vec<Command>> {
    let content = ViewportContent {
        packed: packed(),
        locked: is_locked.then(|| entity(1)).into_iter().collect(),
        ..ViewportContent::default()
    };
    let target = TextureTarget {
        entity: entity(1),
        groups: vec![group(Affine2::from_scale(Vec2::new(4.0, 2.0)))],
        upright: Affine2::IDENTITY,
    };
    let mut state = ViewportState::default();
    let mut harness = Harness::builder().with_size(SIZE).build_ui_state(
        move |ui, commands: &mut Vec<Command>| {
            let presses = presses(ui);
            let screen = screen();
            let pose = Affine3A::from_translation(Vec3::new(0.0, 0.0, -10.0));
            let empty = content.model([800, 600], pose, screen.camera, &presses);
            let model = ViewportModel {
                textures: Some(&target),
                keys: ActionContext {
                    tool: Tool::PlaceTexture,
                    ..empty.keys
                },
                ..empty
            };
            viewport(ui, &model, &mut state, commands);
        },
        Vec::new(),
    );
    harness.run_steps(3);
    harness
}

fn shows(harness: &Harness<'static, Vec<Command>>, words: &str) -> bool {
    let shapes = &harness.output().shapes;
    shapes
        .iter()
        .any(|shape| matches!(&shape.shape, egui::Shape::Text(text) if text.galley.text().contains(words)))
}

#[test]
fn textures_of_locked_shapes_stay() {
    let mut free = whole_viewport(false);
    assert!(!shows(&free, "locked"));
    free.get_by_label("Reset").click();
    free.run_steps(2);
    let placed = Command::from(TextureEdit::PlaceTextures {
        owner: entity(1),
        before: Affine2::from_scale(Vec2::new(4.0, 2.0)),
        after: Affine2::IDENTITY,
    });
    assert!(free.state().contains(&placed), "{:?}", free.state());
    let locked = whole_viewport(true);
    assert!(locked.query_by_label("Reset").is_none());
    assert!(shows(&locked, "locked"));
}
