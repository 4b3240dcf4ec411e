//! Drives the picture without a window: what mouse and keys do there comes out as commands.

use bevy::math::{Affine3A, Vec2, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{self, Key, Modifiers, PointerButton, Pos2, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::camera::screen::Screen;
use sunroom::app::editor::command::arrange::Direction;
use sunroom::app::editor::command::axis_view::AxisView;
use sunroom::app::editor::command::gizmo_settings::{Axes, GizmoSettings, Mode};
use sunroom::app::editor::command::navigation_preset::NavigationPreset;
use sunroom::app::editor::command::selection::{Extend, Selection};
use sunroom::app::editor::command::tool::Tool;
use sunroom::app::editor::command::{
    ArrangeEdit, Command, DisplayCommand, EditCommand, RenderCommand, SelectionCommand, ToolCommand, ValueEdit,
    ViewCommand,
};
use sunroom::app::editor::input::actions::ActionContext;
use sunroom::app::editor::input::press::Press;
use sunroom::app::editor::model::freedom::Freedom;
use sunroom::app::editor::viewport::gizmo::Target;
use sunroom::app::editor::viewport::gizmo::interaction::GizmoModel;
use sunroom::app::editor::viewport::icons::{Icon, IconKind};
use sunroom::app::editor::viewport::model::ViewportModel;
use sunroom::app::editor::viewport::state::ViewportState;
use sunroom::app::editor::viewport::viewport;
use sunroom::engine::Outdated;
use sunroom::math::Aabb;
use sunroom::render::camera::Camera;

use crate::support::{ViewportContent, presses};

fn entity(index: u32) -> Entity {
    Entity::from_raw_u32(index).expect("a small index is valid")
}

pub struct Window {
    pub commands: Vec<Command>,
    pub tool: Tool,
    state: ViewportState,
    gizmo: GizmoSettings,
    target: Target,
    pub camera: Camera,
    preset: NavigationPreset,
    /// Whether the scene has no shapes.
    is_empty: bool,
    /// Whether the picture is paused and older than the scene.
    is_paused: bool,
    /// The proportions of the picture that would be rendered, where nothing is rendered yet.
    unrendered: Option<[u32; 2]>,
}

pub const SIZE: egui::Vec2 = vec2(800.0, 600.0);

/// From (0, 0, -10) along +z: +x is to the left.
pub fn pose() -> Affine3A {
    Affine3A::from_translation(Vec3::new(0.0, 0.0, -10.0))
}

pub fn screen(window: &Window) -> Screen {
    Screen {
        camera: window.camera,
        picture: egui::Rect::from_min_size(Pos2::ZERO, SIZE),
    }
}

/// A selected cube in the middle, and a lamp up to the right.
pub fn window() -> Harness<'static, Window> {
    let unit = Aabb {
        min: Vec3::NEG_ONE,
        max: Vec3::ONE,
    };
    let window = Window {
        commands: Vec::new(),
        tool: Tool::Select,
        state: ViewportState::default(),
        gizmo: GizmoSettings::default(),
        target: Target {
            entity: entity(1),
            to_world: Affine3A::IDENTITY,
            freedom: Freedom::Affine,
            bounds: Some(unit),
        },
        camera: Camera::new(pose(), 60.0, 4.0 / 3.0, 0.01, 100.0, None),
        preset: NavigationPreset::default(),
        is_empty: false,
        is_paused: false,
        unrendered: None,
    };
    let lamp = Icon {
        entity: entity(7),
        kind: IconKind::Bulb,
        pose: Affine3A::from_translation(lamp()),
        tint: None,
    };
    let content = ViewportContent {
        selection: Selection::of([entity(1)]),
        ..ViewportContent::default()
    };
    let mut harness = Harness::builder().with_size(SIZE).build_ui_state(
        move |ui, window: &mut Window| {
            let presses = presses(ui);
            let empty = content.model([800, 600], pose(), window.camera, &presses);
            let model = ViewportModel {
                icons: &[lamp],
                gizmo: GizmoModel {
                    settings: window.gizmo,
                    targets: &[window.target],
                    ..empty.gizmo
                },
                preset: window.preset,
                is_empty: window.is_empty,
                picture: empty.picture.filter(|_| window.unrendered.is_none()),
                proportions: window.unrendered.unwrap_or(empty.proportions),
                outdated: window.is_paused.then_some(Outdated::Scene),
                keys: ActionContext {
                    gizmo: window.gizmo,
                    tool: window.tool,
                    paused: window.is_paused,
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
                    Command::Tool(ToolCommand::SetGizmo(settings)) => window.gizmo = *settings,
                    Command::Tool(ToolCommand::SetTool(tool)) => window.tool = *tool,
                    Command::Edit(EditCommand::Value(ValueEdit::Transform(poses))) => {
                        window.target.to_world = poses[0].1
                    }
                    _ => {}
                }
            }
            window.commands.extend(commands);
        },
        window,
    );
    harness.run_steps(3);
    harness
}

fn lamp() -> Vec3 {
    Vec3::new(-3.0, 2.0, 0.0)
}

fn button(harness: &mut Harness<Window>, button: PointerButton, at: Pos2, pressed: bool, modifiers: Modifiers) {
    harness.event(egui::Event::PointerButton {
        pos: at,
        button,
        pressed,
        modifiers,
    });
    harness.run_steps(1);
}

/// Presses, goes there in five steps if it is elsewhere, and lets go unless told otherwise.
pub fn drag(
    harness: &mut Harness<Window>,
    with: PointerButton,
    from: Pos2,
    to: Pos2,
    modifiers: Modifiers,
    lets_go: bool,
) {
    harness.event(egui::Event::ModifiersChanged(modifiers));
    harness.event(egui::Event::PointerMoved(from));
    harness.run_steps(2);
    button(harness, with, from, true, modifiers);
    // What takes long is no click.
    let steps = if from == to { 0 } else { 5 };
    for step in 1..=steps {
        harness.event(egui::Event::PointerMoved(from + (to - from) * (step as f32 / 5.0)));
        harness.run_steps(1);
    }
    if lets_go {
        button(harness, with, to, false, modifiers);
    }
    harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
}

fn moved_to(harness: &Harness<Window>) -> Vec3 {
    harness.state().target.to_world.translation.into()
}

fn at(harness: &Harness<Window>, world: Vec3) -> Pos2 {
    screen(harness.state()).project(world).expect("in front")
}

pub fn keys(harness: &mut Harness<Window>, keys: &[Key]) {
    for &key in keys {
        harness.key_press(key);
        harness.run_steps(1);
    }
}

fn views(harness: &Harness<Window>) -> Vec<Affine3A> {
    let view = |command: &Command| match command {
        Command::View(ViewCommand::MoveView(pose)) => Some(*pose),
        _ => None,
    };
    harness.state().commands.iter().filter_map(view).collect()
}

#[test]
fn a_handle_is_dragged_and_nothing_else_happens() {
    let mut harness = window();
    let (from, to) = (at(&harness, 0.5 * Vec3::X), at(&harness, 2.5 * Vec3::X));
    drag(&mut harness, PointerButton::Primary, from, to, Modifiers::NONE, true);
    harness.run_steps(3);
    assert!(
        moved_to(&harness).abs_diff_eq(2.0 * Vec3::X, 1e-3),
        "{}",
        moved_to(&harness)
    );
    let commands = &harness.state().commands;
    assert!(
        commands
            .iter()
            .all(|command| matches!(command, Command::Edit(EditCommand::Value(ValueEdit::Transform(_))))),
        "{commands:?}"
    );
    assert!(commands.len() >= 4, "it follows the pointer");
}

#[test]
fn what_is_over_a_picture_has_its_place_before_there_is_one() {
    let mut harness = window();
    let state = harness.state_mut();
    state.unrendered = Some([800, 400]);
    state.camera = Camera::new(pose(), 60.0, 2.0, 0.01, 100.0, None);
    harness.run_steps(3);
    assert_eq!(harness.state().state.picture, None, "it is being prepared");
    harness.state_mut().is_paused = true;
    harness.run_steps(3);
    let picture = harness.state().state.picture.expect("a place");
    assert_eq!(picture.size.to_array(), [800, 400]);
    let screen = Screen {
        camera: harness.state().camera,
        picture: egui::Rect::from_center_size(pos2(400.0, 300.0), vec2(800.0, 400.0)),
    };
    let at = |x: f32| screen.project(x * Vec3::X).expect("in front");
    drag(
        &mut harness,
        PointerButton::Primary,
        at(0.5),
        at(2.5),
        Modifiers::NONE,
        true,
    );
    harness.run_steps(3);
    assert!(
        moved_to(&harness).abs_diff_eq(2.0 * Vec3::X, 1e-3),
        "{}",
        moved_to(&harness)
    );
}

#[test]
fn control_rounds_and_escape_puts_back() {
    let mut harness = window();
    let (from, to) = (at(&harness, 0.5 * Vec3::X), at(&harness, 2.4 * Vec3::X));
    drag(
        &mut harness,
        PointerButton::Primary,
        from,
        to,
        Modifiers::COMMAND,
        false,
    );
    assert!(
        moved_to(&harness).abs_diff_eq(2.0 * Vec3::X, 1e-4),
        "{}",
        moved_to(&harness)
    );
    keys(&mut harness, &[Key::Escape]);
    assert_eq!(moved_to(&harness), Vec3::ZERO);
    button(&mut harness, PointerButton::Primary, to, false, Modifiers::NONE);
    harness.run_steps(3);
    let commands = &harness.state().commands;
    assert!(
        commands
            .iter()
            .all(|command| matches!(command, Command::Edit(EditCommand::Value(ValueEdit::Transform(_))))),
        "{commands:?}"
    );
}

#[test]
fn the_bar_of_a_paused_picture_leaves_the_handles_free() {
    const WORDS: &str = "Paused: the picture is older than the scene";
    let mut harness = window();
    harness.state_mut().is_paused = true;
    for height in [-4.0, -2.0, 1.0, 2.0, 3.0, 4.0, 0.0] {
        let place = Vec3::Y * height;
        let target = &mut harness.state_mut().target;
        target.to_world = Affine3A::from_translation(place);
        target.bounds = Some(Aabb {
            min: place - 1.0,
            max: place + 1.0,
        });
        harness.run_steps(2);
        let words = harness.get_by_label(WORDS).rect();
        let middle = at(&harness, place);
        assert!(!words.expand(90.0).contains(middle), "{words:?} {middle:?}");
    }
    // A drag goes over it.
    let words = harness.get_by_label(WORDS).rect();
    let tip = at(&harness, Vec3::ZERO) - vec2(0.0, 60.0);
    drag(
        &mut harness,
        PointerButton::Primary,
        tip,
        words.center(),
        Modifiers::NONE,
        false,
    );
    assert!(moved_to(&harness).y > 0.0);
    assert!(harness.query_by_label(WORDS).is_none());
    button(
        &mut harness,
        PointerButton::Primary,
        words.center(),
        false,
        Modifiers::NONE,
    );
    harness.run_steps(2);
    assert!(harness.query_by_label(WORDS).is_some());
}

#[test]
fn a_click_on_the_bar_of_a_paused_picture_goes_on() {
    let mut harness = window();
    harness.state_mut().is_paused = true;
    harness.run_steps(2);
    harness.get_by_label("Resume").click();
    harness.run_steps(2);
    assert_eq!(
        harness.state().commands,
        [Command::from(RenderCommand::SetPaused(false))]
    );
    harness.state_mut().is_paused = false;
    harness.run_steps(2);
    assert!(harness.query_by_label("Resume").is_none());
}

#[test]
fn a_press_on_a_handle_alone_does_nothing() {
    let mut harness = window();
    let from = at(&harness, 0.5 * Vec3::X);
    drag(&mut harness, PointerButton::Primary, from, from, Modifiers::NONE, true);
    harness.run_steps(3);
    assert_eq!(harness.state().commands, []);
}

#[test]
fn keys_alone_move_by_numbers() {
    let mut harness = window();
    keys(&mut harness, &[Key::G, Key::X, Key::Num1, Key::Period, Key::Num5]);
    assert_eq!(moved_to(&harness), 1.5 * Vec3::X);
    keys(&mut harness, &[Key::Minus]);
    assert_eq!(moved_to(&harness), -1.5 * Vec3::X);
    keys(&mut harness, &[Key::Enter, Key::X]);
    assert_eq!(moved_to(&harness), -1.5 * Vec3::X);
    assert_eq!(harness.state().gizmo.axes, Axes::Local, "X is the axes' key again");
    keys(&mut harness, &[Key::R, Key::Z, Key::Num9, Key::Num0, Key::Escape]);
    assert_eq!(harness.state().target.to_world.matrix3, Affine3A::IDENTITY.matrix3);
    assert_eq!(harness.state().gizmo.mode, Mode::Rotate);
}

/// A slow frame gets many keys at once: each amount is done before what ends it, and each drag is a step of its own.
#[test]
fn keys_of_one_frame_are_done_one_after_the_other() {
    let mut harness = window();
    let typed = [
        [Key::G, Key::X, Key::Num2, Key::R].as_slice(),
        &[
            Key::Z,
            Key::Num9,
            Key::Num0,
            Key::Enter,
            Key::G,
            Key::Y,
            Key::Num1,
            Key::Enter,
        ],
    ];
    let mut begun = 0;
    for key in typed.concat() {
        for pressed in [true, false] {
            harness.input_mut().events.push(egui::Event::Key {
                key,
                physical_key: None,
                pressed,
                repeat: false,
                modifiers: Modifiers::NONE,
            });
        }
    }
    for _ in 0..6 {
        harness.run_steps(1);
        begun += usize::from(harness.state_mut().state.gizmo.take_begun());
    }
    let pose = harness.state().target.to_world;
    // Turned around the middle of its bounds, which stay at the origin here.
    assert!(
        Vec3::from(pose.translation).abs_diff_eq(Vec3::new(0.0, 3.0, 0.0), 1e-5),
        "{pose:?}"
    );
    assert!(pose.transform_vector3(Vec3::X).abs_diff_eq(Vec3::Y, 1e-5), "{pose:?}");
    assert_eq!(begun, 3);
}

#[test]
fn the_same_key_again_follows_the_mouse_until_a_click() {
    let mut harness = window();
    let from = at(&harness, Vec3::new(2.0, -2.0, 0.0));
    harness.hover_at(from);
    keys(&mut harness, &[Key::G, Key::G]);
    let by = Vec3::new(1.0, 0.5, 0.0);
    let to = at(&harness, Vec3::new(2.0, -2.0, 0.0) + by);
    harness.hover_at(to);
    harness.run_steps(1);
    assert!(moved_to(&harness).abs_diff_eq(by, 1e-3), "{}", moved_to(&harness));
    keys(&mut harness, &[Key::Y]);
    assert!(
        moved_to(&harness).abs_diff_eq(0.5 * Vec3::Y, 1e-3),
        "{}",
        moved_to(&harness)
    );
    drag(&mut harness, PointerButton::Primary, to, to, Modifiers::NONE, true);
    harness.hover_at(from);
    harness.run_steps(3);
    assert!(moved_to(&harness).abs_diff_eq(0.5 * Vec3::Y, 1e-3));
    let picks = |command: &Command| {
        matches!(
            command,
            Command::Selection(SelectionCommand::Pick(..) | SelectionCommand::Select(..))
        )
    };
    assert!(!harness.state().commands.iter().any(picks), "the click ended the drag");
}

#[test]
fn other_keys_after_a_mode_are_what_they_always_are() {
    let mut harness = window();
    keys(&mut harness, &[Key::T, Key::N, Key::X, Key::Num1]);
    let gizmo = GizmoSettings {
        mode: Mode::Scale,
        ..GizmoSettings::default()
    };
    let local = GizmoSettings {
        axes: Axes::Local,
        ..gizmo
    };
    let expected = [
        Command::from(ToolCommand::SetGizmo(gizmo)),
        Command::from(DisplayCommand::SetDenoising(true)),
        Command::from(ToolCommand::SetGizmo(local)),
        Command::from(ViewCommand::RecallView(1)),
    ];
    assert_eq!(harness.state().commands, expected);
}

#[test]
fn arrows_nudge_and_end_drops() {
    let mut harness = window();
    keys(&mut harness, &[Key::ArrowLeft, Key::ArrowUp, Key::PageDown, Key::End]);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Num3);
    harness.run_steps(1);
    let nudge = |it| ArrangeEdit::Nudge(it).into();
    let expected = [
        nudge(Direction::Left),
        nudge(Direction::Ahead),
        nudge(Direction::Down),
        Command::from(ArrangeEdit::Drop),
        Command::from(ViewCommand::StoreView(3)),
    ];
    assert_eq!(harness.state().commands, expected);
}

#[test]
fn digits_of_the_numpad_are_views_along_axes() {
    let press = Press {
        key: Key::Num7,
        modifiers: Modifiers::NONE,
        numpad: true,
    };
    let selection = Selection::default();
    let commands = sunroom::app::editor::input::keys::shortcuts(&[press], &ActionContext::new(&selection));
    assert_eq!(commands, [Command::from(ViewCommand::LookAlong(AxisView::Top))]);
}

#[test]
fn alt_orbits_the_selection_and_the_middle_button_pans() {
    let mut harness = window();
    let from = Pos2::new(200.0, 400.0);
    drag(
        &mut harness,
        PointerButton::Primary,
        from,
        from + vec2(100.0, 20.0),
        Modifiers::ALT,
        true,
    );
    let orbited = *views(&harness).last().expect("it orbits");
    let seen = |pose: Affine3A| pose.inverse().transform_point3(Vec3::ZERO);
    assert!(
        seen(orbited).abs_diff_eq(seen(pose()), 1e-3) && orbited.translation.x > 0.1,
        "{orbited}"
    );

    let mut harness = window();
    drag(
        &mut harness,
        PointerButton::Middle,
        from,
        from + vec2(50.0, 0.0),
        Modifiers::NONE,
        true,
    );
    // The view of the test does not follow: each of the five steps is by ten points of the picture at half the scene's
    // size, 5 units.
    let step = 10.0 * 2.0 * 5.0 * 30f32.to_radians().tan() / SIZE.x;
    let panned: Vec<f32> = views(&harness).iter().map(|view| view.translation.x).collect();
    assert!(
        panned.len() == 5 && panned.iter().all(|x| (x - step).abs() < 1e-4),
        "{panned:?} for {step}"
    );
}

#[test]
fn the_middle_button_does_what_the_preset_says() {
    let from = Pos2::new(200.0, 400.0);
    let dragged = |preset, modifiers| {
        let mut harness = window();
        harness.state_mut().preset = preset;
        let to = from + vec2(40.0, -20.0);
        drag(&mut harness, PointerButton::Middle, from, to, modifiers, true);
        *views(&harness).last().expect("the view moves")
    };
    let seen = |pose: Affine3A| pose.inverse().transform_point3(Vec3::ZERO);
    let orbits =
        |pose: Affine3A| pose.matrix3 != self::pose().matrix3 && seen(pose).abs_diff_eq(seen(self::pose()), 1e-3);
    let shift = Modifiers::SHIFT;
    assert!(orbits(dragged(NavigationPreset::Blender, Modifiers::NONE)));
    assert!(orbits(dragged(NavigationPreset::Sunroom, shift)));
    let panned = dragged(NavigationPreset::Blender, shift);
    assert!(
        panned.matrix3 == pose().matrix3 && panned.translation.z == -10.0,
        "{panned}"
    );
    // Up is nearer.
    let near = dragged(NavigationPreset::Blender, Modifiers::COMMAND);
    assert!(near.matrix3 == pose().matrix3 && near.translation.z > -10.0, "{near}");
}

#[test]
fn a_box_without_keys_replaces_the_selection() {
    let mut harness = window();
    harness.state_mut().preset = NavigationPreset::Blender;
    let lamp = at(&harness, lamp());
    let (from, to) = (lamp - vec2(30.0, 20.0), lamp + vec2(20.0, 20.0));
    drag(&mut harness, PointerButton::Primary, from, to, Modifiers::NONE, true);
    let empty = Pos2::new(20.0, 560.0);
    let beside = empty + vec2(30.0, 20.0);
    drag(
        &mut harness,
        PointerButton::Primary,
        empty,
        beside,
        Modifiers::NONE,
        true,
    );
    let selects = |entities| Command::from(SelectionCommand::Select(entities, Extend::Replace));
    assert_eq!(
        harness.state().commands,
        [selects(vec![entity(7)]), selects(Vec::new())]
    );
}

/// Turns the mouse wheel by one notch away from the user.
fn turn_wheel(harness: &mut Harness<Window>) {
    harness.event(egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: vec2(0.0, 1.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    });
    harness.run_steps(2);
}

#[test]
fn the_wheel_goes_towards_the_pointer() {
    let mut harness = window();
    harness.hover_at(Pos2::new(100.0, 300.0));
    harness.run_steps(2);
    turn_wheel(&mut harness);
    let [view] = views(&harness)[..] else {
        panic!("one step")
    };
    assert!(view.translation.x > 0.0 && view.translation.z > -10.0, "{view}");
    assert_eq!(view.matrix3, pose().matrix3);
}

#[test]
fn the_wheel_turns_over_the_hint_of_an_empty_scene() {
    let mut harness = window();
    harness.state_mut().is_empty = true;
    harness.run_steps(3);
    for name in ["This scene has no shapes yet", "Import…"] {
        let place = harness.get_by_label(name).rect().center();
        harness.state_mut().commands.clear();
        harness.hover_at(place);
        harness.run_steps(2);
        turn_wheel(&mut harness);
        let [view] = views(&harness)[..] else {
            panic!("{name}: {:?}", harness.state().commands)
        };
        assert!(view.translation.z > -10.0, "{name}: {view}");
    }
}

#[test]
fn the_wheel_over_the_ground_goes_a_share_of_the_way_to_it() {
    let mut harness = window();
    // The eye is five units above the ground, and looks down at it.
    let eye = Vec3::new(0.0, 5.0, -5.0);
    let forward = -eye.normalize();
    let left = Vec3::Y.cross(forward).normalize();
    let axes = bevy::math::Mat3::from_cols(left, forward.cross(left), forward);
    let pose = Affine3A::from_mat3_translation(axes, eye);
    harness.state_mut().camera = Camera::new(pose, 60.0, 4.0 / 3.0, 0.01, 100.0, None);
    harness.hover_at(Pos2::new(400.0, 450.0));
    harness.run_steps(2);
    let screen = screen(harness.state());
    let ray = screen.ray(Pos2::new(400.0, 450.0));
    let ground = ray.at(-ray.origin.y / ray.dir.y);
    let turn = |notches: f32| egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: vec2(0.0, notches),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    };
    harness.event(turn(-1.0));
    harness.run_steps(2);
    let [view] = views(&harness)[..] else {
        panic!("one step")
    };
    // The model's pose stays where the window began, so that only the way counts.
    let way = Vec3::from(view.translation) - Vec3::new(0.0, 0.0, -10.0);
    let share = way.length() / ground.distance(Vec3::new(0.0, 0.0, -10.0));
    assert!(way.dot(ray.dir) < 0.0 && (0.1..0.3).contains(&share), "{share}");
}

#[test]
fn what_is_under_the_pointer_is_marked_for_users_alone() {
    let mut harness = window();
    let lamp = at(&harness, lamp());
    for (is_attended, expected) in [(true, Some(entity(7))), (false, None)] {
        harness.state_mut().state = ViewportState::new(is_attended);
        for place in [Pos2::ZERO, lamp] {
            harness.event(egui::Event::PointerMoved(place));
            harness.run_steps(2);
        }
        assert_eq!(harness.state().state.pointer.hovered, expected);
    }
}

#[test]
fn a_box_and_a_click_select_lamps() {
    let mut harness = window();
    let lamp = at(&harness, lamp());
    let (from, to) = (lamp - vec2(30.0, 20.0), lamp + vec2(20.0, 20.0));
    drag(&mut harness, PointerButton::Primary, from, to, Modifiers::SHIFT, true);
    assert_eq!(
        harness.state().commands,
        [Command::from(SelectionCommand::Select(vec![entity(7)], Extend::Add))]
    );
    harness.state_mut().commands.clear();
    drag(&mut harness, PointerButton::Primary, lamp, lamp, Modifiers::NONE, true);
    assert_eq!(
        harness.state().commands,
        [Command::from(SelectionCommand::Select(
            vec![entity(7)],
            Extend::Replace
        ))]
    );
    harness.state_mut().commands.clear();
    let beside = Pos2::new(40.0, 500.0);
    drag(
        &mut harness,
        PointerButton::Primary,
        beside,
        beside,
        Modifiers::COMMAND,
        true,
    );
    let film = Vec2::new(beside.x / SIZE.x, beside.y / SIZE.y);
    assert_eq!(
        harness.state().commands,
        [Command::from(SelectionCommand::Pick(film, Extend::Toggle))]
    );
}

#[test]
fn the_place_of_the_picture_is_noted_in_pixels() {
    let mut harness = window();
    assert_eq!(harness.state().state.room, Some(bevy::math::UVec2::new(800, 600)));
    harness.set_pixels_per_point(1.5);
    harness.run_steps(2);
    assert_eq!(harness.state().state.room, Some(bevy::math::UVec2::new(1200, 900)));
}
