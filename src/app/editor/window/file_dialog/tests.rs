//! Drives the dialog without a window.

use bevy_egui::egui::Modifiers;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};

use super::*;
use crate::app::editor::command::{Command, FileCommand};
use crate::app::editor::window::unsaved_question::{UnsavedQuestion, UnsavedState};

const SCENES: &[&str] = &["xml"];
const PICTURES: &[(&str, &str)] = &[("PNG", "png"), ("EXR", "exr")];

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("inner")).expect("a folder");
    std::fs::write(folder.path().join("room.xml"), "<scene/>").expect("a file");
    std::fs::write(folder.path().join("room.png"), "").expect("a file");
    folder
}

#[test]
fn a_folder_is_entered_and_a_file_is_picked() {
    let folder = folder();
    let mut dialog = FileDialog::new("", Purpose::Open(SCENES), folder.path().to_path_buf(), Vec::new());
    assert_eq!(dialog.accept("inner"), None);
    assert_eq!(dialog.folder, folder.path().join("inner"));
    assert_eq!(dialog.accept(".."), None);
    assert_eq!(dialog.folder, folder.path());
    assert_eq!(dialog.accept("none.xml"), None);
    let picked = Outcome::Picked(folder.path().join("room.xml"));
    assert_eq!(dialog.accept("room.xml"), Some(picked));
}

#[test]
fn a_saved_file_has_an_extension_and_another_one_is_replaced_only_after_a_question() {
    let folder = folder();
    let purpose = Purpose::Save(PICTURES, "room.png".to_owned());
    let mut dialog = FileDialog::new("", purpose, folder.path().to_path_buf(), Vec::new());
    assert_eq!(dialog.accept("room"), None);
    assert_eq!(dialog.replaces, Some(folder.path().join("room.png")));
    let picked = |name: &str| Some(Outcome::Picked(folder.path().join(name)));
    assert_eq!(dialog.accept("new"), picked("new.png"));
    assert_eq!(dialog.accept("new.EXR"), picked("new.EXR"));
    assert_eq!(dialog.accept("a.b"), picked("a.b.png"));
    assert_eq!(dialog.accept("inner/deep.exr"), picked("inner/deep.exr"));
}

#[test]
fn a_second_file_is_asked_about_as_well() {
    let folder = folder();
    let purpose = Purpose::Save(PICTURES, "scene.exr".to_owned());
    let dialog = FileDialog::new("", purpose, folder.path().to_path_buf(), Vec::new());
    let mut dialog = dialog.with_second(|path| (path.extension()? == "exr").then(|| path.with_file_name("room.png")));
    assert_eq!(
        dialog.accept("scene"),
        Some(Outcome::Picked(folder.path().join("scene.png")))
    );
    let exr = folder.path().join("scene.exr");
    assert_eq!(dialog.accept("scene.exr"), None);
    assert_eq!(dialog.lost_with(&exr), [folder.path().join("room.png")]);
    std::fs::write(&exr, "").expect("a file");
    assert_eq!(dialog.lost_with(&exr), [exr.clone(), folder.path().join("room.png")]);
    assert_eq!(dialog.replaces, Some(exr));
}

type Shown = Harness<'static, (FileDialog, Option<Outcome>)>;

/// A dialog that has been shown, and its outcome.
fn shown(purpose: Purpose, folder: &Path) -> Shown {
    let dialog = FileDialog::new("", purpose, folder.to_path_buf(), Vec::new());
    let show = |ui: &mut Ui, (dialog, end): &mut (FileDialog, Option<Outcome>)| {
        if end.is_none() {
            let outcome = dialog.show(ui.ctx());
            *end = Some(outcome).filter(|outcome| *outcome != Outcome::Open);
        }
    };
    let mut harness = Harness::builder()
        .with_size(egui::vec2(1000.0, 700.0))
        .build_ui_state(show, (dialog, None));
    harness.run_steps(3);
    while harness.state().0.reading.is_some() {
        harness.run_steps(1);
    }
    harness
}

fn saving(name: &str, folder: &Path) -> Shown {
    shown(Purpose::Save(PICTURES, name.to_owned()), folder)
}

fn press(harness: &mut Shown, key: Key) {
    harness.key_press(key);
    harness.run_steps(3);
}

fn click(harness: &mut Shown, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(3);
}

#[test]
fn a_folder_is_the_one_that_is_shown_or_the_one_that_is_chosen_in_it() {
    let folder = folder();
    let mut harness = shown(Purpose::Folder, folder.path());
    assert!(harness.query_by_label("room.xml").is_none(), "files are left out");
    click(&mut harness, "Use this folder");
    let picked = |path: &Path| Some(Outcome::Picked(path.to_owned()));
    assert_eq!(harness.state().1, picked(folder.path()));
    let mut harness = shown(Purpose::Folder, folder.path());
    click(&mut harness, "inner");
    click(&mut harness, "Use this folder");
    assert_eq!(harness.state().1, picked(&folder.path().join("inner")));
}

#[test]
fn enter_is_for_the_focused_button() {
    let folder = folder();
    let mut harness = saving("new.png", folder.path());
    press(&mut harness, Key::Enter);
    let written = Outcome::Picked(folder.path().join("new.png"));
    assert_eq!(harness.state().1, Some(written));
    let mut harness = saving("new.png", folder.path());
    harness.get_by_label("Cancel").focus();
    harness.run_steps(3);
    press(&mut harness, Key::Enter);
    assert_eq!(harness.state().1, Some(Outcome::Cancelled));
    let mut harness = saving("new.png", folder.path());
    harness.get_by_label("Hidden").focus();
    harness.run_steps(3);
    press(&mut harness, Key::Enter);
    assert!(harness.state().0.filter.shows_hidden);
    assert_eq!(harness.state().1, None);
}

#[test]
fn enter_in_the_search_opens_what_is_found() {
    let folder = folder();
    let mut harness = shown(Purpose::Open(SCENES), folder.path());
    harness.event(egui::Event::Text("oo".to_owned()));
    harness.run_steps(3);
    press(&mut harness, Key::Enter);
    let found = Outcome::Picked(folder.path().join("room.xml"));
    assert_eq!(harness.state().1, Some(found));
}

#[test]
fn enter_in_the_search_waits_for_a_slow_folder() {
    let folder = folder();
    let mut harness = shown(Purpose::Open(SCENES), folder.path());
    let dialog = &mut harness.state_mut().0;
    let listed = (std::mem::take(&mut dialog.entries), None);
    let (sender, receiver) = crossbeam_channel::bounded(1);
    (dialog.reading, dialog.shown_for) = (Some(receiver), None);
    harness.event(egui::Event::Text("oo".to_owned()));
    harness.step();
    press(&mut harness, Key::Enter);
    assert_eq!(harness.state().1, None);
    sender.send(listed).expect("the dialog waits");
    harness.run_steps(3);
    let found = Outcome::Picked(folder.path().join("room.xml"));
    assert_eq!(harness.state().1, Some(found));
}

#[test]
fn a_path_in_the_search_is_a_path() {
    let folder = folder();
    std::fs::write(folder.path().join("inner/deep.xml"), "<scene/>").expect("a file");
    let other = self::folder();
    let deep = folder.path().join("inner/deep.xml");
    // All at once, as it is pasted, and letter by letter, from the folder.
    for (shown_in, typed) in [
        (other.path(), vec![deep.display().to_string()]),
        (
            folder.path(),
            ["inner", "/", "deep", ".xml"].map(str::to_owned).to_vec(),
        ),
    ] {
        let mut harness = shown(Purpose::Open(SCENES), shown_in);
        for part in &typed {
            harness.event(egui::Event::Text(part.clone()));
            harness.run_steps(3);
        }
        let dialog = &harness.state().0;
        assert_eq!((dialog.filter.part.as_str(), &dialog.path), ("", &Some(typed.concat())));
        press(&mut harness, Key::Enter);
        assert_eq!(harness.state().1, Some(Outcome::Picked(deep.clone())));
    }
    let mut harness = shown(Purpose::Open(SCENES), other.path());
    harness.event(egui::Event::Text(format!("{}/", folder.path().display())));
    harness.run_steps(3);
    press(&mut harness, Key::Enter);
    assert_eq!(
        (harness.state().0.folder.as_path(), &harness.state().1),
        (folder.path(), &None)
    );
    // In a dialog that saves it is the name.
    let mut harness = saving("new.png", other.path());
    let mut fields = harness.get_all_by_role(egui::accesskit::Role::TextInput);
    fields.nth(1).expect("the search").click();
    drop(fields);
    harness.run_steps(3);
    let new = folder.path().join("inner/new.exr");
    harness.event(egui::Event::Text(new.display().to_string()));
    harness.run_steps(3);
    assert_eq!(harness.state().0.name, new.display().to_string());
    press(&mut harness, Key::Enter);
    assert_eq!(harness.state().1, Some(Outcome::Picked(new)));
}

#[test]
fn the_button_opens_a_path_that_was_typed() {
    let folder = folder();
    std::fs::write(folder.path().join("inner/deep.xml"), "<scene/>").expect("a file");
    let mut harness = shown(Purpose::Open(SCENES), folder.path());
    assert!(harness.get_by_label("Open").accesskit_node().is_disabled());
    harness.event(egui::Event::Text("inner/deep.xml".to_owned()));
    harness.run_steps(3);
    harness.get_by_label("Open").click();
    harness.run_steps(3);
    let deep = folder.path().join("inner/deep.xml");
    assert_eq!(harness.state().1, Some(Outcome::Picked(deep)));
    // A click in the list chooses another file.
    let mut harness = shown(Purpose::Open(SCENES), folder.path());
    harness.event(egui::Event::Text("inner/deep.xml".to_owned()));
    harness.run_steps(3);
    harness.get_by_label("room.xml").click();
    harness.run_steps(3);
    assert_eq!(harness.state().0.path, None);
    harness.get_by_label("Open").click();
    harness.run_steps(3);
    assert_eq!(harness.state().1, Some(Outcome::Picked(folder.path().join("room.xml"))));
}

#[test]
fn a_path_to_nothing_is_kept_with_the_list() {
    let folder = folder();
    let mut harness = shown(Purpose::Open(SCENES), folder.path());
    harness.event(egui::Event::Text("./wrong.xml".to_owned()));
    harness.run_steps(3);
    press(&mut harness, Key::Enter);
    let wrong = folder.path().join("./wrong.xml").display().to_string();
    assert!(harness.query_by_label(&format!("There is no {wrong}")).is_some());
    assert!(harness.query_by_label("room.xml").is_some());
    let (dialog, end) = harness.state();
    assert_eq!((dialog.path.as_ref(), end), (Some(&wrong), &None));
    // The path field still has the keyboard.
    for _ in 0.."wrong.xml".len() {
        press(&mut harness, Key::Backspace);
    }
    harness.event(egui::Event::Text("room.xml".to_owned()));
    harness.run_steps(3);
    press(&mut harness, Key::Enter);
    assert_eq!(harness.state().1, Some(Outcome::Picked(folder.path().join("room.xml"))));
}

#[test]
fn the_question_before_replacing_is_for_the_file_that_was_named() {
    let folder = folder();
    std::fs::write(folder.path().join("other.png"), "").expect("a file");
    let question = "room.png is there already (";
    let mut harness = saving("room.png", folder.path());
    press(&mut harness, Key::Enter);
    assert!(harness.query_by_label_contains(question).is_some());
    click(&mut harness, "other.png");
    assert!(harness.query_by_label_contains(question).is_none());
    assert_eq!(
        (harness.state().0.name.as_str(), &harness.state().1),
        ("other.png", &None)
    );
    press(&mut harness, Key::Enter);
    assert!(harness.query_by_label("Replace").is_some());
    click(&mut harness, "⬆");
    assert!(harness.query_by_label("Replace").is_none());
    assert_eq!(harness.state().1, None);
}

#[test]
fn the_list_stays_where_a_folder_cannot_be_made() {
    let folder = folder();
    let mut harness = saving("new.png", folder.path());
    click(&mut harness, "New folder");
    harness.event(egui::Event::Text("inner".to_owned()));
    harness.run_steps(3);
    press(&mut harness, Key::Enter);
    let problem = harness.state().0.problem.clone().expect("the folder is there already");
    assert!(harness.query_by_label(&problem).is_some() && harness.query_by_label("room.png").is_some());
    assert_eq!(harness.state().1, None);
}

#[test]
fn another_format_leaves_the_name() {
    let folder = folder();
    let mut harness = saving("room v1.2", folder.path());
    for (format, expected) in [("EXR", "room v1.2.exr"), ("PNG", "room v1.2.png")] {
        harness.get_by_role(egui::accesskit::Role::ComboBox).click();
        harness.run_steps(3);
        click(&mut harness, format);
        assert_eq!(harness.state().0.name, expected);
    }
}

#[test]
fn enter_in_the_dialog_does_not_answer_the_question_that_follows() {
    struct Window {
        dialog: Option<FileDialog>,
        question: UnsavedQuestion,
        said: Vec<Command>,
    }
    let show = |ui: &mut Ui, window: &mut Window| {
        let context = ui.ctx().clone();
        let mut commands = Vec::new();
        let outcome = window.dialog.as_mut().map(|dialog| dialog.show(&context));
        if let Some(Outcome::Picked(path)) = outcome {
            window.dialog = None;
            commands.push(FileCommand::OpenScene(path).into());
        }
        window.question.hold(&mut commands, true);
        let unsaved = UnsavedState {
            name: "room.xml",
            path: None,
            saved: None,
            edits: true,
            dialog_open: false,
            saves_handled: 0,
        };
        window.question.show(&context, unsaved, &mut commands);
        window.said.append(&mut commands);
    };
    let folder = folder();
    let key = |pressed| egui::Event::Key {
        key: Key::Enter,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers: Modifiers::NONE,
    };
    // With letters in the search, and with a path.
    for (typed, is_path) in [
        ("oo".to_owned(), false),
        (folder.path().join("room.xml").display().to_string(), true),
    ] {
        let dialog = FileDialog::new("", Purpose::Open(SCENES), folder.path().to_path_buf(), Vec::new());
        let window = Window {
            dialog: Some(dialog),
            question: UnsavedQuestion::default(),
            said: Vec::new(),
        };
        let mut harness = Harness::builder()
            .with_size(egui::vec2(1000.0, 700.0))
            .build_ui_state(show, window);
        harness.run_steps(5);
        let is_reading = |window: &Window| window.dialog.as_ref().is_some_and(|dialog| dialog.reading.is_some());
        while is_reading(harness.state()) {
            harness.run_steps(1);
        }
        if is_path {
            let mut fields = harness.get_all_by_role(egui::accesskit::Role::TextInput);
            fields.next().expect("the path").click();
            drop(fields);
            harness.run_steps(3);
            harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
        }
        harness.event(egui::Event::Text(typed));
        harness.run_steps(3);
        harness.event(key(true));
        harness.run_steps(6);
        assert!(harness.state().dialog.is_none(), "a file was chosen");
        assert!(harness.state().question.is_asking() && harness.state().said.is_empty());
        harness.event(key(false));
        harness.run_steps(2);
        harness.event(key(true));
        harness.run_steps(2);
        assert_eq!(harness.state().said, [Command::from(FileCommand::Save)]);
    }
}
