//! The mixing desk: each light of the finished picture made brighter, darker or of another colour without new samples.

use bevy_egui::egui::{self, Ui};

use super::{color_field, fields, look};
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::light_mix::{Channel, LightMix};
use crate::app::editor::command::{Command, DisplayCommand, RenderCommand, SettingsEdit};
use crate::app::editor::model::MixingModel;

/// Shows a row of controls for each light with a layer of its own.
pub fn light_mixing(ui: &mut Ui, model: &MixingModel, display: DisplaySettings, commands: &mut Vec<Command>) {
    let mut is_on = model.is_on;
    if fields::checkbox(ui, "Mix lights", &mut is_on) {
        commands.push(RenderCommand::SetLightLayers(is_on).into());
    }
    if !model.is_on {
        return;
    }
    for (place, (light, name)) in (0..).zip(&model.lights) {
        ui.push_id(light, |ui| {
            let mut channel = model.mix.channel(*light);
            let changed = channel_rows(ui, name, &mut channel);
            if changed {
                let mut mix = model.mix.clone();
                mix.set(*light, channel);
                commands.push(DisplayCommand::SetLightMix(mix).into());
            }
            fields::buttons(ui, |ui| alone_button(ui, place, display, commands));
        });
    }
    fields::buttons(ui, |ui| {
        let has_mix = !model.mix.is_neutral();
        if ui.add_enabled(has_mix, egui::Button::new("Reset")).clicked() {
            commands.push(DisplayCommand::SetLightMix(LightMix::default()).into());
        }
        let bake = look::primary_if(ui, has_mix, "Bake");
        let bake = ui.add_enabled(has_mix, bake);
        let bake = bake.on_hover_text("Write strengths and colours to the lights of the scene");
        if bake.clicked() {
            commands.push(SettingsEdit::BakeLights.into());
        }
    });
}

fn channel_rows(ui: &mut Ui, name: &str, channel: &mut Channel) -> bool {
    let mut changed = false;
    ui.horizontal(|ui| {
        ui.add(egui::Label::new(egui::RichText::new(name).strong()).truncate());
        for (letter, hint, value) in [
            ("S", "Solo: only lights with this", &mut channel.solo),
            ("M", "Mute: without this light", &mut channel.mute),
        ] {
            let button = egui::Button::selectable(*value, letter).frame_when_inactive(true);
            let button = ui.add(button).on_hover_text(hint);
            button.widget_info(|| {
                let name = format!("{name} {letter}");
                egui::WidgetInfo::selected(egui::WidgetType::SelectableLabel, true, *value, name)
            });
            if button.clicked() {
                *value = !*value;
                changed = true;
            }
        }
    });
    changed |= fields::slider_with(ui, "Strength", &mut channel.strength, 0.0..=100.0, |slider| {
        slider.logarithmic(true).smallest_positive(0.01)
    });
    changed |= color_field::color(ui, "Colour", &mut channel.color);
    changed
}

/// Shows the button that displays only this light's layer, or the whole picture again.
fn alone_button(ui: &mut Ui, place: u8, display: DisplaySettings, commands: &mut Vec<Command>) {
    let alone = DisplayMode::LightGroup(place);
    let is_alone = display.mode == alone;
    let button = egui::Button::selectable(is_alone, "Show its layer").frame_when_inactive(true);
    if ui.add(button).clicked() {
        let mode = if is_alone { DisplayMode::Shaded } else { alone };
        commands.push(DisplayCommand::SetDisplay(DisplaySettings { mode, ..display }).into());
    }
}
