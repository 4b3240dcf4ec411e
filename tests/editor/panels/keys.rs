//! The list where keys are chosen.

use bevy_egui::egui::accesskit::Role;
use bevy_egui::egui::{Key, Modifiers, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::key_bindings::KeyBindings;
use sunroom::app::editor::command::shortcut::Shortcut;
use sunroom::app::editor::command::{Command, FileCommand, HistoryCommand};
use sunroom::app::editor::input::actions::{self, ActionContext};
use sunroom::app::editor::input::keys::shortcuts;
use sunroom::app::editor::input::press::Press;
use sunroom::app::editor::panels::key_bindings::{KeyList, key_bindings};

use super::click;
use crate::support::presses;

#[derive(Default)]
struct Keys {
    list: KeyList,
    bound: KeyBindings,
}

fn list() -> Harness<'static, Keys> {
    let mut harness = Harness::builder().with_size(vec2(520.0, 3600.0)).build_ui_state(
        |ui, keys: &mut Keys| {
            let presses = presses(ui);
            if let Some(chosen) = key_bindings(ui, &mut keys.list, &keys.bound, &presses) {
                keys.bound = chosen;
            }
        },
        Keys::default(),
    );
    harness.run_steps(3);
    harness
}

fn choose(harness: &mut Harness<Keys>, label: &str, modifiers: Modifiers, key: Key) {
    // The field for the search narrows the list to what is in sight.
    harness.state_mut().list = KeyList::searching(label);
    harness.run_steps(2);
    click(harness, &format!("{label} key"));
    assert!(harness.state().list.waits());
    harness.key_press_modifiers(modifiers, key);
    harness.run_steps(3);
    assert!(!harness.state().list.waits());
}

fn key_of(harness: &Harness<Keys>, name: &str) -> String {
    actions::key_text(name, &harness.state().bound)
}

/// What a press does with the chosen keys.
fn pressed(harness: &Harness<Keys>, modifiers: Modifiers, key: Key) -> Vec<Command> {
    let press = Press {
        key,
        modifiers,
        numpad: false,
    };
    let selection = Default::default();
    let context = ActionContext {
        bound: &harness.state().bound,
        ..ActionContext::new(&selection)
    };
    shortcuts(&[press], &context)
}

#[test]
fn a_press_becomes_the_key_of_an_action() {
    let mut harness = list();
    choose(&mut harness, "Undo", Modifiers::COMMAND, Key::U);
    assert_eq!(key_of(&harness, "undo"), "Ctrl+U");
    assert_eq!(
        pressed(&harness, Modifiers::COMMAND, Key::U),
        [Command::from(HistoryCommand::Undo)]
    );
    assert_eq!(pressed(&harness, Modifiers::COMMAND, Key::Z), []);
    click(&mut harness, "Reset");
    assert_eq!(key_of(&harness, "undo"), "Ctrl+Z");
}

#[test]
fn a_key_of_another_action_is_said_and_exchanged_if_wanted() {
    let mut harness = list();
    choose(&mut harness, "Undo", Modifiers::COMMAND, Key::S);
    assert!(harness.query_by_label_contains("is the key of").is_some());
    assert_eq!(key_of(&harness, "undo"), "Ctrl+Z");
    click(&mut harness, "Leave both");
    assert!(harness.state().bound.is_empty());
    choose(&mut harness, "Undo", Modifiers::COMMAND, Key::S);
    click(&mut harness, "Swap");
    assert_eq!(
        (key_of(&harness, "undo"), key_of(&harness, "save")),
        ("Ctrl+S".into(), "Ctrl+Z".into())
    );
    assert_eq!(
        pressed(&harness, Modifiers::COMMAND, Key::Z),
        [Command::from(FileCommand::Save)]
    );
    click(&mut harness, "Reset all");
    assert!(harness.state().bound.is_empty());
}

#[test]
fn keys_of_the_clipboard_are_refused_and_escape_leaves_the_key() {
    let mut harness = list();
    choose(&mut harness, "Undo", Modifiers::COMMAND, Key::C);
    assert!(harness.query_by_label_contains("always copies").is_some());
    choose(&mut harness, "Undo", Modifiers::NONE, Key::Escape);
    assert!(harness.state().bound.is_empty());
}

#[test]
fn flying_takes_keys_too() {
    let mut harness = list();
    choose(&mut harness, "Fly ahead", Modifiers::SHIFT, Key::J);
    let j = Shortcut::plain(Key::J);
    assert_eq!(harness.state().bound.of("fly-ahead"), Some(&[j][..]));
}

#[test]
fn what_is_typed_into_the_search_is_no_key() {
    let mut harness = list();
    harness.state_mut().list = KeyList::searching("Undo");
    harness.run_steps(2);
    click(&mut harness, "Undo key");
    assert!(harness.state().list.waits());
    harness.get_by_role(Role::TextInput).focus();
    harness.run_steps(2);
    assert!(!harness.state().list.waits());
}
