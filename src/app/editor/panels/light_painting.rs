//! The light you want: the brush, the lamps that may change, and what was found.

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Ui};

use super::fields::NumberStyle;
use super::lamp_placing::{freedom_rows, placing_rows};
use super::{color_field, fields};
use crate::app::editor::command::light_paint::{Brush, LampChoice};
use crate::app::editor::command::tool::Tool;
use crate::app::editor::command::{Command, FileCommand, FileDialogKind, LightPaintCommand, ToolCommand};
use crate::app::editor::model::PaintingModel;
use crate::inverse_lighting::Wish;

/// Shows the rows. `lights` are those with a layer, and their names.
pub fn light_painting(ui: &mut Ui, model: &PaintingModel, lights: &[(Entity, String)], commands: &mut Vec<Command>) {
    ui.separator();
    brush_rows(ui, model.brush, commands);
    fields::buttons(ui, |ui| {
        let button = egui::Button::selectable(model.tool_is_on, "Paint light").frame_when_inactive(true);
        let hint = "Paint over the picture where light is wanted: the strengths of the lamps follow";
        if ui.add(button).on_hover_text(hint).clicked() {
            let tool = if model.tool_is_on {
                Tool::Select
            } else {
                Tool::PaintLight
            };
            commands.push(ToolCommand::SetTool(tool).into());
        }
        let hint = "Want a picture of the same view: an EXR file by its radiance, others by their linear colours";
        if ui.button("Wanted picture…").on_hover_text(hint).clicked() {
            commands.push(FileCommand::ShowDialog(FileDialogKind::WantedPicture).into());
        }
    });
    if let Some(name) = &model.picture {
        fields::note(ui, "Picture", name.clone());
    }
    for (light, name) in lights {
        ui.push_id(("wanted", light), |ui| {
            let choice = model.lamps.iter().find(|(lamp, _)| lamp == light);
            let mut choice = choice.map_or_else(LampChoice::default, |(_, choice)| *choice);
            let mut changed = lamp_rows(ui, name, &mut choice);
            if let Some((_, kind)) = model.freedoms.iter().find(|(lamp, _)| lamp == light) {
                changed |= freedom_rows(ui, *kind, &mut choice.freedom);
            }
            if changed {
                commands.push(LightPaintCommand::SetLamp(*light, choice).into());
            }
        });
    }
    let notes = model.answer.iter().flat_map(|answer| &answer.notes);
    let elsewhere = "The strokes belong to another view: go back to it, or clear them.";
    match model.is_elsewhere {
        true => drop(ui.label(elsewhere)),
        false => notes.for_each(|note| drop(ui.label(note))),
    }
    let has_strokes = !model.strokes.is_empty();
    let is_wanted = has_strokes || model.picture.is_some();
    fields::buttons(ui, |ui| {
        if ui
            .add_enabled(has_strokes, egui::Button::new("Remove stroke"))
            .clicked()
        {
            let but_last = model.strokes[..model.strokes.len().saturating_sub(1)].to_vec();
            commands.push(LightPaintCommand::SetStrokes(but_last).into());
        }
        let clear = ui.add_enabled(is_wanted, egui::Button::new("Clear"));
        if clear
            .on_hover_text("Remove all strokes; the lights are mixed as before")
            .clicked()
        {
            commands.push(LightPaintCommand::SetTarget(None).into());
            commands.push(LightPaintCommand::SetStrokes(Vec::new()).into());
        }
    });
    placing_rows(ui, model, is_wanted, commands);
}

/// The kinds of wishes with their names in the panel.
const KINDS: [&str; 6] = [
    "Brighter",
    "Darker",
    "This luminance",
    "This illuminance",
    "This colour",
    "As it is",
];

fn brush_rows(ui: &mut Ui, brush: Brush, commands: &mut Vec<Command>) {
    let mut changed = brush;
    let of_kind = |wish: Wish| {
        Wish::ALL
            .iter()
            .position(|other| other.name() == wish.name())
            .unwrap_or(0)
    };
    let mut kind = of_kind(brush.wish);
    let kinds: Vec<(usize, &str)> = KINDS.into_iter().enumerate().collect();
    if fields::choice(ui, "Wanted", &mut kind, &kinds) {
        changed.wish = Wish::ALL[kind];
    }
    match &mut changed.wish {
        Wish::Brighter(factor) | Wish::Darker(factor) => {
            fields::log_slider(ui, "Times", factor, 1.0..=100.0);
        }
        Wish::Luminance(nit) => {
            fields::slider_with(ui, "Luminance", nit, 0.0..=1e5, |slider| {
                slider.logarithmic(true).smallest_positive(0.01).suffix(" nit")
            });
        }
        Wish::Illuminance(lux) => {
            fields::slider_with(ui, "Illuminance", lux, 0.0..=1e5, |slider| {
                slider.logarithmic(true).smallest_positive(0.01).suffix(" lx")
            });
        }
        Wish::Color(color) => {
            color_field::color(ui, "Colour", color);
        }
        Wish::Keep => {}
    }
    fields::log_slider(ui, "Radius", &mut changed.radius, 0.005..=0.5);
    fields::slider(ui, "Hardness", &mut changed.hardness, 0.0..=1.0);
    if changed != brush && changed.stroke(vec![Default::default()]).is_valid() {
        commands.push(LightPaintCommand::SetBrush(changed).into());
    }
}

/// Shows whether a lamp may change, its limits, and whether its colour may change. Returns whether that was edited.
fn lamp_rows(ui: &mut Ui, name: &str, choice: &mut LampChoice) -> bool {
    let mut changed = fields::checkbox(ui, name, &mut choice.chosen);
    if !choice.chosen {
        return changed;
    }
    let mut limits = [choice.least, choice.most];
    let style = |letter, range| NumberStyle {
        range,
        ..NumberStyle::new(letter, 0.02)
    };
    let styles = [style("≥", 0.0..=limits[1]), style("≤", limits[0]..=1e6)];
    if fields::numbers(ui, "Limits", &mut limits, styles) {
        [choice.least, choice.most] = limits;
        changed = true;
    }
    changed | fields::checkbox(ui, "Colour too", &mut choice.colored)
}
