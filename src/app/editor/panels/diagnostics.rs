//! What is wrong with the scene, its meshes or the render.

use bevy_egui::egui::{self, Color32, RichText, Ui};

use super::super::model::Notice;

pub fn diagnostics(ui: &mut Ui, notices: &[Notice]) {
    if notices.is_empty() {
        ui.add_space(8.0);
        ui.weak("The scene has no errors and no warnings.");
        return;
    }
    for notice in notices {
        ui.horizontal_wrapped(|ui| {
            if notice.is_error {
                ui.label(RichText::new("error").strong().color(ui.visuals().error_fg_color));
            } else {
                ui.label(RichText::new("warning").strong().color(ui.visuals().warn_fg_color));
            }
            if let Some(place) = &notice.place {
                ui.label(RichText::new(place).monospace().small().color(Color32::LIGHT_BLUE));
            }
        });
        ui.add(egui::Label::new(&notice.text).wrap());
        if let Some(help) = &notice.help {
            ui.add(egui::Label::new(RichText::new(format!("help: {help}")).weak()).wrap());
        }
        ui.separator();
    }
}
