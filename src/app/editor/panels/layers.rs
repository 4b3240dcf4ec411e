//! The choice of the layers that are saved with the picture.

use bevy_egui::egui::Ui;

use crate::app::editor::command::{Command, SettingsEdit};
use crate::layer::{Layer, Layers};
use crate::scene::IntegratorSettings;

/// The names of a layer in other programs.
fn names(layer: Layer) -> String {
    let (channel, name) = (layer.name_in_pictures(), layer.name());
    let channels = match layer {
        Layer::Alpha => format!("the channel `{channel}`"),
        Layer::LightGroups => format!("channels `{channel}.NAME.R`, with the name of each light"),
        Layer::CryptoObject | Layer::CryptoMaterial => format!("channels `{channel}00.R` and further"),
        _ => format!("channels `{channel}.…`"),
    };
    let note = match layer {
        Layer::Motion => {
            "\nIt is 0 in the window, which does not know the frame before: `sunroom render --frames` does"
        }
        _ => "",
    };
    format!("In EXR files: {channels}\nOn the command line: --aov {name}{note}")
}

/// Shows a check box for each layer. The scene stores the choice.
pub fn layer_rows(ui: &mut Ui, integrator: IntegratorSettings, commands: &mut Vec<Command>) {
    ui.weak("Saved with EXR images, beside the picture.");
    for layer in Layer::ALL {
        let mut is_chosen = integrator.layers.contains(layer);
        let row = ui.checkbox(&mut is_chosen, layer.label());
        if row.on_hover_text(names(layer)).changed() {
            let this = Layers::of(&[layer]);
            let layers = match is_chosen {
                true => integrator.layers.and(this),
                false => integrator.layers.without(this),
            };
            commands.push(SettingsEdit::SetIntegrator(IntegratorSettings { layers, ..integrator }).into());
        }
    }
}
