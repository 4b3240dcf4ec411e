//! Materials that are dragged from the list or the library onto an object in the picture.

use bevy::math::Vec2;
use bevy_egui::egui::{self, Color32, Rect, Response, Ui};

use super::command::Command;
use super::panels::library::DraggedPreset;
use super::panels::outliner::Dragged;

/// `picture`: the whole of it on the screen, of which `response` is.
pub fn drop_target(ui: &Ui, response: &Response, picture: Rect, commands: &mut Vec<Command>) {
    let Some(pointer) = ui.ctx().pointer_interact_pos() else {
        return;
    };
    let hovers =
        response.dnd_hover_payload::<Dragged>().is_some() || response.dnd_hover_payload::<DraggedPreset>().is_some();
    if hovers {
        let font = egui::TextStyle::Body.resolve(ui.style());
        let text = "drop on a shape".to_owned();
        let text = ui.painter().layout_no_wrap(text, font, Color32::WHITE);
        let place = Rect::from_min_size(pointer + egui::vec2(14.0, 10.0), text.size());
        ui.painter()
            .rect_filled(place.expand(4.0), 3.0, Color32::from_black_alpha(190));
        ui.painter().galley(place.min, text, Color32::WHITE);
    }
    let film = (pointer - picture.min) / picture.size();
    let at = Vec2::new(film.x, film.y);
    // To ask for a payload of another type would take it away.
    let is_preset = egui::DragAndDrop::has_payload_of_type::<DraggedPreset>(ui.ctx());
    if is_preset && let Some(dragged) = response.dnd_release_payload::<DraggedPreset>() {
        let preset = Box::new(dragged.0.clone());
        commands.push(Command::DropPreset { preset, at });
        return;
    }
    let dragged = response.dnd_release_payload::<Dragged>();
    if let Some([material]) = dragged.as_ref().map(|dragged| &dragged.0[..]) {
        commands.push(Command::DropMaterial {
            material: *material,
            at,
        });
    }
}
