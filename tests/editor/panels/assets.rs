//! The browser of assets.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::math::{Vec2, Vec3};
use bevy_egui::egui::{self, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::asset_kind::{AssetKind, FileUse};
use sunroom::app::editor::command::{Command, EditCommand, FileCommand, FileDialogKind, SceneEdit, ShellCommand};
use sunroom::app::editor::model::Model;
use sunroom::app::editor::model::assets::{AssetEntry, AssetPicture, AssetPlace, AssetsModel, Listing};
use sunroom::app::editor::panels::assets::{AssetsState, assets};
use sunroom::app::editor::window::scene_question;

use super::{click, drag_between, show_beside_picture};

fn entry(name: &str, bytes: u64) -> AssetEntry {
    let path = Path::new("/assets").join(name);
    AssetEntry {
        name: name.to_owned(),
        kind: AssetKind::of(&path),
        path,
        bytes,
        modified: None,
    }
}

fn model() -> Model {
    let entries = [
        "inner",
        "bunny.ply",
        "broken.png",
        "red.xml",
        "room.xml",
        "sky.hdr",
        "wood.png",
    ];
    let entries = entries
        .iter()
        .enumerate()
        .map(|(bytes, name)| entry(name, bytes as u64));
    let path = |name: &str| Path::new("/assets").join(name);
    let pictures = [
        (
            path("bunny.ply"),
            AssetPicture {
                bounds: Some([Vec3::ZERO, Vec3::ONE]),
                ..AssetPicture::default()
            },
        ),
        (
            path("broken.png"),
            AssetPicture {
                problem: Some("not a picture in a known format".to_owned()),
                ..AssetPicture::default()
            },
        ),
        (
            path("red.xml"),
            AssetPicture {
                is_material: true,
                ..AssetPicture::default()
            },
        ),
        (path("room.xml"), AssetPicture::default()),
    ];
    Model {
        assets: AssetsModel {
            places: Arc::new(vec![AssetPlace {
                name: "Mine".to_owned(),
                folder: "/assets".into(),
                is_own: true,
            }]),
            listing: Some(Arc::new(Listing {
                folder: "/assets".into(),
                entries: entries.collect(),
                problem: None,
            })),
            pictures: Arc::new(pictures.into_iter().collect()),
            environments: Arc::default(),
        },
        ..Model::default()
    }
}

type Shown = egui_kittest::Harness<'static, super::Shown<Model>>;

/// The panel beside a picture, and the folder that it has gone to and the files whose pictures it wants.
fn shown() -> (Shown, Arc<std::sync::Mutex<AssetsState>>) {
    let mut state = AssetsState::default();
    state.folder = Some("/assets".into());
    let state = Arc::new(std::sync::Mutex::new(state));
    let seen = state.clone();
    let harness = show_beside_picture(egui::vec2(640.0, 500.0), 240.0, model(), move |ui, model, commands| {
        let mut state = state.lock().expect("one thread");
        state.in_sight.clear();
        assets(ui, model, &mut state, commands);
    });
    (harness, seen)
}

fn double_click(harness: &mut Shown, name: &str) {
    let place = harness.get_by_label(name).rect().center();
    harness.hover_at(place);
    harness.run_steps(1);
    let button = |pressed| egui::Event::PointerButton {
        pos: place,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: egui::Modifiers::NONE,
    };
    // A frame takes so long here that clicks of two frames each would be too far apart.
    for _ in 0..2 {
        harness.input_mut().events.extend([button(true), button(false)]);
        harness.run_steps(1);
    }
    harness.run_steps(1);
}

#[test]
fn a_drag_into_the_picture_takes_the_file_with_its_bounds() {
    let (mut harness, _) = shown();
    let from = harness.get_by_label("bunny.ply").rect().center();
    drag_between(&mut harness, from, Pos2::new(440.0, 250.0));
    let [Command::Edit(EditCommand::Scene(SceneEdit::UseFile(file)))] = &harness.state().commands[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!(
        (file.path.as_path(), file.bounds),
        (Path::new("/assets/bunny.ply"), Some([Vec3::ZERO, Vec3::ONE]))
    );
    assert!(
        file.at.is_some_and(|at| at.abs_diff_eq(Vec2::splat(0.5), 0.1)),
        "{file:?}"
    );
}

#[test]
fn a_double_click_does_what_suits_the_file() {
    for (name, opens) in [("wood.png", false), ("red.xml", false), ("room.xml", true)] {
        let (mut harness, _) = shown();
        double_click(&mut harness, name);
        let path = PathBuf::from("/assets").join(name);
        let expected = match opens {
            true => Command::from(FileCommand::OpenScene(path)),
            false => Command::from(SceneEdit::UseFile(Box::new(FileUse {
                path,
                at: None,
                bounds: None,
            }))),
        };
        assert_eq!(harness.state().commands, [expected]);
    }
}

#[test]
fn of_a_scene_in_the_picture_it_is_asked_whether_it_is_added_or_opened() {
    let (mut harness, _) = shown();
    let from = harness.get_by_label("room.xml").rect().center();
    drag_between(&mut harness, from, Pos2::new(440.0, 250.0));
    let [Command::Shell(ShellCommand::AskAboutScene(file))] = &harness.state().commands[..] else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!(file.path, Path::new("/assets/room.xml"));
    assert!(file.at.is_some());
    // Materials are for the shape there.
    let (mut harness, _) = shown();
    let from = harness.get_by_label("red.xml").rect().center();
    drag_between(&mut harness, from, Pos2::new(440.0, 250.0));
    assert!(matches!(
        harness.state().commands[..],
        [Command::Edit(EditCommand::Scene(SceneEdit::UseFile(_)))]
    ));
}

#[test]
fn the_answer_adds_the_scene_or_opens_it() {
    let file = FileUse {
        path: "/assets/room.xml".into(),
        at: None,
        bounds: None,
    };
    let open = Command::from(FileCommand::OpenScene(file.path.clone()));
    let add = Command::from(SceneEdit::UseFile(Box::new(file.clone())));
    for (answer, expected) in [("Add", vec![add]), ("Open", vec![open]), ("Cancel", vec![])] {
        let shown = (Some(file.clone()), Vec::new());
        let mut harness = Harness::builder().with_size(egui::vec2(640.0, 480.0)).build_ui_state(
            |ui, (asked, commands): &mut (Option<FileUse>, Vec<Command>)| {
                scene_question::question(&ui.ctx().clone(), asked, commands);
            },
            shown,
        );
        harness.run_steps(3);
        harness.get_by_label(answer).click();
        harness.run_steps(3);
        assert_eq!(*harness.state(), (None, expected));
    }
}

#[test]
fn a_folder_is_chosen_by_the_dialog() {
    let (mut harness, _) = shown();
    click(&mut harness, "Add…");
    let expected = Command::from(FileCommand::ShowDialog(FileDialogKind::AssetFolder));
    assert_eq!(harness.state().commands, [expected]);
}

#[test]
fn a_file_that_has_not_been_read_does_not_replace_the_scene() {
    let (mut harness, _) = shown();
    harness.state_mut().given.assets.pictures = Arc::default();
    double_click(&mut harness, "red.xml");
    assert_eq!(harness.state().commands, []);
}

#[test]
fn folders_are_entered_and_left() {
    let (mut harness, state) = shown();
    click(&mut harness, "inner");
    assert_eq!(state.lock().expect("one thread").folder, Some("/assets/inner".into()));
    click(&mut harness, "assets");
    assert_eq!(state.lock().expect("one thread").folder, Some("/assets".into()));
    assert_eq!(harness.state().commands, []);
    // The first is in the list already.
    click(&mut harness, "+");
    click(&mut harness, "\u{2212}");
    click(&mut harness, "inner");
    click(&mut harness, "+");
    let expected = [
        Command::Shell(ShellCommand::RemoveAssetFolder("/assets".into())),
        Command::Shell(ShellCommand::AddAssetFolder("/assets/inner".into())),
    ];
    assert_eq!(harness.state().commands, expected);
}

#[test]
fn the_filters_leave_what_is_wanted() {
    let (mut harness, state) = shown();
    let in_sight = || {
        let state = state.lock().expect("one thread");
        state
            .in_sight
            .iter()
            .map(|entry| entry.name.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(
        in_sight(),
        ["bunny.ply", "broken.png", "red.xml", "room.xml", "sky.hdr", "wood.png"]
    );
    harness.get_by_role(egui::accesskit::Role::TextInput).focus();
    harness.run_steps(1);
    harness.get_by_role(egui::accesskit::Role::TextInput).type_text("R");
    harness.run_steps(3);
    assert_eq!(in_sight(), ["broken.png", "red.xml", "room.xml", "sky.hdr"]);
    click(&mut harness, "Kind");
    click(&mut harness, "Environments");
    assert_eq!(in_sight(), ["sky.hdr"]);
}

#[test]
fn the_order_can_be_by_size() {
    let (mut harness, state) = shown();
    click(&mut harness, "Order");
    click(&mut harness, "Largest first");
    let state = state.lock().expect("one thread");
    let names: Vec<&str> = state.in_sight.iter().map(|entry| entry.name.as_str()).collect();
    assert_eq!(
        names,
        ["wood.png", "sky.hdr", "room.xml", "red.xml", "broken.png", "bunny.ply"]
    );
}
