//! The menu of the toolbar that says what moves snap to.

use bevy_egui::egui::{RichText, Ui};

use crate::app::editor::command::snapping::{SnapTo, Snapping};

/// The button with the menu; it is strong while moves snap without Control.
pub(crate) fn snap_menu(ui: &mut Ui, snap: &mut Snapping) {
    let text = RichText::new(format!("Snap: {}", snap.to.name()));
    let text = if snap.always { text.strong() } else { text };
    let button = ui.menu_button(text, |ui| {
        for (to, name, help) in SnapTo::ALL {
            ui.radio_value(&mut snap.to, to, name).on_hover_text(help);
        }
        ui.separator();
        ui.checkbox(&mut snap.always, "Without Ctrl (Shift+Tab)")
            .on_hover_text("Moves snap always, and with Control they do not");
        ui.checkbox(&mut snap.aligns, "Turn to the surface")
            .on_hover_text("A thing that snaps to a surface turns its upper side to the normal there");
    });
    button
        .response
        .on_hover_text("What moves snap to while Control is held: with handles and with G");
}
