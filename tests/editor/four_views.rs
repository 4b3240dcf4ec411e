//! Drives the views from above, the front and the right beside the main one: each has mouse and tools with its own
//! camera.

use std::sync::Arc;

use bevy::math::{Affine3A, Vec3, Vec3A};
use bevy::prelude::Entity;
use bevy_egui::egui::{self, Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::accel::{Blas, Instance, Primitive, SplitMethod, Tlas};
use sunroom::app::editor::camera::navigation::Navigation;
use sunroom::app::editor::camera::screen::Screen;
use sunroom::app::editor::command::blocking::BlockKind;
use sunroom::app::editor::command::selection::{Extend, Selection};
use sunroom::app::editor::command::side_views::{SIDES, SidePlace, SideViews};
use sunroom::app::editor::command::tool::Tool;
use sunroom::app::editor::command::{
    ArrangeEdit, Command, EditCommand, SceneEdit, SelectionCommand, ToolCommand, ValueEdit, ViewCommand,
};
use sunroom::app::editor::input::actions::ActionContext;
use sunroom::app::editor::model::freedom::Freedom;
use sunroom::app::editor::picture::outline::SelectionOutline;
use sunroom::app::editor::picture::side_pictures::side_view;
use sunroom::app::editor::viewport::gizmo::Target;
use sunroom::app::editor::viewport::gizmo::interaction::GizmoModel;
use sunroom::app::editor::viewport::model::ViewportModel;
use sunroom::app::editor::viewport::side_model::SideModel;
use sunroom::app::editor::viewport::state::ViewportState;
use sunroom::app::editor::viewport::{side_views, viewport};
use sunroom::engine::PackedScene;
use sunroom::geometry::primitives::unit_cube;
use sunroom::math::Aabb;
use sunroom::render::camera::Camera;
use sunroom::render::scene::RenderScene;

use crate::support::{ViewportContent, presses};

pub const TOP: usize = 0;
pub const FRONT: usize = 1;
pub const RIGHT: usize = 2;

pub struct Window {
    pub commands: Vec<Command>,
    pub state: ViewportState,
    pub tool: Tool,
    pub views: SideViews,
    pub target: Target,
    /// Whether the cube is selected.
    pub is_selected: bool,
    /// Whether the scene and the views have been packed.
    pub is_packed: bool,
}

const SIZE: egui::Vec2 = vec2(1000.0, 800.0);

fn cube() -> Entity {
    Entity::from_raw_u32(1).expect("a small index is valid")
}

/// The cube that is seen: of two units at the origin.
fn scene() -> PackedScene {
    let blas = Arc::new(Blas::build(Arc::new(unit_cube()), SplitMethod::Sah));
    let instance = Instance::new(Primitive::Mesh(blas), Affine3A::IDENTITY).expect("a good pose");
    PackedScene {
        scene: Some(RenderScene {
            media: Arc::default(),
            geometry: Arc::new(Tlas::build(vec![instance], SplitMethod::Sah)),
            surfaces: Arc::default(),
            materials: Arc::default(),
            textures: Arc::default(),
            lights: Arc::default(),
            reach: Default::default(),
        }),
        entity_of_instance: [cube()].into(),
        ..PackedScene::default()
    }
}

fn bounds() -> Aabb {
    Aabb {
        min: Vec3::NEG_ONE,
        max: Vec3::ONE,
    }
}

fn pose_of_main() -> Affine3A {
    Affine3A::from_translation(Vec3::new(0.0, 0.0, -10.0))
}

/// The places before anything moves: ten units high around the origin.
pub fn places() -> [Option<SidePlace>; 3] {
    [Some(SidePlace {
        center: [0.0; 3],
        height: 10.0,
    }); 3]
}

/// The scene as the main view sees it.
fn packed_for_main(is_packed: bool) -> PackedScene {
    match is_packed {
        true => scene(),
        false => PackedScene::default(),
    }
}

/// The scene as the side views see it, as the window packs it after each frame.
fn packed(window: &Window) -> Vec<(PackedScene, Affine3A)> {
    let sides = SIDES.into_iter().zip(window.views.places).enumerate();
    let pack = |(side, ((view, _), place)): (usize, (_, Option<SidePlace>))| {
        let (place, mut packed) = (place.expect("a place"), scene());
        let size = window
            .state
            .sides
            .map_or(bevy::math::UVec2::ONE, |sizes| sizes[side].size);
        let aspect = size.x as f32 / size.y as f32;
        let pose = place.pose(view, aspect, &Navigation::default(), &bounds());
        let camera = SidePlace::camera(&pose, place.center.into(), aspect);
        packed.view = Some(side_view(camera, size, false, Default::default()));
        let packed = if window.is_packed {
            packed
        } else {
            PackedScene::default()
        };
        (packed, pose)
    };
    sides.map(pack).collect()
}

pub fn window(tool: Tool) -> Harness<'static, Window> {
    let window = Window {
        commands: Vec::new(),
        state: ViewportState::default(),
        tool,
        views: SideViews {
            closed: [false; 3],
            shown: true,
            clay: false,
            places: places(),
        },
        target: Target {
            entity: cube(),
            to_world: Affine3A::IDENTITY,
            freedom: Freedom::Affine,
            bounds: Some(bounds()),
        },
        is_selected: true,
        is_packed: true,
    };
    let camera = Camera::new(pose_of_main(), 60.0, 1.25, 0.01, 100.0, None);
    let outline = SelectionOutline::default();
    let mut harness = Harness::builder().with_size(SIZE).build_ui_state(
        move |ui, window: &mut Window| {
            let content = ViewportContent {
                packed: packed_for_main(window.is_packed),
                selection: Selection::of(window.is_selected.then(cube)),
                ..ViewportContent::default()
            };
            let presses = presses(ui);
            let scenes = packed(window);
            let sides = scenes.iter().map(|(packed, pose)| SideModel {
                packed,
                pose: *pose,
                picture: None,
                outline: &outline,
            });
            let sides: Vec<SideModel> = sides.collect();
            let empty = content.model([500, 400], pose_of_main(), camera, &presses);
            let targets: &[Target] = if window.is_selected { &[window.target] } else { &[] };
            let model = ViewportModel {
                sides: if window.views.shown { &sides } else { &[] },
                gizmo: GizmoModel { targets, ..empty.gizmo },
                extent: window.target.bounds,
                keys: ActionContext {
                    tool: window.tool,
                    side_views: window.views,
                    ..empty.keys
                },
                ..empty
            };
            let mut commands = Vec::new();
            let mut whole = ui.new_child(egui::UiBuilder::new().max_rect(egui::Rect::from_min_size(Pos2::ZERO, SIZE)));
            whole.set_clip_rect(whole.max_rect());
            viewport(&mut whole, &model, &mut window.state, &mut commands);
            for command in &commands {
                match command {
                    Command::View(ViewCommand::ShowSideViews(shown)) => window.views.shown = *shown,
                    Command::View(ViewCommand::CloseSideView(side, closed)) => window.views.closed[*side] = *closed,
                    Command::View(ViewCommand::PlaceSideView(side, place)) => {
                        window.views.places[*side] = Some(*place);
                    }
                    Command::Tool(ToolCommand::SetTool(tool)) => window.tool = *tool,
                    Command::Edit(EditCommand::Value(ValueEdit::Transform(poses))) => {
                        window.target.to_world = poses[0].1;
                    }
                    Command::Edit(EditCommand::Arrange(ArrangeEdit::NudgeAlong(direction))) => {
                        window.target.to_world.translation += Vec3A::from(0.5 * direction.normalize());
                    }
                    _ => {}
                }
            }
            window.commands.extend(commands);
        },
        window,
    );
    harness.run_steps(4);
    harness
}

/// A side view at its place in the window.
fn screen(harness: &Harness<Window>, side: usize) -> Screen {
    let response = harness.ctx.read_response(side_views::id(side)).expect("it is shown");
    let (packed, _) = &packed(harness.state())[side];
    Screen {
        camera: packed.view.as_ref().expect("a view").camera,
        picture: response.rect,
    }
}

pub fn at(harness: &Harness<Window>, side: usize, world: Vec3) -> Pos2 {
    screen(harness, side).project(world).expect("in front")
}

pub fn go(harness: &mut Harness<Window>, to: Pos2) {
    harness.event(egui::Event::PointerMoved(to));
    harness.run_steps(2);
}

pub fn press(harness: &mut Harness<Window>, button: PointerButton, pos: Pos2, pressed: bool) {
    harness.event(egui::Event::PointerButton {
        pos,
        button,
        pressed,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(1);
}

fn drag(harness: &mut Harness<Window>, button: PointerButton, from: Pos2, to: Pos2) {
    go(harness, from);
    press(harness, button, from, true);
    for step in 1..=5 {
        go(harness, from + (to - from) * (step as f32 / 5.0));
    }
    press(harness, button, to, false);
    harness.run_steps(2);
}

fn click(harness: &mut Harness<Window>, pos: Pos2) {
    go(harness, pos);
    press(harness, PointerButton::Primary, pos, true);
    press(harness, PointerButton::Primary, pos, false);
    harness.run_steps(2);
}

#[test]
fn each_side_view_shows_outer_walls_or_sees_through_them() {
    let mut harness = window(Tool::Select);
    let front = at(&harness, 1, Vec3::ZERO);
    go(&mut harness, front);
    for closed in [true, false] {
        harness.key_press_modifiers(Modifiers::ALT, Key::W);
        harness.run_steps(2);
        assert_eq!(harness.state().views.closed, [false, closed, false]);
    }
    let asked = |command: &Command| matches!(command, Command::View(ViewCommand::SetSeeing(_)));
    assert!(!harness.state().commands.iter().any(asked), "the main view stays");
}

#[test]
fn a_key_and_a_button_show_one_view_or_four() {
    let mut harness = window(Tool::Select);
    harness.key_press(Key::V);
    harness.run_steps(2);
    assert!(!harness.state().views.shown && harness.state().state.sides.is_none());
    assert!(
        harness
            .ctx
            .read_response(side_views::id(TOP))
            .is_none_or(|it| !it.rect.is_positive())
    );
    harness.get_by_label("Four views").click();
    harness.run_steps(3);
    assert!(harness.state().views.shown);
    // They come back where they were.
    assert_eq!(harness.state().views.places, places());
    let rects = [TOP, FRONT, RIGHT].map(|side| screen(&harness, side).picture);
    let main = harness.state().state.room.expect("it is shown");
    assert!(
        rects.iter().all(|rect| rect.width() > 490.0 && rect.height() > 390.0),
        "{rects:?}"
    );
    assert!(main.x < 500 && main.y < 400, "{main}");
    assert!(!rects[TOP].intersects(rects[RIGHT]) && !rects[FRONT].intersects(rects[RIGHT]));
}

#[test]
fn handles_move_things_in_each_view() {
    // The axes that are across the view.
    for (side, axes) in [
        (TOP, [Vec3::X, Vec3::Z]),
        (FRONT, [Vec3::X, Vec3::Y]),
        (RIGHT, [Vec3::Z, Vec3::Y]),
    ] {
        for axis in axes {
            let mut harness = window(Tool::Select);
            // Half way to the tip of the arrow.
            let middle = at(&harness, side, Vec3::ZERO);
            let along = (at(&harness, side, axis) - middle).normalized();
            let from = middle + 40.0 * along;
            let to = from + (at(&harness, side, 2.0 * axis) - middle);
            drag(&mut harness, PointerButton::Primary, from, to);
            let moved = Vec3::from(harness.state().target.to_world.translation);
            assert!(
                moved.abs_diff_eq(2.0 * axis, 0.05),
                "view {side}: {moved}, not {}",
                2.0 * axis
            );
            let others = |command: &&Command| !matches!(command, Command::Edit(EditCommand::Value(_)));
            assert_eq!(harness.state().commands.iter().find(others), None);
        }
    }
}

#[test]
fn a_drag_stays_in_the_view_in_which_it_began() {
    let mut harness = window(Tool::Select);
    let middle = at(&harness, FRONT, Vec3::ZERO);
    let from = middle - vec2(0.0, 40.0);
    // The view above it belongs to the picture, whose camera would take the thing elsewhere.
    let to = from - vec2(0.0, 350.0);
    let units = screen(&harness, FRONT).camera.half_extent().y * 2.0 / screen(&harness, FRONT).picture.height();
    drag(&mut harness, PointerButton::Primary, from, to);
    let moved = Vec3::from(harness.state().target.to_world.translation);
    assert!(moved.abs_diff_eq(350.0 * units * Vec3::Y, 0.05), "{moved}");
}

#[test]
fn a_click_selects_what_is_seen_there() {
    for side in [TOP, FRONT, RIGHT] {
        let mut harness = window(Tool::Select);
        harness.state_mut().is_selected = false;
        let [on, beside] = [0.6, 3.0].map(|x| at(&harness, side, x * Vec3::ONE));
        for (pos, expected) in [(on, vec![cube()]), (beside, Vec::new())] {
            click(&mut harness, pos);
            let selected = Command::from(SelectionCommand::Select(expected, Extend::Replace));
            assert_eq!(harness.state().commands, [selected]);
            harness.state_mut().commands.clear();
        }
        go(&mut harness, on);
        assert_eq!(harness.state().state.pointer.hovered, Some(cube()));
    }
}

#[test]
fn every_drag_that_would_turn_the_picture_pans_a_side_view() {
    for button in [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle] {
        for side in [TOP, FRONT, RIGHT] {
            let mut harness = window(Tool::Select);
            let [from, to] = [3.0, 4.0].map(|x| at(&harness, side, x * Vec3::ONE));
            let taken = 3.0 * Vec3::ONE;
            drag(&mut harness, button, from, to);
            assert!(at(&harness, side, taken).distance(to) < 0.5, "view {side}, {button:?}");
            let views = harness.state().views;
            assert_eq!(views.places[side].map(|place| place.height), Some(10.0));
            let others = [TOP, FRONT, RIGHT].into_iter().filter(|other| *other != side);
            assert!(others.into_iter().all(|other| views.places[other] == places()[other]));
            let moves = |command: &Command| matches!(command, Command::View(ViewCommand::MoveView(_)));
            assert!(!harness.state().commands.iter().any(moves));
        }
    }
}

#[test]
fn the_wheel_zooms_towards_the_pointer() {
    let mut harness = window(Tool::Select);
    let seen = Vec3::new(0.0, 2.0, -3.0);
    let pointer = at(&harness, RIGHT, seen);
    go(&mut harness, pointer);
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: vec2(0.0, 3.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(2);
    let height = harness.state().views.places[RIGHT].map(|place| place.height);
    assert!(height.is_some_and(|height| height < 7.0), "{height:?}");
    assert!(at(&harness, RIGHT, seen).distance(pointer) < 0.5);
}

#[test]
fn a_box_gets_its_foot_in_one_view_and_its_height_in_another() {
    let mut harness = window(Tool::Draw(BlockKind::Box));
    harness.state_mut().is_selected = false;
    let corners = [Vec3::new(2.0, 0.0, 2.0), Vec3::new(4.0, 0.0, 3.0)].map(|corner| at(&harness, TOP, corner));
    drag(&mut harness, PointerButton::Primary, corners[0], corners[1]);
    for height in [1.0, 3.0] {
        let height = at(&harness, FRONT, height * Vec3::Y);
        go(&mut harness, height);
    }
    let height = at(&harness, FRONT, 3.0 * Vec3::Y);
    click(&mut harness, height);
    let built = harness.state().commands.iter().find_map(|command| match command {
        Command::Edit(EditCommand::Scene(SceneEdit::Build(block))) => Some(block.clone()),
        _ => None,
    });
    let block = built.unwrap_or_else(|| panic!("nothing is built: {:?}", harness.state().commands));
    assert!((block.height - 3.0).abs() < 1e-3, "{block:?}");
    let size = (block.to - block.from).abs();
    assert!(size.abs_diff_eq(Vec3::new(2.0, 0.0, 1.0), 1e-3), "{block:?}");
}

#[test]
fn the_wheel_zooms_while_the_right_button_pans() {
    let mut harness = window(Tool::Select);
    let pointer = at(&harness, RIGHT, 3.0 * Vec3::ONE);
    go(&mut harness, pointer);
    press(&mut harness, PointerButton::Secondary, pointer, true);
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: vec2(0.0, 3.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(2);
    let height = harness.state().views.places[RIGHT].map(|place| place.height);
    assert!(height.is_some_and(|height| height < 7.0), "{height:?}");
    let sets_speed = |command: &Command| matches!(command, Command::View(ViewCommand::SetSpeed(_)));
    assert!(!harness.state().commands.iter().any(sets_speed));
}

#[test]
fn a_window_without_a_packed_scene_rests() {
    for is_packed in [true, false] {
        let mut harness = window(Tool::Select);
        harness.state_mut().is_packed = is_packed;
        harness.run_steps(4);
        assert!(harness.try_run().is_ok(), "is packed: {is_packed}");
    }
}
