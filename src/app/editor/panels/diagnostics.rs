//! The panel of problems with the scene, its meshes, the render, the last bake or the preferences.

use bevy_egui::egui::{self, RichText, Ui};

use super::excerpt::excerpt;
use super::fields;
use crate::app::editor::model::Notice;
use crate::document::Severity;

/// One block for each message; its text can be copied.
pub fn diagnostics(ui: &mut Ui, notices: &[Notice]) {
    fields::leave_scroll_bar(ui);
    if notices.is_empty() {
        ui.add_space(8.0);
        ui.weak("The scene has no errors and no warnings.");
        return;
    }
    for (place, notice) in notices.iter().enumerate() {
        ui.push_id(place, |ui| one(ui, notice));
        ui.separator();
    }
}

fn one(ui: &mut Ui, notice: &Notice) {
    ui.horizontal_wrapped(|ui| {
        let visuals = ui.visuals();
        let color = match notice.severity {
            Severity::Error => visuals.error_fg_color,
            Severity::Warning => visuals.warn_fg_color,
            Severity::Note => visuals.weak_text_color(),
        };
        ui.label(RichText::new(notice.severity.to_string()).strong().color(color));
        if let Some(place) = &notice.place {
            let color = ui.visuals().hyperlink_color;
            ui.label(RichText::new(place).monospace().size(12.0).color(color));
        }
    });
    ui.add(egui::Label::new(&notice.text).wrap());
    if let Some(lines) = &notice.excerpt {
        excerpt(ui, lines);
    }
    if let Some(help) = &notice.help {
        ui.add(egui::Label::new(RichText::new(format!("help: {help}")).weak()).wrap());
    }
}
