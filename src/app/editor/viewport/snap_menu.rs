//! The menu of the toolbar that chooses the targets of snapping.

use bevy_egui::egui::Ui;

use super::tool_icons::{ToolIcon, icon_menu};
use crate::app::editor::command::snapping::{SnapTo, Snapping};
use crate::app::editor::input::actions::{ActionContext, hint};

/// The magnet with the menu; it is marked while moves snap without Control.
pub(crate) fn snap_menu(ui: &mut Ui, keys: &ActionContext, snap: &mut Snapping) {
    let help = format!(
        "What moves snap to while Control is held, with handles and with the key of moving: {}",
        snap.to.name()
    );
    icon_menu(ui, ToolIcon::Magnet, snap.always, "Snapping", &help, |ui| {
        for (to, help) in SnapTo::LABELED {
            ui.radio_value(&mut snap.to, to, to.name()).on_hover_text(help);
        }
        ui.separator();
        ui.checkbox(&mut snap.always, hint("Always snap", "snap-always", keys.bound))
            .on_hover_text("Moves snap always, and with Control they do not");
        ui.checkbox(&mut snap.aligns, "Turn to the surface")
            .on_hover_text("A thing that snaps to a surface turns its upper side to the normal there");
    });
}
