//! The list of all keys, where they can be changed: a click, then a key press.

use bevy_egui::egui::{self, Key, RichText, Ui};

use super::look;
use crate::app::editor::command::key_bindings::KeyBindings;
use crate::app::editor::command::shortcut::Shortcut;
use crate::app::editor::input::actions::Group;
use crate::app::editor::input::actions::bindings::{Bindable, bind, bindables, owners, reserved};
use crate::app::editor::input::press::Press;

/// The width of the columns of names and of keys, in points.
const COLUMNS: [f32; 2] = [244.0, 160.0];
/// The width of the last column: *Reset*, or the cross that removes a key.
const LAST: f32 = 48.0;
/// The height of the list, in points.
const HEIGHT: f32 = 320.0;

/// The state of the list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KeyList {
    query: String,
    /// The action that waits for its key.
    waiting: Option<&'static str>,
    /// The reason why the last press was not accepted; None if it was.
    answer: Option<Answer>,
}

/// The reason why a press was not accepted.
#[derive(Clone, Debug, PartialEq)]
enum Answer {
    /// The key has a fixed meaning.
    Refused { key: Shortcut, what: &'static str },
    /// The key is that of other actions.
    Taken {
        name: &'static str,
        key: Shortcut,
        others: Vec<&'static str>,
    },
}

impl KeyList {
    /// A list that shows the entries whose names contain `query`.
    pub fn searching(query: &str) -> Self {
        Self {
            query: query.to_owned(),
            ..Self::default()
        }
    }

    /// Whether the next press chooses a key: then no other widget may use it.
    pub fn waits(&self) -> bool {
        self.waiting.is_some()
    }
}

/// Shows the list. Returns the new keys if some were chosen or reset. `presses` are those of this frame.
pub fn key_bindings(ui: &mut Ui, state: &mut KeyList, bound: &KeyBindings, presses: &[Press]) -> Option<KeyBindings> {
    let mut edited = bound.clone();
    if let (Some(name), Some(press)) = (state.waiting, presses.first()) {
        state.waiting = None;
        take(state, name, press, &mut edited);
    }
    ui.horizontal(|ui| {
        let search = egui::TextEdit::singleline(&mut state.query)
            .hint_text("Search by name or key")
            .desired_width(COLUMNS[0]);
        if ui.add(search).gained_focus() {
            // While the user types into the search field, presses choose no key.
            state.waiting = None;
        }
        let reset = ui.add_enabled(!edited.is_empty(), egui::Button::new("Reset all"));
        if reset.on_hover_text("All keys as in the beginning").clicked() {
            edited = KeyBindings::default();
            state.answer = None;
        }
    });
    answer(ui, state, &mut edited);
    ui.separator();
    egui::ScrollArea::vertical()
        .max_height(HEIGHT)
        .auto_shrink([false, false])
        .show(ui, |ui| list(ui, state, &mut edited));
    (edited != *bound).then_some(edited)
}

/// Whether the entry is a key of flying.
fn flies(name: &str) -> bool {
    bindables().any(|own| own.name == name && own.is_held())
}

/// Binds the key of a press to an action, unless the key has a meaning already.
fn take(state: &mut KeyList, name: &'static str, press: &Press, edited: &mut KeyBindings) {
    state.answer = None;
    if press.key == Key::Escape {
        return;
    }
    let key = match flies(name) {
        true => Shortcut::plain(press.key),
        false => press.shortcut(),
    };
    if let Some(what) = reserved(&key) {
        state.answer = Some(Answer::Refused { key, what });
        return;
    }
    let others: Vec<&str> = owners(&key, name, edited).iter().map(|other| other.label).collect();
    match others.is_empty() {
        true => bind(edited, name, key),
        false => state.answer = Some(Answer::Taken { name, key, others }),
    }
}

/// Shows the reason why a key was not accepted.
fn answer(ui: &mut Ui, state: &mut KeyList, edited: &mut KeyBindings) {
    let Some(answer) = state.answer.clone() else {
        let text = match state.waiting {
            Some(name) if flies(name) => {
                "Press the new key. It counts without Shift and Ctrl, which fly fast and slowly. Esc: leave it as it is"
            }
            Some(_) => "Press the new key, with the modifiers that you want. Esc: leave it as it is",
            None => "Click a key to choose another one",
        };
        ui.weak(text);
        return;
    };
    let warning = ui.visuals().warn_fg_color;
    match answer {
        Answer::Refused { key, what } => {
            ui.colored_label(warning, format!("{} always {what}.", key.text()));
        }
        Answer::Taken { name, key, others } => {
            let others: Vec<String> = others.iter().map(|other| format!("\u{201c}{other}\u{201d}")).collect();
            let wanted = bindables().find(|own| own.name == name).map_or(name, |own| own.label);
            // Long names take a second line, and the buttons stay visible.
            ui.horizontal_wrapped(|ui| {
                let others = others.join(" and ");
                let text = format!("\u{201c}{wanted}\u{201d}: {} is the key of {others}.", key.text());
                ui.colored_label(warning, text);
                if ui
                    .add(look::primary(ui, "Swap"))
                    .on_hover_text("The other one gets the key that this one had")
                    .clicked()
                {
                    bind(edited, name, key);
                    state.answer = None;
                }
                if ui.button("Leave both").clicked() {
                    state.answer = None;
                }
            });
        }
    }
}

fn list(ui: &mut Ui, state: &mut KeyList, edited: &mut KeyBindings) {
    let query = state.query.trim().to_lowercase();
    let text = |own: &Bindable, edited: &KeyBindings| {
        let keys: Vec<String> = own.keys(edited).iter().map(Shortcut::text).collect();
        keys.join(", ")
    };
    let mut group = Some("");
    for own in bindables() {
        let keys = text(&own, edited);
        let found = [own.label, own.name, &keys]
            .iter()
            .any(|text| text.to_lowercase().contains(&query));
        if !found {
            continue;
        }
        let title = own.group.map_or("Flying", Group::title);
        if group != Some(title) {
            group = Some(title);
            ui.add_space(4.0);
            ui.strong(title);
        }
        ui.push_id(own.name, |ui| row(ui, &own, &keys, state, edited));
    }
}

fn row(ui: &mut Ui, own: &Bindable, keys: &str, state: &mut KeyList, edited: &mut KeyBindings) {
    ui.horizontal(|ui| {
        let height = ui.spacing().interact_size.y;
        let size = egui::vec2(COLUMNS[0], height);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let cell = ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_size(size);
            ui.add(egui::Label::new(own.label).truncate())
        });
        let name = cell.inner;
        let waits = state.waiting == Some(own.name);
        let text = match (waits, keys) {
            (true, _) => RichText::new("press a key\u{2026}").weak(),
            (false, "") => RichText::new("none").weak(),
            (false, keys) => RichText::new(keys),
        };
        let button = egui::Button::selectable(waits, text)
            .frame_when_inactive(true)
            .truncate();
        let button = ui.add_sized([COLUMNS[1], height], button).labelled_by(name.id);
        button.widget_info(|| {
            let label = format!("{} key", own.label);
            egui::WidgetInfo::labeled(egui::WidgetType::Button, true, label)
        });
        if button.clicked() {
            state.waiting = (!waits).then_some(own.name);
            state.answer = None;
            // A text field would get the press as well.
            ui.memory_mut(|memory| memory.stop_text_input());
        }
        if edited.of(own.name).is_some() {
            let reset = ui
                .add_sized([LAST, height], egui::Button::new("Reset"))
                .on_hover_text("The key as in the beginning");
            if reset.clicked() {
                edited.reset(own.name);
            }
        } else if !own.keys(edited).is_empty() {
            let none = ui.add_sized([LAST, height], egui::Button::new("\u{00d7}"));
            if none.on_hover_text("No key").clicked() {
                edited.set(own.name, Vec::new());
            }
        }
    });
}
