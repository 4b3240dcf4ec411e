//! What tests of the editor share.

use bevy_egui::egui;
use sunroom::app::editor::keys::Press;

/// The keys that went down this frame, as the window hands them to the editor.
pub fn presses(ui: &egui::Ui) -> Vec<Press> {
    let press = |event: &egui::Event| match *event {
        egui::Event::Key {
            key,
            pressed: true,
            repeat: false,
            modifiers,
            ..
        } => Some(Press {
            key,
            modifiers,
            numpad: false,
        }),
        _ => None,
    };
    ui.input(|input| input.events.iter().filter_map(press).collect())
}
