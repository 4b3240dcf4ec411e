//! Drives the tools that block out a building: drags and clicks in the picture come out as the things that were drawn,
//! pushed and cut.

use std::sync::Arc;

use bevy::math::{Affine3A, Mat3, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{self, Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::accel::{Blas, Instance, Primitive, SplitMethod, Tlas};
use sunroom::app::editor::camera::screen::Screen;
use sunroom::app::editor::command::blocking::block::{Block, corners};
use sunroom::app::editor::command::blocking::{BlockKind, OpeningKind, Reshaping};
use sunroom::app::editor::command::tool::Tool;
use sunroom::app::editor::command::{Command, EditCommand, SceneEdit, ToolCommand, ViewCommand};
use sunroom::app::editor::commands::apply;
use sunroom::app::editor::input::actions::ActionContext;
use sunroom::app::editor::viewport::axes_widget;
use sunroom::app::editor::viewport::blocking::hand::BlockTarget;
use sunroom::app::editor::viewport::model::ViewportModel;
use sunroom::app::editor::viewport::state::ViewportState;
use sunroom::app::editor::viewport::viewport;
use sunroom::engine::PackedScene;
use sunroom::geometry::primitives::unit_cube;
use sunroom::render::camera::Camera;
use sunroom::render::scene::RenderScene;
use sunroom::scene::{Opening, Shape, ShapeKind, Solid};

use crate::numbers;
use crate::support::{ViewportContent, presses};

struct Window {
    tool: Tool,
    commands: Vec<Command>,
    state: ViewportState,
    camera: Camera,
    /// Whether the shape under the pointer has been looked up.
    is_known: bool,
}

const SIZE: egui::Vec2 = vec2(800.0, 600.0);
const STEP: f32 = 0.5;

fn cube() -> Entity {
    Entity::from_raw_u32(1).expect("a small index is valid")
}

/// From above and before the origin.
fn pose() -> Affine3A {
    let from = Vec3::new(0.0, 6.0, -10.0);
    let forward = (-from).normalize();
    let left = Vec3::Y.cross(forward).normalize();
    Affine3A::from_mat3_translation(Mat3::from_cols(left, forward.cross(left), forward), from)
}

/// A box of 4 x 2 x 0.4 at the origin, if there is one.
fn box_pose() -> Affine3A {
    Affine3A::from_translation(Vec3::Y) * Affine3A::from_scale(Vec3::new(2.0, 1.0, 0.2))
}

fn packed(pose: Option<Affine3A>) -> PackedScene {
    let blas = Arc::new(Blas::build(Arc::new(unit_cube()), SplitMethod::Sah));
    let instance = |pose| Instance::new(Primitive::Mesh(blas), pose).expect("a good pose");
    let instances = pose.map(instance).into_iter().collect();
    PackedScene {
        scene: Some(RenderScene {
            media: Arc::default(),
            geometry: Arc::new(Tlas::build(instances, SplitMethod::Sah)),
            surfaces: Arc::default(),
            materials: Arc::default(),
            textures: Arc::default(),
            lights: Arc::default(),
            reach: Default::default(),
        }),
        entity_of_instance: pose.map(|_| cube()).into_iter().collect(),
        ..PackedScene::default()
    }
}

fn window(tool: Tool, has_box: bool) -> Harness<'static, Window> {
    window_on(tool, has_box.then(box_pose))
}

/// A window on a cube of this pose, if there is one.
fn window_on(tool: Tool, box_pose: Option<Affine3A>) -> Harness<'static, Window> {
    let window = Window {
        tool,
        commands: Vec::new(),
        state: ViewportState::default(),
        camera: Camera::new(pose(), 60.0, 4.0 / 3.0, 0.01, 100.0, None),
        is_known: true,
    };
    let content = ViewportContent {
        packed: packed(box_pose),
        ..ViewportContent::default()
    };
    let target = |pose| BlockTarget {
        entity: cube(),
        shape: Shape {
            kind: ShapeKind::Cube,
            ..Shape::default()
        },
        pose,
    };
    let near: Vec<BlockTarget> = box_pose.map(target).into_iter().collect();
    let mut harness = Harness::builder().with_size(SIZE).build_ui_state(
        move |ui, window: &mut Window| {
            let presses = presses(ui);
            let empty = content.model([800, 600], pose(), window.camera, &presses);
            let model = ViewportModel {
                blocks: if window.is_known { &near } else { &[] },
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

fn drag(harness: &mut Harness<Window>, from: Vec3, to: Vec3) {
    go(harness, from);
    press(harness, from, true);
    for step in 1..=4 {
        go(harness, from.lerp(to, step as f32 / 4.0));
    }
    press(harness, to, false);
    harness.run_steps(2);
}

fn click(harness: &mut Harness<Window>, world: Vec3) {
    go(harness, world);
    press(harness, world, true);
    press(harness, world, false);
    harness.run_steps(3);
}

fn keys(harness: &mut Harness<Window>, keys: &[Key]) {
    for &key in keys {
        harness.key_press(key);
        harness.run_steps(1);
    }
}

fn built(harness: &Harness<Window>) -> Vec<Block> {
    let block = |command: &Command| match command {
        Command::Edit(EditCommand::Scene(SceneEdit::Build(block))) => Some((**block).clone()),
        _ => None,
    };
    harness.state().commands.iter().filter_map(block).collect()
}

fn reshaped(harness: &Harness<Window>, why: Reshaping) -> Vec<(ShapeKind, Affine3A)> {
    let change = |command: &Command| match command {
        Command::Edit(EditCommand::Scene(SceneEdit::Reshape(entity, shape, pose, reshaping)))
            if *reshaping == why && *entity == cube() =>
        {
            Some((shape.kind.clone(), *pose))
        }
        _ => None,
    };
    harness.state().commands.iter().filter_map(change).collect()
}

fn extent((kind, pose): &(ShapeKind, Affine3A)) -> [Vec3; 2] {
    let corners = corners(kind, pose).expect("a box");
    let low = corners.into_iter().reduce(Vec3::min).expect("corners");
    let high = corners.into_iter().reduce(Vec3::max).expect("corners");
    [low, high]
}

#[test]
fn a_box_is_dragged_on_the_ground_and_raised_to_a_click() {
    let mut harness = window(Tool::Draw(BlockKind::Box), false);
    // Both are a little off points of the grid.
    drag(&mut harness, Vec3::new(-1.1, 0.0, 0.4), Vec3::new(1.9, 0.0, 2.1));
    assert_eq!(built(&harness), [], "the height is still to come");
    click(&mut harness, Vec3::new(2.0, 1.6, 2.0));
    let [block] = &built(&harness)[..] else {
        panic!("{:?}", harness.state().commands)
    };
    let shape = block.shape().expect("a box");
    let [low, high] = extent(&shape);
    assert!(low.abs_diff_eq(Vec3::new(-1.0, 0.0, 0.5), 1e-5), "{low}");
    assert!(high.abs_diff_eq(Vec3::new(2.0, 1.5, 2.0), 1e-5), "{high}");
    assert!(
        harness
            .state()
            .commands
            .iter()
            .all(|command| matches!(command, Command::Edit(EditCommand::Scene(SceneEdit::Build(_))))),
        "nothing else happens: {:?}",
        harness.state().commands
    );
}

#[test]
fn a_box_stands_on_the_surface_under_the_pointer() {
    let mut harness = window(Tool::Draw(BlockKind::Box), true);
    // The upper side of the box is at y = 2 and 0.4 deep.
    drag(&mut harness, Vec3::new(-1.0, 2.0, 0.0), Vec3::new(1.0, 2.0, 1.0));
    keys(&mut harness, &[Key::Num1, Key::Enter]);
    let [block] = &built(&harness)[..] else {
        panic!("{:?}", harness.state().commands)
    };
    let [low, high] = extent(&block.shape().expect("a box"));
    assert!(low.abs_diff_eq(Vec3::new(-1.0, 2.0, 0.0), 1e-5), "{low}");
    assert!(high.abs_diff_eq(Vec3::new(1.0, 3.0, 1.0), 1e-5), "{high}");
}

#[test]
fn a_box_that_begins_a_little_above_the_foot_of_a_wall_stands_on_the_floor() {
    // The front of the box is at z = -0.2; one point of the picture is about two hundredths there.
    let begin = |height: f32| Vec3::new(-1.0, height, -0.2);
    for height in [0.12, 0.18] {
        let mut harness = window(Tool::Draw(BlockKind::Box), true);
        drag(&mut harness, begin(height), Vec3::new(1.0, 0.0, -2.0));
        keys(&mut harness, &[Key::Num1, Key::Enter]);
        let [block] = &built(&harness)[..] else {
            panic!("{height}: {:?}", harness.state().commands)
        };
        let [low, high] = extent(&block.shape().expect("a box"));
        assert!(low.abs_diff_eq(Vec3::new(-1.0, 0.0, -2.0), 1e-5), "{height}: {low}");
        assert!(high.abs_diff_eq(Vec3::new(1.0, 1.0, 0.0), 0.21), "{height}: {high}");
    }
    // Higher up, and with Control, it begins on the wall.
    let mut harness = window(Tool::Draw(BlockKind::Box), true);
    drag(&mut harness, begin(0.9), Vec3::new(1.0, 1.6, -0.2));
    keys(&mut harness, &[Key::Num1, Key::Enter]);
    let walls = built(&harness).first().map(|block| block.plane.normal);
    assert_eq!(walls, Some(Vec3::NEG_Z));
    let mut harness = window(Tool::Draw(BlockKind::Box), true);
    harness
        .input_mut()
        .events
        .push(egui::Event::ModifiersChanged(Modifiers::COMMAND));
    harness.run_steps(1);
    drag(&mut harness, begin(0.15), Vec3::new(1.0, 1.6, -0.2));
    keys(&mut harness, &[Key::Num1, Key::Enter]);
    let walls = built(&harness).first().map(|block| block.plane.normal);
    assert_eq!(walls, Some(Vec3::NEG_Z));
}

#[test]
fn a_wall_is_drawn_by_two_clicks_and_typed_numbers() {
    let mut harness = window(Tool::Draw(BlockKind::Wall), false);
    click(&mut harness, Vec3::new(-2.0, 0.0, 1.0));
    go(&mut harness, Vec3::new(0.5, 0.0, 1.0));
    keys(&mut harness, &[Key::Num3, Key::Enter]);
    keys(&mut harness, &[Key::Num2, Key::Period, Key::Num7, Key::Enter]);
    let [block] = &built(&harness)[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert!(block.from.abs_diff_eq(Vec3::new(-2.0, 0.0, 1.0), 1e-5), "{block:?}");
    assert!(block.to.abs_diff_eq(Vec3::new(1.0, 0.0, 1.0), 1e-5), "{block:?}");
    assert_eq!(block.height, 2.7);
    // The next wall is as high unless one says otherwise.
    drag(&mut harness, Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 3.0));
    keys(&mut harness, &[Key::Enter]);
    assert_eq!(built(&harness).last().map(|block| block.height), Some(2.7));
}

#[test]
fn a_floor_is_there_when_the_button_is_let_go() {
    let mut harness = window(Tool::Draw(BlockKind::Floor), false);
    drag(&mut harness, Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 2.0));
    let [block] = &built(&harness)[..] else {
        panic!("{:?}", harness.state().commands)
    };
    let [low, high] = extent(&block.shape().expect("a floor"));
    assert!(
        high.abs_diff_eq(Vec3::new(1.0, 0.0, 2.0), 1e-5) && low.y < 0.0,
        "{low} {high}"
    );
}

#[test]
fn a_quick_drag_within_one_frame_begins_where_it_was_pressed() {
    let mut harness = window(Tool::Draw(BlockKind::Floor), false);
    let (from, to) = (Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 2.0));
    go(&mut harness, from);
    let [begin, end] = [from, to].map(|place| at(&harness, place));
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    let events = &mut harness.input_mut().events;
    events.extend([button(begin, true), egui::Event::PointerMoved(end), button(end, false)]);
    harness.run_steps(1);
    let [block] = &built(&harness)[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert!(
        block.from.abs_diff_eq(from, 1e-5) && block.to.abs_diff_eq(to, 1e-5),
        "{block:?}"
    );
}

#[test]
fn what_is_drawn_near_a_corner_begins_and_ends_at_it() {
    let (low, high) = (Vec3::new(-2.0, 0.0, -0.2), Vec3::new(2.0, 0.0, -0.2));
    let off = Vec3::new(0.07, 0.0, -0.09);
    // Neither corner is on the grid of 0.5.
    for kind in [BlockKind::Wall, BlockKind::Floor] {
        let mut harness = window(Tool::Draw(kind), true);
        let end = if kind == BlockKind::Wall {
            high
        } else {
            Vec3::new(3.0, 0.0, -2.0)
        };
        drag(&mut harness, low + off, end + off);
        keys(&mut harness, &[Key::Enter]);
        let [block] = &built(&harness)[..] else {
            panic!("{:?}", harness.state().commands)
        };
        assert!(
            block.from.abs_diff_eq(low, 1e-5) && block.to.abs_diff_eq(end, 1e-5),
            "{block:?}"
        );
    }
    // Control frees from corners.
    let mut harness = window(Tool::Draw(BlockKind::Wall), true);
    let control = egui::Event::ModifiersChanged(Modifiers::COMMAND);
    harness.input_mut().events.push(control);
    harness.run_steps(1);
    drag(&mut harness, low + off, high + off);
    keys(&mut harness, &[Key::Enter]);
    let first = built(&harness).first().map(|block| block.from);
    assert!(first.is_none_or(|from| from.distance(low) > 0.05), "{first:?}");
}

/// The length of the wall in the file is that of the floor, to the digit.
#[test]
fn a_wall_from_corner_to_corner_has_the_size_that_was_typed() {
    for length in ["9.2", "7.3", "0.7"] {
        let half = 0.5 * length.parse::<f32>().expect("a number");
        let mut scene = numbers::Window::on("  <shape type=\"cube\" id=\"floor\"/>");
        scene.say(&format!("set floor scale {half},0.05,2.3"));
        scene.say("move floor 0,-0.05,0");
        let (_, pose) = scene.shape("floor");
        let mut harness = window_on(Tool::Draw(BlockKind::Wall), Some(pose));
        let corner = |side: f32| Vec3::new(side * half, 0.0, -2.3);
        let off = Vec3::new(0.0, 0.0, 0.06);
        drag(&mut harness, corner(1.0) + off, corner(-1.0) + off);
        keys(&mut harness, &[Key::Enter]);
        let [block] = &built(&harness)[..] else {
            panic!("{length}: {:?}", harness.state().commands)
        };
        apply(&mut scene.world, SceneEdit::Build(Box::new(block.clone()))).expect("it can be built");
        let saved = scene.saved();
        let told = format!("<float name=\"length\" value=\"{length}\"/>");
        assert!(saved.contains(&told), "{length}: {saved}");
    }
}

/// Frames take long while a picture is large: the button may go up before the shapes there have been looked up.
#[test]
fn the_end_of_a_drag_waits_for_the_corner_that_is_there() {
    let mut harness = window(Tool::Draw(BlockKind::Wall), true);
    let (low, high) = (Vec3::new(-2.0, 0.0, -0.2), Vec3::new(2.0, 0.0, -0.2));
    let off = Vec3::new(0.07, 0.0, -0.09);
    go(&mut harness, low + off);
    press(&mut harness, low + off, true);
    harness.state_mut().is_known = false;
    go(&mut harness, high + off);
    let pos = at(&harness, high + off);
    harness.event(egui::Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed: false,
        modifiers: Modifiers::NONE,
    });
    harness.step();
    harness.state_mut().is_known = true;
    keys(&mut harness, &[Key::Enter]);
    harness.run_steps(2);
    let [block] = &built(&harness)[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert!(
        block.from.abs_diff_eq(low, 1e-5) && block.to.abs_diff_eq(high, 1e-5),
        "{block:?}"
    );
}

#[test]
fn walls_stand_at_the_foot_of_the_box_at_whose_side_they_begin() {
    let mut harness = window(Tool::Draw(BlockKind::Wall), true);
    drag(&mut harness, Vec3::new(0.5, 1.0, -0.2), Vec3::new(0.5, 0.0, -3.0));
    keys(&mut harness, &[Key::Enter]);
    let [block] = &built(&harness)[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!((block.plane.normal, block.from.y, block.to.y), (Vec3::Y, 0.0, 0.0));
}

#[test]
fn escape_gives_up_what_is_drawn_and_then_the_tool() {
    let mut harness = window(Tool::Draw(BlockKind::Box), false);
    drag(&mut harness, Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 2.0));
    keys(&mut harness, &[Key::Escape]);
    assert_eq!(harness.state().commands, []);
    click(&mut harness, Vec3::new(3.0, 0.0, 3.0));
    keys(&mut harness, &[Key::Escape, Key::Escape]);
    assert_eq!(
        harness.state().commands,
        [Command::from(ToolCommand::SetTool(Tool::Select))]
    );
}

#[test]
fn a_face_follows_the_pointer_along_its_normal() {
    let mut harness = window(Tool::Push, true);
    // The side towards the viewer, at z = -0.2, and the top at y = 2.
    drag(&mut harness, Vec3::new(0.5, 2.0, 0.0), Vec3::new(0.5, 3.1, 0.0));
    let pushes = reshaped(&harness, Reshaping::Push);
    let [low, high] = extent(pushes.last().expect("it was pushed"));
    assert!(low.abs_diff_eq(Vec3::new(-2.0, 0.0, -0.2), 1e-5), "{low}");
    assert!(high.abs_diff_eq(Vec3::new(2.0, 3.0, 0.2), 1e-5), "{high}");
    assert!(pushes.len() > 1, "it follows the pointer");

    let mut harness = window(Tool::Push, true);
    go(&mut harness, Vec3::new(0.5, 1.0, -0.2));
    press(&mut harness, Vec3::new(0.5, 1.0, -0.2), true);
    go(&mut harness, Vec3::new(0.5, 1.0, -1.3));
    keys(&mut harness, &[Key::Escape]);
    press(&mut harness, Vec3::new(0.5, 1.0, -1.3), false);
    let pushes = reshaped(&harness, Reshaping::Push);
    assert_eq!(pushes.last(), Some(&(ShapeKind::Cube, box_pose())), "it is put back");
}

#[test]
fn a_face_that_was_clicked_goes_as_far_as_is_typed() {
    let mut harness = window(Tool::Push, true);
    click(&mut harness, Vec3::new(0.5, 2.0, 0.0));
    go(&mut harness, Vec3::new(0.5, 3.1, 0.0));
    assert_eq!(reshaped(&harness, Reshaping::Push), [], "only a number moves it");
    keys(&mut harness, &[Key::Minus, Key::Period, Key::Num3, Key::Enter]);
    let pushes = reshaped(&harness, Reshaping::Push);
    let [_, high] = extent(pushes.last().expect("it was pushed"));
    assert!((high.y - 1.7).abs() < 1e-5, "{high}");
    // It is let go: numbers do nothing any more.
    keys(&mut harness, &[Key::Num5]);
    assert_eq!(reshaped(&harness, Reshaping::Push).len(), pushes.len());
}

#[test]
fn a_click_on_a_box_cuts_a_door_and_it_becomes_a_wall() {
    let mut harness = window(Tool::Cut(OpeningKind::Window), true);
    click(&mut harness, Vec3::new(0.6, 1.0, -0.2));
    let cuts = reshaped(&harness, Reshaping::Cut);
    let [(ShapeKind::Solid(Solid::Wall { length, openings, .. }), pose)] = &cuts[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert!((length - 4.0).abs() < 1e-5);
    let [Opening { from, sill, .. }] = openings[..] else {
        panic!("{openings:?}")
    };
    // The wall is 2 high: its windows are smaller than those of rooms, and half of one is below the pointer.
    assert!(
        (from / STEP).fract().abs() < 1e-5 && (sill / STEP).fract().abs() < 1e-5,
        "{from} {sill}"
    );
    let middle = pose.transform_point3(Vec3::new(
        from + 0.5 * openings[0].width,
        0.0,
        sill + 0.5 * openings[0].height,
    ));
    assert!(
        (middle - Vec3::new(0.6, 1.0, 0.0)).abs().max_element() <= 0.5 * STEP + 1e-4,
        "{middle}"
    );
}

#[test]
fn a_drag_over_a_box_draws_an_opening() {
    let mut harness = window(Tool::Cut(OpeningKind::Window), true);
    drag(&mut harness, Vec3::new(1.1, 0.1, -0.2), Vec3::new(-0.6, 1.4, -0.2));
    let drawn = |cuts: &[(ShapeKind, Affine3A)]| match cuts {
        [(ShapeKind::Solid(Solid::Wall { openings, .. }), pose)] => {
            let Opening {
                from,
                sill,
                width,
                height,
            } = openings[0];
            let corner = |x: f32, z: f32| pose.transform_point3(Vec3::new(x, 0.0, z));
            [corner(from, sill), corner(from + width, sill + height)]
        }
        other => panic!("{other:?}"),
    };
    let [low, high] = drawn(&reshaped(&harness, Reshaping::Cut));
    assert!(low.abs_diff_eq(Vec3::new(-0.5, 0.0, 0.0), 1e-5), "{low}");
    assert!(high.abs_diff_eq(Vec3::new(1.0, 1.5, 0.0), 1e-5), "{high}");

    // Its size is typed while the button is held.
    let mut harness = window(Tool::Cut(OpeningKind::Window), true);
    let from = Vec3::new(-1.0, 0.5, -0.2);
    go(&mut harness, from);
    press(&mut harness, from, true);
    go(&mut harness, Vec3::new(0.0, 0.9, -0.2));
    keys(&mut harness, &[Key::Num2, Key::Comma, Key::Num1, Key::Enter]);
    press(&mut harness, Vec3::new(0.0, 0.9, -0.2), false);
    let [low, high] = drawn(&reshaped(&harness, Reshaping::Cut));
    assert!(low.abs_diff_eq(Vec3::new(-1.0, 0.5, 0.0), 1e-5), "{low}");
    assert!(high.abs_diff_eq(Vec3::new(1.0, 1.5, 0.0), 1e-5), "{high}");

    let mut harness = window(Tool::Cut(OpeningKind::Window), true);
    go(&mut harness, from);
    press(&mut harness, from, true);
    go(&mut harness, Vec3::new(0.0, 0.9, -0.2));
    keys(&mut harness, &[Key::Escape]);
    press(&mut harness, Vec3::new(0.0, 0.9, -0.2), false);
    assert_eq!(harness.state().commands, []);
}

#[test]
fn other_buttons_and_clicks_beside_shapes_are_as_without_the_tool() {
    let mut harness = window(Tool::Push, true);
    click(&mut harness, Vec3::new(3.5, 0.0, 0.0));
    assert_eq!(harness.state().commands, []);
    // A left drag beside the box looks around.
    drag(&mut harness, Vec3::new(3.5, 0.0, 0.0), Vec3::new(3.0, 0.5, 0.0));
    assert!(
        harness
            .state()
            .commands
            .iter()
            .any(|command| matches!(command, Command::View(ViewCommand::MoveView(_))))
    );
}

#[test]
fn one_number_is_for_both_sides_of_a_base() {
    let mut harness = window(Tool::Draw(BlockKind::Box), false);
    click(&mut harness, Vec3::new(-1.0, 0.0, 2.0));
    go(&mut harness, Vec3::new(0.5, 0.0, 1.0));
    keys(&mut harness, &[Key::Num2, Key::Enter]);
    keys(&mut harness, &[Key::Num1, Key::Enter]);
    let [block] = &built(&harness)[..] else {
        panic!("{:?}", harness.state().commands)
    };
    let [low, high] = extent(&block.shape().expect("a box"));
    assert!(low.abs_diff_eq(Vec3::new(-1.0, 0.0, 0.0), 1e-5), "{low}");
    assert!(high.abs_diff_eq(Vec3::new(1.0, 1.0, 2.0), 1e-5), "{high}");
}

#[test]
fn what_is_pressed_over_the_picture_draws_nothing_under_it() {
    let panel = egui::Rect::from_min_size(Pos2::ZERO, SIZE);
    for place in [None, Some(axes_widget::place(panel).center())] {
        let mut harness = window(Tool::Draw(BlockKind::Floor), false);
        let place = place.unwrap_or_else(|| harness.get_by_label("Rotate").rect().center());
        let button = |pos, pressed| egui::Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        harness.event(egui::Event::PointerMoved(place));
        harness.run_steps(2);
        harness.event(button(place, true));
        harness.run_steps(2);
        go(&mut harness, Vec3::new(0.5, 0.0, 1.0));
        let to = at(&harness, Vec3::new(0.5, 0.0, 1.0));
        harness.event(button(to, false));
        harness.run_steps(2);
        assert_eq!(built(&harness), []);
    }
}

#[test]
fn the_view_does_not_turn_while_a_pressed_shape_is_looked_up() {
    let mut harness = window(Tool::Push, true);
    harness.state_mut().is_known = false;
    drag(&mut harness, Vec3::new(0.5, 2.0, 0.0), Vec3::new(0.5, 3.1, 0.0));
    assert_eq!(harness.state().commands, []);
}
