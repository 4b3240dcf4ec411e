//! The menu of real lamps and skies.

use bevy_egui::egui::{IntoAtoms, Ui};

use crate::photometry::lamps::{LAMPS, Lamp};
use crate::photometry::units::short;

/// Shows the menu; returns the lamp that was chosen. Only those for which `is_possible` are offered.
pub(super) fn lamps_menu<'a>(
    ui: &mut Ui,
    title: impl IntoAtoms<'a>,
    is_possible: impl Fn(&Lamp) -> bool,
) -> Option<&'static Lamp> {
    let mut chosen = None;
    ui.menu_button(title, |ui| {
        for lamp in LAMPS.iter().filter(|lamp| is_possible(lamp)) {
            let amount = format!("{} {}", short(lamp.amount.into()), lamp.unit.name());
            let button = ui.button(format!("{}, {amount}", lamp.label));
            let words = format!("{amount} at {} K. {}.", lamp.kelvin, lamp.source);
            if button.on_hover_text(words).clicked() {
                chosen = Some(lamp);
                ui.close();
            }
        }
    });
    chosen
}
