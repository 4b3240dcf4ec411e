//! Where the light of a lamp goes: the things that get it, as bars with errors. A click on a name selects the thing.

use bevy_egui::egui::Ui;

use super::reasons::{link, search_without_result, share_bar};
use super::section::section;
use crate::app::editor::command::{Command, ToolCommand};
use crate::app::editor::picture::lamp_light::{LampFollower, LampLight, Receiver};
use crate::engine::reasons::{NOTHING_LIT, listed, percent};
use crate::photometry::units::Lumen;

/// Shows the light of the followed lamp, and offers to follow that of the selected one.
pub fn lamp_light(ui: &mut Ui, follower: &LampFollower, commands: &mut Vec<Command>) {
    let offered = follower
        .selected
        .as_ref()
        .filter(|selected| follower.lamp != Some(selected.0));
    if let Some((entity, name)) = offered {
        let button = ui.button(format!("Where does the light of {name} go?"));
        let help = "Traces paths from the lamp and lists the things at which its light stays";
        if button.on_hover_text(help).clicked() {
            commands.push(ToolCommand::FollowLamp(Some(*entity)).into());
        }
    }
    if follower.lamp.is_none() {
        return;
    }
    section(ui, "Where does the light of the lamp go?", |ui| {
        match &follower.light {
            Some(light) => rows(ui, follower, light, commands),
            None => search_without_result(ui, &follower.state),
        }
        if ui.button("Forget the lamp").clicked() {
            commands.push(ToolCommand::FollowLamp(None).into());
        }
    });
}

fn rows(ui: &mut Ui, follower: &LampFollower, light: &LampLight, commands: &mut Vec<Command>) {
    let [emitted, error] = light.emitted.map(lumens);
    ui.label(format!("{} emits {}.", follower.name, emitted.with_error(error.0)));
    if light.receivers.is_empty() {
        ui.weak(NOTHING_LIT);
    }
    let (told, rest) = listed(&light.receivers, |receiver| receiver.destination.share);
    for Receiver { destination, name } in told {
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let share = percent(destination.share, destination.share_error);
            let bar = share_bar(ui, &share, destination.share, &format!("stays at {name}"), false);
            let [received, error] = [destination.received, destination.received_error].map(lumens);
            let received = received.with_error(error.0);
            bar.on_hover_text(format!("{received} arrive there, reflected light included"));
            match destination.key {
                Some(entity) => link(ui, name, entity, commands),
                None => drop(ui.label(name)),
            }
        });
    }
    let share: f32 = rest.iter().map(|receiver| receiver.destination.share).sum();
    if share > 0.0 {
        let things = if rest.len() == 1 { "thing" } else { "things" };
        ui.weak(format!("{:.1} % at {} other {things}", 100.0 * share, rest.len()));
    }
    let [escaped, error] = light.escaped;
    if escaped > 0.0 {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            share_bar(ui, &percent(escaped, error), escaped, "leaves the scene", false);
            ui.label("leaves the scene");
        });
    }
}

fn lumens(watts: f32) -> Lumen {
    Lumen::of_watts(f64::from(watts))
}
