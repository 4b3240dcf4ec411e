//! The picture: its keys, its mouse, and what is dropped on it.

use bevy::math::{Affine3A, Vec2};
use bevy_egui::egui::{self, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::camera::navigation::Navigation;
use sunroom::app::editor::command::bvh_overlay::BvhOverlay;
use sunroom::app::editor::command::display::{DisplayMode, DisplaySettings};
use sunroom::app::editor::command::selection::{Extend, Selection};
use sunroom::app::editor::command::{
    Command, DisplayCommand, EditCommand, FileCommand, FileDialogKind, HistoryCommand, MaterialEdit, OutlineEdit,
    RenderCommand, SelectionCommand, ViewCommand,
};
use sunroom::app::editor::input::actions::ActionContext;
use sunroom::app::editor::input::pipette;
use sunroom::app::editor::model::Outline;
use sunroom::app::editor::panels::outliner::state::OutlinerState;
use sunroom::app::editor::panels::{color_field, outliner};
use sunroom::app::editor::viewport::model::ViewportModel;
use sunroom::app::editor::viewport::state::ViewportState;
use sunroom::app::editor::viewport::viewport;
use sunroom::color::Rgb;
use sunroom::render::camera::Camera;

use super::{click, drag, entity, item, press_at, show_beside_picture, with_outline};
use crate::support::{ViewportContent, presses};

/// The picture in a panel of 340 x 240 points, with a text field and a number above it.
pub struct Picture {
    commands: Vec<Command>,
    state: ViewportState,
    text: String,
    number: f32,
    pose: Affine3A,
    walks: bool,
}

pub fn picture() -> Harness<'static, Picture> {
    let picture = Picture {
        commands: Vec::new(),
        state: ViewportState::default(),
        text: String::new(),
        number: 1.0,
        pose: Affine3A::IDENTITY,
        walks: false,
    };
    let content = ViewportContent {
        selection: Selection::of([entity(1)]),
        ..ViewportContent::default()
    };
    let mut harness = Harness::builder().with_size(egui::vec2(340.0, 240.0)).build_ui_state(
        move |ui, picture: &mut Picture| {
            ui.horizontal(|ui| {
                ui.add(egui::TextEdit::singleline(&mut picture.text).desired_width(60.0));
                let name = ui.label("number").id;
                ui.add(egui::DragValue::new(&mut picture.number)).labelled_by(name);
            });
            // A field that may ask for a colour.
            let _ = pipette::take(ui.ctx(), egui::Id::new("field"));
            let presses = presses(ui);
            let camera = Camera::new(picture.pose, 60.0, 2.0, 0.01, 100.0, None);
            let empty = content.model([200, 100], picture.pose, camera, &presses);
            let model = ViewportModel {
                navigation: Navigation::default(),
                keys: ActionContext {
                    walks: picture.walks,
                    ..empty.keys
                },
                ..empty
            };
            viewport(ui, &model, &mut picture.state, &mut picture.commands);
        },
        picture,
    );
    harness.run_steps(3);
    harness
}

fn last_pose(harness: &Harness<Picture>) -> Option<Affine3A> {
    harness.state().commands.iter().rev().find_map(|command| match command {
        Command::View(ViewCommand::MoveView(pose)) => Some(*pose),
        _ => None,
    })
}

const MIDDLE: Pos2 = Pos2::new(170.0, 130.0);

#[test]
fn a_material_is_dragged_from_the_list_onto_the_picture() {
    let outline = Outline {
        materials: vec![item(31, "glass")].into(),
        ..Outline::default()
    };
    let mut state = OutlinerState::default();
    let model = with_outline(outline, Selection::default());
    let mut harness = show_beside_picture(egui::vec2(540.0, 240.0), 200.0, model, move |ui, model, commands| {
        outliner::outliner(ui, model, &mut state, commands);
    });
    let line = harness.get_by_label("glass").rect().center();
    let target = Pos2::new(380.0, 120.0);
    harness.hover_at(line);
    harness.run_steps(1);
    harness.drag_at(line);
    harness.run_steps(1);
    for step in 1..=6 {
        harness.hover_at(line.lerp(target, step as f32 / 6.0));
        harness.run_steps(1);
    }
    harness.drop_at(target);
    harness.run_steps(2);
    let [Command::Edit(EditCommand::Material(MaterialEdit::DropMaterial { material, at }))] =
        harness.state().commands[..]
    else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!(material, entity(31));
    assert!(at.min_element() > 0.2 && at.max_element() < 0.8, "{at}");
}

#[test]
fn while_a_colour_is_asked_for_a_click_selects_nothing_and_escape_gives_up() {
    let mut harness = picture();
    pipette::begin(&harness.ctx, egui::Id::new("field"));
    press_at(&mut harness, MIDDLE);
    assert_eq!(harness.state().commands, []);
    assert!(pipette::is_waiting(&harness.ctx), "nothing is rendered yet");
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert!(!pipette::is_waiting(&harness.ctx));
    assert_eq!(harness.state().commands, []);
}

#[test]
fn the_picker_takes_a_colour_of_the_picture() {
    let mut harness = Harness::builder().with_size(egui::vec2(320.0, 320.0)).build_ui_state(
        |ui, color: &mut Rgb| _ = color_field::color(ui, "Reflectance", color),
        Rgb::ZERO,
    );
    harness.run_steps(2);
    let button = harness.get_by_role(egui::accesskit::Role::ColorWell).rect().center();
    press_at(&mut harness, button);
    click(&mut harness, "Pick from the picture");
    assert!(pipette::is_waiting(&harness.ctx));
    assert!(
        harness.query_by_label("Pick from the picture").is_none(),
        "the picker is out of the way"
    );
    let blue = Rgb::new(0.2, 0.4, 0.6);
    pipette::give(&harness.ctx, blue);
    harness.run_steps(2);
    assert_eq!(*harness.state(), blue);
}

#[test]
fn a_click_picks_and_a_drag_looks() {
    let mut harness = picture();
    assert_eq!(harness.state().commands, []);
    press_at(&mut harness, MIDDLE);
    let [Command::Selection(SelectionCommand::Pick(film, Extend::Replace))] = harness.state().commands[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert!(film.abs_diff_eq(Vec2::splat(0.5), 0.1), "{film}");
    harness.state_mut().commands.clear();
    harness.drag_at(MIDDLE);
    for step in 1..=5 {
        harness.hover_at(MIDDLE + egui::vec2(15.0 * step as f32, 0.0));
        harness.run_steps(1);
    }
    harness.drop_at(MIDDLE + egui::vec2(75.0, 0.0));
    harness.run_steps(1);
    let pose = last_pose(&harness).expect("looked around");
    assert!(
        pose.matrix3.z_axis.x < 0.0,
        "to the right is -x: {}",
        pose.matrix3.z_axis
    );
    assert!(
        !harness
            .state()
            .commands
            .iter()
            .any(|command| matches!(command, Command::Selection(SelectionCommand::Pick(..))))
    );
}

#[test]
fn keys_fly_unless_a_text_is_being_typed() {
    let mut harness = picture();
    harness.key_down(Key::W);
    harness.run_steps(2);
    harness.key_up(Key::W);
    harness.run_steps(1);
    assert!(last_pose(&harness).is_some_and(|pose| pose.translation.z > 0.0));

    harness.get_by_role(egui::accesskit::Role::TextInput).focus();
    harness.run_steps(2);
    harness.state_mut().commands.clear();
    harness.key_down(Key::W);
    harness.key_press(Key::Space);
    harness.run_steps(2);
    harness.key_up(Key::W);
    harness.run_steps(1);
    assert_eq!(harness.state().commands, []);
}

#[test]
fn keys_walk_on_the_level_and_one_key_begins_and_ends_it() {
    let mut harness = picture();
    for walks in [false, true] {
        harness.state_mut().walks = walks;
        harness.state_mut().commands.clear();
        harness.key_press(Key::C);
        harness.run_steps(2);
        assert_eq!(harness.state().commands, [Command::from(ViewCommand::Walk(!walks))]);
    }
    // The view looks down.
    harness.state_mut().pose = Affine3A::from_rotation_x(0.5);
    harness.state_mut().commands.clear();
    harness.key_down(Key::W);
    harness.run_steps(2);
    harness.key_up(Key::W);
    harness.run_steps(1);
    let pose = last_pose(&harness).expect("walked");
    assert!(
        pose.translation.z > 0.0 && pose.translation.y.abs() < 1e-6,
        "{}",
        pose.translation
    );
}

#[test]
fn keys_work_again_right_after_a_number_was_dragged() {
    let mut harness = picture();
    drag(&mut harness, "number", 30.0);
    assert!(harness.state().number > 1.0);
    harness.state_mut().commands.clear();
    harness.key_press(Key::N);
    harness.run_steps(2);
    assert_eq!(
        harness.state().commands,
        [Command::from(DisplayCommand::SetDenoising(true))]
    );
}

#[test]
fn a_number_is_typed_without_side_effects() {
    let mut harness = picture();
    click(&mut harness, "number");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text("42".into()));
    harness.key_press(Key::B);
    harness.run_steps(2);
    harness.key_press(Key::Enter);
    harness.run_steps(3);
    assert_eq!(harness.state().number, 42.0);
    assert_eq!(harness.state().commands, []);
}

#[test]
fn keys_are_commands() {
    let display = DisplaySettings::default();
    let table = [
        (
            Key::Space,
            Modifiers::NONE,
            Command::from(RenderCommand::SetPaused(true)),
        ),
        (Key::R, Modifiers::SHIFT, Command::from(RenderCommand::Restart)),
        (
            Key::Tab,
            Modifiers::NONE,
            Command::from(DisplayCommand::SetDisplay(DisplaySettings {
                mode: DisplayMode::Albedo,
                ..display
            })),
        ),
        (
            Key::CloseBracket,
            Modifiers::NONE,
            Command::from(DisplayCommand::SetDisplay(DisplaySettings {
                exposure: 0.25,
                ..display
            })),
        ),
        (
            Key::B,
            Modifiers::NONE,
            Command::from(DisplayCommand::SetOverlay(BvhOverlay {
                shown: true,
                ..BvhOverlay::default()
            })),
        ),
        (Key::F, Modifiers::NONE, Command::from(ViewCommand::FrameSelection)),
        (Key::Home, Modifiers::NONE, Command::from(ViewCommand::FrameAll)),
        (
            Key::N,
            Modifiers::NONE,
            Command::from(DisplayCommand::SetDenoising(true)),
        ),
        (
            Key::Escape,
            Modifiers::NONE,
            Command::from(SelectionCommand::Select(Vec::new(), Extend::Replace)),
        ),
        (
            Key::O,
            Modifiers::COMMAND,
            Command::from(FileCommand::ShowDialog(FileDialogKind::OpenScene)),
        ),
        (Key::S, Modifiers::COMMAND, Command::from(FileCommand::Save)),
        (
            Key::S,
            Modifiers::COMMAND | Modifiers::SHIFT,
            Command::from(FileCommand::ShowDialog(FileDialogKind::SaveScene)),
        ),
        (Key::Z, Modifiers::COMMAND, Command::from(HistoryCommand::Undo)),
        (
            Key::Z,
            Modifiers::COMMAND | Modifiers::SHIFT,
            Command::from(HistoryCommand::Redo),
        ),
        (
            Key::H,
            Modifiers::NONE,
            Command::from(OutlineEdit::Hide(vec![entity(1)], true)),
        ),
        (Key::H, Modifiers::ALT, Command::from(OutlineEdit::ShowAll)),
    ];
    let mut harness = picture();
    for (key, modifiers, expected) in table {
        harness.state_mut().commands.clear();
        harness.key_press_modifiers(modifiers, key);
        harness.run_steps(2);
        assert_eq!(harness.state().commands, [expected], "{key:?}");
    }
}

#[test]
fn the_wheel_dollies_and_with_the_right_button_sets_the_speed() {
    let wheel = || egui::Event::MouseWheel {
        unit: egui::MouseWheelUnit::Line,
        delta: egui::vec2(0.0, 1.0),
        phase: egui::TouchPhase::Move,
        modifiers: Modifiers::NONE,
    };
    let mut harness = picture();
    harness.hover_at(MIDDLE);
    harness.run_steps(1);
    harness.event(wheel());
    harness.run_steps(1);
    assert!(last_pose(&harness).is_some_and(|pose| pose.translation.z > 0.0));
    harness.state_mut().commands.clear();
    harness.event(egui::Event::PointerButton {
        pos: MIDDLE,
        button: PointerButton::Secondary,
        pressed: true,
        modifiers: Modifiers::NONE,
    });
    harness.event(wheel());
    harness.run_steps(1);
    assert!(matches!(harness.state().commands[..], [Command::View(ViewCommand::SetSpeed(speed))] if speed > 1.0));
}
