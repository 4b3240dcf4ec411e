//! Drives the start page and the tutorial without a window.

use std::path::Path;

use bevy_egui::egui::{self, Rect, pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::preferences::Preferences;
use sunroom::app::editor::command::recovery_offer::{Note, Offer};
use sunroom::app::editor::command::samples::SAMPLES;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::{Command, FileCommand, FileDialogKind, ShellCommand, ViewCommand};
use sunroom::app::editor::input::actions::ActionContext;
use sunroom::app::editor::session::tutorial::{LESSONS, Tutorial};
use sunroom::app::editor::window::{start_page, tutorial};
use sunroom::document;
use sunroom::scene::read::read;

use crate::support::presses;

struct Page {
    preferences: Preferences,
    left: Vec<Offer>,
    commands: Vec<Command>,
    is_open: bool,
}

fn page(size: egui::Vec2) -> Harness<'static, Page> {
    page_with(size, &["/scenes/attic.xml"], Vec::new())
}

fn page_with(size: egui::Vec2, recent: &[&str], left: Vec<Offer>) -> Harness<'static, Page> {
    let mut preferences = Preferences::default();
    for file in recent.iter().rev() {
        preferences.note_recent(Path::new(file));
    }
    let page = Page {
        preferences,
        left,
        commands: Vec::new(),
        is_open: true,
    };
    let mut harness = Harness::builder().with_size(size).build_ui_state(
        |ui, page: &mut Page| {
            let selection = Selection::default();
            let context = ActionContext::new(&selection);
            if page.is_open {
                page.is_open = start_page::show(
                    &ui.ctx().clone(),
                    &page.preferences,
                    &page.left,
                    &context,
                    &presses(ui),
                    &mut page.commands,
                );
            }
        },
        page,
    );
    harness.run_steps(4);
    harness
}

fn click<T>(harness: &mut Harness<T>, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(3);
}

#[test]
fn a_file_is_opened_and_the_page_is_gone() {
    let mut harness = page(egui::vec2(1280.0, 720.0));
    harness.get_by_label_contains("attic.xml").click();
    harness.run_steps(3);
    let expected = Command::from(FileCommand::OpenScene("/scenes/attic.xml".into()));
    assert_eq!(
        (&harness.state().commands[..], harness.state().is_open),
        (&[expected][..], false)
    );
}

#[test]
fn recent_files_of_one_name_are_told_apart() {
    let recent = ["/a/rooms/cb.xml", "/b/rooms/cb.xml", "/b/rooms/hut.xml"];
    let mut harness = page_with(egui::vec2(1280.0, 720.0), &recent, Vec::new());
    assert!(harness.query_by_label_contains("a/rooms").is_some());
    harness.get_by_label_contains("b/rooms").click();
    harness.run_steps(3);
    assert_eq!(
        harness.state().commands,
        [Command::from(FileCommand::OpenScene(recent[1].into()))]
    );
}

#[test]
fn the_page_names_the_scenes_that_can_be_recovered() {
    let offer = |name: &str, time| Offer {
        folder: format!("/recovery/{time}").into(),
        note: Note {
            scene: Some(name.into()),
            time,
            ..Note::default()
        },
        ..Offer::default()
    };
    let left: Vec<Offer> = (0..6).map(|time| offer(&format!("/rooms/{time}.xml"), time)).collect();
    let mut harness = page_with(egui::vec2(1280.0, 720.0), &[], left[..1].to_vec());
    assert!(harness.query_by_label("1 scene has unsaved edits").is_some());
    harness.get_by_label_contains("Recover 0.xml").click();
    harness.run_steps(3);
    let asked = Command::Shell(ShellCommand::AskAboutRecovery(left[0].clone()));
    assert_eq!(harness.state().commands, [asked]);
    // The page waits behind the question.
    assert!(harness.state().is_open);
    let mut harness = page_with(egui::vec2(1280.0, 720.0), &[], left);
    assert!(harness.query_by_label("6 scenes have unsaved edits").is_some());
    assert!(harness.query_by_label_contains("Recover 5.xml").is_none());
    click(&mut harness, "All 6…");
    assert_eq!(harness.state().commands, [Command::Shell(ShellCommand::ShowRecovery)]);
}

#[test]
fn keys_of_what_the_page_offers_count_on_it() {
    for (key, command) in [
        (egui::Key::N, Command::from(FileCommand::NewScene)),
        (
            egui::Key::O,
            Command::from(FileCommand::ShowDialog(FileDialogKind::OpenScene)),
        ),
    ] {
        let mut harness = page(egui::vec2(1000.0, 700.0));
        harness.key_press(key);
        harness.run_steps(3);
        assert!(harness.state().commands.is_empty() && harness.state().is_open);
        harness.key_press_modifiers(egui::Modifiers::COMMAND, key);
        harness.run_steps(3);
        assert_eq!(
            (&harness.state().commands[..], harness.state().is_open),
            (&[command][..], false)
        );
    }
}

#[test]
fn the_page_begins_the_tutorial_and_a_new_scene_and_can_be_left_out() {
    for (name, command) in [
        ("Tutorial", Command::Shell(ShellCommand::ShowTutorial(Some(0)))),
        ("New scene", Command::from(FileCommand::NewScene)),
    ] {
        let mut harness = page(egui::vec2(1000.0, 700.0));
        click(&mut harness, name);
        assert_eq!(
            (&harness.state().commands[..], harness.state().is_open),
            (&[command][..], false)
        );
    }
    let mut harness = page(egui::vec2(1280.0, 720.0));
    click(&mut harness, "Show this page when the program starts without a file");
    let Some(Command::Shell(ShellCommand::SetPreferences(edited))) = harness.state().commands.first() else {
        panic!("{:?}", harness.state().commands)
    };
    assert!(!edited.start_page && harness.state().is_open);
    harness.key_press(egui::Key::Escape);
    harness.run_steps(3);
    assert!(!harness.state().is_open);
}

/// The pictures would be those of nothing otherwise.
#[test]
fn all_samples_are_there_and_have_no_errors() {
    for sample in SAMPLES {
        let path = sample.path().expect("the file of a sample");
        let mut document = document::load(&path, &[]).expect("a sample can be read");
        let scene = read(&mut document);
        assert!(!document.diagnostics.has_errors(), "{}", document.diagnostics);
        assert!(!scene.shapes.is_empty(), "{}", sample.file);
        assert!(sample.picture.starts_with(&[0xff, 0xd8]), "{} has no JPEG", sample.file);
    }
}

#[test]
fn a_step_can_be_skipped_done_and_left() {
    let show = |ui: &mut egui::Ui, (shown, commands): &mut (Tutorial, Vec<Command>)| {
        let place = Rect::from_min_max(pos2(0.0, 0.0), pos2(800.0, 600.0));
        tutorial::show(&ui.ctx().clone(), shown, place, commands);
        for command in commands.iter() {
            if let Command::Shell(ShellCommand::ShowTutorial(step)) = command {
                shown.go_to(*step);
            }
        }
        commands.clear();
    };
    let mut begun = Tutorial::default();
    begun.go_to(Some(0));
    let mut harness = Harness::builder()
        .with_size(egui::vec2(800.0, 600.0))
        .build_ui_state(show, (begun, Vec::new()));
    harness.run_steps(3);
    let step = |harness: &Harness<(Tutorial, Vec<Command>)>| harness.state().0.step;
    click(&mut harness, "Skip");
    assert_eq!(step(&harness), Some(1));
    click(&mut harness, "Back");
    assert_eq!(step(&harness), Some(0));
    harness.state_mut().0.note(&Command::from(ViewCommand::FrameAll), true);
    harness.run_steps(2);
    for _ in 1..LESSONS.len() {
        let name = if harness.state().0.done[step(&harness).unwrap_or(0)] {
            "Next"
        } else {
            "Skip"
        };
        click(&mut harness, name);
    }
    assert_eq!(step(&harness), Some(LESSONS.len() - 1));
    click(&mut harness, "Leave");
    assert_eq!(step(&harness), None);
}
