//! Shows the overview of keys and of the mouse.

use bevy_egui::egui::{self, Id, Key, Modal, Modifiers, RichText, Ui};

use crate::app::editor::input::actions::{ACTIONS, Action, Group, Shortcut};

/// Controls that are no actions: held keys, and the mouse.
const CONTROLS: [(&str, &str); 19] = [
    ("W A S D", "Fly"),
    ("Q E", "Fly down and up"),
    ("Shift, Ctrl", "while flying: fast, slow"),
    ("Right drag", "Look around"),
    ("Left drag", "Look, or drag a handle"),
    ("Alt+Left drag", "Orbit the selection"),
    ("Middle drag", "Pan"),
    ("Wheel", "Towards the pointer"),
    ("Right+Wheel", "Flying speed"),
    ("Click", "Select"),
    ("Shift+Click", "Add or take away"),
    ("Ctrl+Click", "Add or take away"),
    ("Shift+Left drag", "Add what shows in the box"),
    ("Ctrl in a drag", "Round to the step"),
    ("Shift in a drag", "Onto the surface"),
    ("G R T, X, 1.5", "By a number along an axis"),
    ("1 to 9", "Back to a stored view"),
    ("Ctrl+1 to 9", "Store the view"),
    ("Ctrl +, -, 0", "Size of the panels"),
];

/// The number of lines in a column.
const COLUMN: usize = 27;
/// The width of a column. Four of them fit into a window of 1280 points.
const COLUMN_WIDTH: f32 = 260.0;
/// The size of the letters, in points.
const KEY_SIZE: f32 = 11.5;

type Lines = Vec<(String, &'static str)>;

/// The headings with their lines, a list for each column.
fn columns() -> Vec<Vec<(&'static str, Lines)>> {
    let controls = CONTROLS.iter().map(|(keys, what)| ((*keys).to_owned(), *what));
    let mut groups: Vec<(&str, Lines)> = vec![("Mouse and flying", controls.collect())];
    groups.extend(Group::ALL.into_iter().map(|(group, name)| {
        let actions = ACTIONS
            .iter()
            .filter(|action| action.group == group && !action.keys.is_empty() && !is_of_a_series(action));
        let lines = actions.map(|action| (keys(action), action.label));
        (name, lines.collect())
    }));
    groups.push(("Clipboard", clipboard()));
    // Each where there is still room for it.
    let mut columns: Vec<Vec<(&str, Lines)>> = Vec::new();
    for group in groups.into_iter().filter(|(_, lines)| !lines.is_empty()) {
        let height = |column: &Vec<(&str, Lines)>| column.iter().map(|(_, lines)| lines.len() + 2).sum::<usize>();
        let fits = |column: &&mut Vec<(&str, Lines)>| height(column) + group.1.len() + 2 <= COLUMN;
        match columns.iter_mut().find(fits) {
            Some(column) => column.push(group),
            None => columns.push(vec![group]),
        }
    }
    columns
}

/// The keys of an action. Those of the numeric keypad are left out if there are others.
fn keys(action: &Action) -> String {
    let all: Vec<String> = action.keys.iter().map(Shortcut::text).collect();
    let is_plain = |text: &&String| !text.contains("Numpad");
    let plain: Vec<&str> = all.iter().filter(is_plain).map(String::as_str).collect();
    if plain.is_empty() {
        all.join(", ")
    } else {
        plain.join(", ")
    }
}

/// Whether the action is one of the nine stored views, which are listed together.
fn is_of_a_series(action: &Action) -> bool {
    action.name.ends_with(|c: char| c.is_ascii_digit())
}

fn clipboard() -> Lines {
    [("Ctrl+C", "Copy"), ("Ctrl+X", "Cut"), ("Ctrl+V", "Paste")]
        .map(|(keys, what)| (keys.to_owned(), what))
        .into()
}

/// Shows the overview; false when it is to be closed.
pub fn shortcuts(context: &egui::Context) -> bool {
    let closing = [
        (Modifiers::NONE, Key::F1),
        (Modifiers::NONE, Key::Questionmark),
        (Modifiers::SHIFT, Key::Questionmark),
    ];
    let closes = context.input_mut(|input| {
        closing
            .iter()
            .any(|(modifiers, key)| input.consume_key(*modifiers, *key))
    });
    let modal = Modal::new(Id::new("shortcuts")).show(context, |ui| {
        let columns = columns();
        let room = ui.ctx().content_rect().size() - egui::vec2(60.0, 100.0);
        let gap = ui.spacing().item_spacing.x;
        ui.set_width(room.x.min(columns.len() as f32 * (COLUMN_WIDTH + gap)));
        egui::ScrollArea::both()
            .max_width(room.x)
            .max_height(room.y)
            .show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    for (place, groups) in columns.iter().enumerate() {
                        ui.push_id(place, |ui| column(ui, groups));
                    }
                });
            });
        ui.separator();
        ui.weak("Everything else is found by name with Ctrl+P. Esc closes this.");
    });
    !(closes || modal.should_close())
}

fn column(ui: &mut Ui, groups: &[(&str, Lines)]) {
    ui.vertical(|ui| {
        ui.set_width(COLUMN_WIDTH);
        for (name, lines) in groups {
            ui.strong(*name);
            egui::Grid::new(name)
                .num_columns(2)
                .min_col_width(92.0)
                .spacing(egui::vec2(8.0, 3.0))
                .show(ui, |ui| {
                    for (keys, what) in lines {
                        ui.label(RichText::new(keys).monospace().size(KEY_SIZE));
                        ui.label(RichText::new(*what).size(KEY_SIZE));
                        ui.end_row();
                    }
                });
            ui.add_space(10.0);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_in_it() {
        let shown: Vec<String> = columns()
            .into_iter()
            .flatten()
            .flat_map(|(_, lines)| lines)
            .map(|(keys, _)| keys)
            .collect();
        let alone = ACTIONS.iter().filter(|action| !is_of_a_series(action));
        for action in alone.filter(|action| !action.keys.is_empty()) {
            assert!(shown.contains(&keys(action)), "{}", action.name);
        }
    }
}
