//! Shows the overview of keys and of the mouse.

use bevy_egui::egui::{self, Id, InputState, Key, Modal, Modifiers, RichText, Ui};

use super::dialog;
use crate::app::editor::command::key_bindings::KeyBindings;
use crate::app::editor::command::navigation_preset::NavigationPreset;
use crate::app::editor::input::actions::bindings::FLIGHT;
use crate::app::editor::input::actions::{self, ACTIONS, Action, Group, Shortcut};
use crate::app::editor::input::drags::drags;

/// Controls that are no actions: held keys, and mouse drags.
const CONTROLS: [(&str, &str); 12] = [
    ("Shift, Ctrl", "while flying: fast, slow"),
    ("Wheel", "Towards the pointer"),
    ("Right+Wheel", "Flying speed"),
    ("Click", "Select"),
    ("Shift+Click", "Add or take away"),
    ("Ctrl+Click", "Add or take away"),
    ("Ctrl in a drag", "Round to the step"),
    ("Shift in a drag", "Onto the surface"),
    ("Left drag", "on a handle: drag it"),
    ("1 to 9", "Back to a stored view"),
    ("Ctrl+1 to 9", "Store the view"),
    ("Ctrl +, -, 0", "Size of the panels"),
];

/// The width of a column. Four of them fit into a window of 1280 points.
const COLUMN_WIDTH: f32 = 268.0;
/// The height of a line, in points.
const LINE: f32 = 17.0;
/// The rows of a heading and of the gap after its group.
const AROUND: usize = 2;
/// The size of the letters, in points.
const KEY_SIZE: f32 = 11.5;

type Lines = Vec<(String, &'static str)>;

/// A column of the overview: headings with their lines.
type Column = Vec<(&'static str, Lines)>;

/// The headings with their lines.
fn groups(preset: NavigationPreset, bound: &KeyBindings) -> Column {
    let mut mouse: Lines = drags(preset)
        .iter()
        .map(|rule| (rule.text(), rule.what.label()))
        .collect();
    mouse.extend(flying(bound));
    mouse.extend(CONTROLS.iter().map(|(keys, what)| ((*keys).to_owned(), *what)));
    let mut groups: Vec<(&str, Lines)> = vec![("Mouse and flying", mouse)];
    groups.extend(Group::ALL.into_iter().map(|(group, name)| {
        let actions = ACTIONS.iter().filter(|action| {
            action.group == group && !action.keys_in(bound).is_empty() && !is_of_a_series(action, bound)
        });
        let lines = actions.map(|action| (keys(action, bound), action.label));
        (name, lines.collect())
    }));
    groups.push(("Clipboard", clipboard()));
    groups.retain(|(_, lines)| !lines.is_empty());
    groups
}

/// The groups in at most so many columns, which are as short as possible.
fn columns(groups: &Column, most: usize) -> Vec<Column> {
    let tallest = groups.iter().map(height).max().unwrap_or(0);
    let all: usize = groups.iter().map(height).sum();
    let tried = (tallest..all).map(|height| filled(groups, height));
    tried
        .into_iter()
        .find(|columns| columns.len() <= most)
        .unwrap_or_else(|| vec![groups.clone()])
}

fn height(group: &(&str, Lines)) -> usize {
    group.1.len() + AROUND
}

/// Puts each group into the first column with room for it.
fn filled(groups: &Column, tallest: usize) -> Vec<Column> {
    let mut columns: Vec<Column> = Vec::new();
    for group in groups {
        let fits = |column: &&mut Column| column.iter().map(height).sum::<usize>() + height(group) <= tallest;
        match columns.iter_mut().find(fits) {
            Some(column) => column.push(group.clone()),
            None => columns.push(vec![group.clone()]),
        }
    }
    columns
}

/// The keys of an action, without those of the numeric keypad if there are others.
fn keys(action: &Action, bound: &KeyBindings) -> String {
    let all: Vec<String> = action.keys_in(bound).iter().map(Shortcut::text).collect();
    let is_plain = |text: &&String| !text.contains("Numpad");
    let plain: Vec<&str> = all.iter().filter(is_plain).map(String::as_str).collect();
    if plain.is_empty() {
        all.join(", ")
    } else {
        plain.join(", ")
    }
}

/// The rows about flying and typed amounts, whose keys can be changed.
fn flying(bound: &KeyBindings) -> Lines {
    let [[left, right], [up, down], [ahead, back]] =
        FLIGHT.map(|ways| ways.map(|way| way.keys(bound).first().map(Shortcut::text).unwrap_or_default()));
    let modes = ["gizmo-move", "gizmo-rotate", "gizmo-scale"].map(|name| actions::key_text(name, bound));
    vec![
        (format!("{ahead} {left} {back} {right}"), "Fly"),
        (format!("{down} {up}"), "Fly down and up"),
        (format!("{}, X, 1.5", modes.join(" ")), "By a number along an axis"),
    ]
}

/// Whether the action is one of the nine stored views, which are listed together unless other keys were chosen.
fn is_of_a_series(action: &Action, bound: &KeyBindings) -> bool {
    action.name.ends_with(|c: char| c.is_ascii_digit()) && bound.of(action.name).is_none()
}

fn clipboard() -> Lines {
    [("Ctrl+C", "Copy"), ("Ctrl+X", "Cut"), ("Ctrl+V", "Paste")]
        .map(|(keys, what)| (keys.to_owned(), what))
        .into()
}

/// Shows the overview; returns false when it is to be closed.
pub fn shortcuts(context: &egui::Context, preset: NavigationPreset, bound: &KeyBindings) -> bool {
    let closing = actions::find("shortcuts").map_or(&[][..], |action| action.keys_in(bound));
    let is_pressed_again = |input: &mut InputState| {
        closing.iter().any(|key| {
            let modifiers = Modifiers {
                alt: key.alt,
                ctrl: key.command,
                shift: key.shift,
                command: key.command,
                ..Modifiers::NONE
            };
            // Some keyboards have the question mark without Shift.
            let is_bare = key.key == Key::Questionmark && input.consume_key(Modifiers::NONE, key.key);
            is_bare || input.consume_key(modifiers, key.key)
        })
    };
    let modal = dialog::form(context, Modal::new(Id::new("shortcuts")), |ui| {
        if ui.input_mut(is_pressed_again) {
            ui.close();
        }
        let room = ui.ctx().content_rect().size() - egui::vec2(60.0, 130.0);
        let gap = ui.spacing().item_spacing.x;
        let most = ((room.x + gap) / (COLUMN_WIDTH + gap)).max(1.0) as usize;
        let columns = columns(&groups(preset, bound), most);
        ui.set_width(room.x.min(columns.len() as f32 * (COLUMN_WIDTH + gap) - gap));
        ui.label(RichText::new("Keys and mouse").heading().strong());
        ui.add_space(4.0);
        egui::ScrollArea::vertical().max_height(room.y).show(ui, |ui| {
            ui.spacing_mut().interact_size.y = LINE;
            ui.horizontal_top(|ui| {
                for (place, groups) in columns.iter().enumerate() {
                    ui.push_id(place, |ui| column(ui, groups));
                }
            });
        });
        ui.separator();
        let palette = actions::key_text("palette", bound);
        ui.weak(format!(
            "Everything else is found by name with {palette}. Preferences > Keys changes keys. Esc closes this."
        ));
    });
    !modal.should_close()
}

fn column(ui: &mut Ui, groups: &Column) {
    ui.vertical(|ui| {
        ui.set_width(COLUMN_WIDTH);
        for (name, lines) in groups {
            ui.strong(*name);
            egui::Grid::new(name)
                .num_columns(2)
                .min_col_width(92.0)
                .spacing(egui::vec2(8.0, 0.0))
                .show(ui, |ui| {
                    for (keys, what) in lines {
                        ui.label(RichText::new(keys).monospace().size(KEY_SIZE));
                        ui.label(RichText::new(*what).size(KEY_SIZE));
                        ui.end_row();
                    }
                });
            ui.add_space(0.5 * LINE);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::command::key_bindings::NO_BINDINGS;
    use crate::app::editor::input::actions::bindings::bind;

    fn shown(preset: NavigationPreset, bound: &KeyBindings) -> Lines {
        groups(preset, bound).into_iter().flat_map(|(_, lines)| lines).collect()
    }

    #[test]
    fn every_key_is_in_it() {
        let shown: Vec<String> = shown(NavigationPreset::Sunroom, &NO_BINDINGS)
            .into_iter()
            .map(|(keys, _)| keys)
            .collect();
        let alone = ACTIONS.iter().filter(|action| !is_of_a_series(action, &NO_BINDINGS));
        for action in alone.filter(|action| !action.keys.is_empty()) {
            assert!(shown.contains(&keys(action, &NO_BINDINGS)), "{}", action.name);
        }
    }

    #[test]
    fn the_drags_are_those_of_the_preset() {
        for (preset, orbit) in [
            (NavigationPreset::Sunroom, "Shift+Middle drag"),
            (NavigationPreset::Blender, "Middle drag"),
        ] {
            let line = (orbit.to_owned(), "Orbit the selection");
            assert!(shown(preset, &NO_BINDINGS).contains(&line), "{preset:?}");
        }
    }

    #[test]
    fn groups_are_spread_over_the_columns_that_there_is_room_for() {
        let all = groups(NavigationPreset::Sunroom, &NO_BINDINGS);
        let heights = |most| {
            let columns = columns(&all, most);
            assert!(columns.len() <= most && columns.iter().flatten().count() == all.len());
            columns.iter().map(|column| column.iter().map(height).sum()).max()
        };
        let [one, two, four]: [Option<usize>; 3] = [1, 2, 4].map(heights);
        assert!(one > two && two > four);
        // Four columns are in sight at once in a window of 1280 x 720 points.
        assert!(
            four.is_some_and(|lines| lines as f32 * LINE <= 720.0 - 130.0),
            "{four:?}"
        );
    }

    #[test]
    fn chosen_keys_are_shown() {
        let mut bound = KeyBindings::default();
        bind(&mut bound, "save", Shortcut::parse("F7").expect("a key"));
        bind(&mut bound, "fly-ahead", Shortcut::parse("Y").expect("a key"));
        let shown = shown(NavigationPreset::Sunroom, &bound);
        assert!(shown.contains(&("F7".to_owned(), "Save")));
        assert!(shown.contains(&("Y A S D".to_owned(), "Fly")));
    }
}
