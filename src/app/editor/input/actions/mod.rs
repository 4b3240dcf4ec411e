//! The table of actions, each of which is one key, one menu entry or one word. The keyboard, the menus, the palette,
//! the overview of shortcuts and scripts share it.

mod action;
mod arrange;
pub mod bindings;
mod table;
mod time;
mod view;

pub use action::{Action, ActionContext, Group};

use crate::app::editor::command::key_bindings::KeyBindings;
pub use crate::app::editor::command::shortcut::Shortcut;

/// All actions, in the order of the menus.
pub const ACTIONS: &[Action] = &joined::<{ count(MENUS) }>(MENUS);

/// The rows of each menu.
const MENUS: &[&[Action]] = &[
    table::FILE,
    table::EDIT,
    table::ADD,
    arrange::ACTIONS,
    arrange::ALIGN,
    arrange::ALIGN_WITH_ACTIVE,
    arrange::DISTRIBUTE,
    view::ACTIONS,
    time::ACTIONS,
    table::RENDER,
    table::WINDOW,
];

const fn count(menus: &[&[Action]]) -> usize {
    let (mut count, mut menu) = (0, 0);
    while menu < menus.len() {
        count += menus[menu].len();
        menu += 1;
    }
    count
}

const fn joined<const ALL: usize>(menus: &[&[Action]]) -> [Action; ALL] {
    let mut all = [menus[0][0]; ALL];
    let (mut place, mut menu) = (0, 0);
    while menu < menus.len() {
        let mut row = 0;
        while row < menus[menu].len() {
            all[place] = menus[menu][row];
            place += 1;
            row += 1;
        }
        menu += 1;
    }
    all
}

/// The action of this name.
pub fn find(name: &str) -> Option<&'static Action> {
    ACTIONS.iter().find(|action| action.name == name)
}

/// The text of the first key of the action with this name; empty without one.
pub fn key_text(name: &str, bound: &KeyBindings) -> String {
    find(name).map(|action| action.key_text(bound)).unwrap_or_default()
}

/// A tool tip with the key of the action behind it, such as `Samples are kept (Space)`.
pub fn hint(text: &str, name: &str, bound: &KeyBindings) -> String {
    match key_text(name, bound) {
        key if key.is_empty() => text.to_owned(),
        key => format!("{text} ({key})"),
    }
}
