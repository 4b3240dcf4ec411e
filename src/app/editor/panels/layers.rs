//! The choice of the layers that are saved with the picture.

use bevy_egui::egui::Ui;

use crate::app::editor::command::Command;
use crate::layer::{Layer, Layers};
use crate::scene::IntegratorSettings;

/// A box to check for each layer. The scene remembers the choice.
pub fn layer_rows(ui: &mut Ui, integrator: IntegratorSettings, commands: &mut Vec<Command>) {
    ui.weak("Saved with EXR images, beside the picture.");
    for layer in Layer::ALL {
        let mut is_chosen = integrator.layers.contains(layer);
        if ui.checkbox(&mut is_chosen, layer.label()).changed() {
            let this = Layers::of(&[layer]);
            let layers = match is_chosen {
                true => integrator.layers.and(this),
                false => integrator.layers.without(this),
            };
            commands.push(Command::SetIntegrator(IntegratorSettings { layers, ..integrator }));
        }
    }
}
