//! The mark beside an animated value, with a menu for its keys.

use std::sync::Arc;

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Sense, Stroke, Ui, vec2};

use super::key_buttons::{key_color, mark};
use crate::app::editor::command::{Command, TimeEdit};
use crate::app::editor::model::timeline::TimelineModel;
use crate::document::Track;
use crate::scene::{KeyEdit, KeyPath};

/// The tag of the rows of a thing's values.
const OWNER: &str = "moving";
/// The width of a mark in points.
const WIDTH: f32 = 12.0;

/// The plugin whose values are in the rows below.
struct Owner {
    thing: Entity,
    /// The path of the plugin within the thing's, with a dot behind it.
    prefix: &'static str,
    /// The key path of the thing's place.
    place: KeyPath,
    tracks: Vec<(KeyPath, Arc<Track>)>,
    time: f64,
}

/// Marks animated values of a thing in the rows of `content`, and offers keys for all.
pub(crate) fn moving<R>(
    ui: &mut Ui,
    model: &TimelineModel,
    (thing, prefix): (Entity, &'static str),
    content: impl FnOnce(&mut Ui) -> R,
) -> R {
    let tracks = model.tracks.get(&thing).cloned().unwrap_or_default();
    let is_place = |(path, _): &&(KeyPath, Arc<Track>)| path.is_place();
    let place = tracks.iter().find(is_place).map(|(path, _)| path.clone());
    let owner = Owner {
        thing,
        prefix,
        place: place.unwrap_or_else(|| KeyPath::new("to_world")),
        tracks,
        time: model.time,
    };
    let info = egui::UiStackInfo::default().with_tag_value(OWNER, Arc::new(owner));
    ui.scope_builder(egui::UiBuilder::new().ui_stack_info(info), content)
        .inner
}

/// The thing whose values are in the rows of this part of the panel.
pub(super) fn owner(ui: &Ui) -> Option<Entity> {
    let mut owners = ui
        .stack()
        .iter()
        .filter_map(|ui| ui.tags().get_downcast::<Arc<Owner>>(OWNER).cloned());
    owners.next().map(|owner| owner.thing)
}

/// The mark of the value of this name, at the right end of its cell, and the menu of the cell. `label` is the cell.
pub(super) fn key_mark(ui: &mut Ui, name: &str, label: &egui::Response) {
    if name.is_empty() {
        return;
    }
    let found = ui
        .stack()
        .iter()
        .find_map(|ui| ui.tags().get_downcast::<Arc<Owner>>(OWNER).cloned());
    let Some(owner) = found else {
        return;
    };
    let path = match name.strip_prefix("to_world.") {
        Some(_) => owner.place.clone(),
        None => KeyPath::new(format!("{}{name}", owner.prefix)),
    };
    let track = owner
        .tracks
        .iter()
        .find(|(known, _)| *known == path)
        .map(|(_, track)| track);
    if let Some(track) = track {
        let corner = egui::pos2(label.rect.left(), label.rect.top());
        let rect = egui::Rect::from_min_size(corner, vec2(WIDTH, label.rect.height()));
        let is_here = track.has_key(owner.time);
        let color = key_color(ui);
        let shape = mark(
            rect.center(),
            if is_here { color } else { color.gamma_multiply(0.25) },
            0.8,
        );
        ui.painter().add(shape);
        if !is_here {
            let outline = mark(rect.center(), egui::Color32::TRANSPARENT, 0.8);
            if let egui::Shape::Path(mut path) = outline {
                path.stroke = Stroke::new(1.0, color).into();
                ui.painter().add(path);
            }
        }
        let about = match is_here {
            true => "It has a key at this time. A click removes the key.",
            false => "It moves. A click sets a key at this time.",
        };
        let response = ui
            .interact(rect, label.id.with("key"), Sense::click())
            .on_hover_text(about);
        if response.clicked() {
            let edit = if is_here { KeyEdit::Remove } else { KeyEdit::Set };
            ask(ui, &owner, &path, edit);
        }
    }
    let menu = label.interact(Sense::click());
    menu.context_menu(|ui| {
        let here = track.is_some_and(|track| track.has_key(owner.time));
        let entries = [
            ("Set key", true, KeyEdit::Set),
            ("Remove key", here, KeyEdit::Remove),
            ("Remove animation", track.is_some(), KeyEdit::RemoveAll),
        ];
        for (text, enabled, edit) in entries {
            if ui.add_enabled(enabled, egui::Button::new(text)).clicked() {
                ask(ui, &owner, &path, edit);
                ui.close();
            }
        }
    });
}

fn asked() -> egui::Id {
    egui::Id::new("keys that marks ask for")
}

fn ask(ui: &Ui, owner: &Owner, path: &KeyPath, edit: KeyEdit) {
    let command = Command::from(TimeEdit::Key(vec![(owner.thing, path.clone())], edit));
    ui.data_mut(|data| data.get_temp_mut_or_default::<Vec<Command>>(asked()).push(command));
}

/// The commands of clicked marks.
pub(crate) fn take_asked(ui: &Ui) -> Vec<Command> {
    ui.data_mut(|data| data.remove_temp(asked())).unwrap_or_default()
}
