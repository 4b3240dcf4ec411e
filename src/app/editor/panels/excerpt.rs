//! Shows the lines of a file that messages quote.

use bevy_egui::egui::{self, FontId, RichText, Ui};

/// Shows lines of a file as they are; those that are too long can be scrolled.
pub fn excerpt(ui: &mut Ui, lines: &str) {
    egui::ScrollArea::horizontal().show(ui, |ui| {
        let text = RichText::new(lines).font(FontId::monospace(11.0));
        ui.add(egui::Label::new(text).extend());
    });
}
