//! The slower search for the light you want: what of a lamp may change, how far the search is, and what was found.

use bevy_egui::egui::{self, ProgressBar, Ui};

use super::{fields, look};
use crate::app::editor::command::{Command, LightPaintCommand, SettingsEdit};
use crate::app::editor::model::PaintingModel;
use crate::engine::lamp_freedom::{FreedomKind, LampFreedom};

/// The radii that the slider offers, in units of the world.
const RADII: std::ops::RangeInclusive<f32> = 0.0..=100.0;

/// Shows what of a lamp may change besides its strength. Returns whether that was edited.
pub(super) fn freedom_rows(ui: &mut Ui, kind: FreedomKind, freedom: &mut LampFreedom) -> bool {
    let mut changed = false;
    if matches!(kind, FreedomKind::Place | FreedomKind::Pose) {
        changed |= fields::slider_with(ui, "May move", &mut freedom.radius, RADII, |slider| {
            slider.logarithmic(true).smallest_positive(0.01)
        });
    }
    if matches!(kind, FreedomKind::Aim | FreedomKind::Pose) {
        changed |= fields::slider_with(ui, "May turn", &mut freedom.turn, 0.0..=90.0, |slider| {
            slider.suffix("°")
        });
    }
    if kind == FreedomKind::Sun {
        let mut any_hour = freedom.hours.is_some();
        if fields::checkbox(ui, "Any hour", &mut any_hour) {
            freedom.hours = any_hour.then_some([0.0, 24.0]);
            changed = true;
        }
        if let Some(hours) = &mut freedom.hours {
            let style = |letter, range| fields::NumberStyle {
                range,
                ..fields::NumberStyle::new(letter, 0.1)
            };
            let styles = [style("≥", 0.0..=hours[1] - 0.1), style("≤", hours[0] + 0.1..=24.0)];
            changed |= fields::numbers(ui, "Hours", hours, styles);
        }
        changed |= fields::checkbox(ui, "Any day", &mut freedom.day);
    }
    changed
}

/// Shows the button that begins the search, its progress, and what was found.
pub(super) fn placing_rows(ui: &mut Ui, model: &PaintingModel, is_wanted: bool, commands: &mut Vec<Command>) {
    let may_change = model.lamps.iter().any(|(_, choice)| !choice.freedom.is_none());
    if !may_change && model.placing.is_none() && model.proposal.is_none() {
        return;
    }
    if let Some(done) = model.placing {
        fields::buttons(ui, |ui| {
            ui.add(ProgressBar::new(done).desired_width(120.0).show_percentage());
            if ui.button("Stop").clicked() {
                commands.push(LightPaintCommand::Discard.into());
            }
        });
        return;
    }
    if let Some(proposal) = &model.proposal {
        proposal.notes.iter().for_each(|note| drop(ui.label(note)));
    }
    fields::buttons(ui, |ui| {
        let find = ui.add_enabled(is_wanted && may_change, egui::Button::new("Find places"));
        let hint =
            "Search for places, aims and times of the lamps that may change them. Nothing changes until you accept";
        if find.on_hover_text(hint).clicked() {
            commands.push(LightPaintCommand::Place.into());
        }
        let Some(proposal) = &model.proposal else { return };
        if !proposal.placements.is_empty() && ui.add(look::primary_if(ui, true, "Accept")).clicked() {
            commands.push(SettingsEdit::AcceptLamps.into());
        }
        if ui.button("Discard").clicked() {
            commands.push(LightPaintCommand::Discard.into());
        }
    });
}
