//! Colours that the panels add to those of the theme, and the primary button.

use bevy_egui::egui::{Align, Button, Color32, Layout, RichText, Ui, Visuals};

/// The background of the headers of sections: a slightly lighter grey than the panel in the dark theme, a darker one in
/// the light theme.
pub fn strip(visuals: &Visuals) -> Color32 {
    match visuals.dark_mode {
        true => Color32::from_gray(52),
        false => Color32::from_gray(214),
    }
}

/// The background of the button of a dialog's main action.
pub fn accent(visuals: &Visuals) -> Color32 {
    match visuals.dark_mode {
        true => Color32::from_rgb(0, 98, 142),
        false => Color32::from_rgb(0, 92, 148),
    }
}

/// The text on [`accent`].
pub const ON_ACCENT: Color32 = Color32::WHITE;

/// The button of the main action of a dialog or a panel.
pub fn primary(ui: &Ui, text: &str) -> Button<'static> {
    Button::new(RichText::new(text.to_owned()).color(ON_ACCENT)).fill(accent(ui.visuals()))
}

/// The button of the main action if it `is_main`; a plain one otherwise. A disabled button has to be plain: a pale
/// accent is not legible.
pub fn primary_if(ui: &Ui, is_main: bool, text: &str) -> Button<'static> {
    match is_main {
        true => primary(ui, text),
        false => Button::new(text.to_owned()),
    }
}

/// Shows the row of buttons below a form, at its right: its action, and *Cancel*. Returns whether each was clicked.
pub fn form_buttons(ui: &mut Ui, does: &str, help: &str) -> (bool, bool) {
    let mut clicked = (false, false);
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let button = primary(ui, does);
            clicked.0 = ui.add(button).on_hover_text(help).clicked();
            clicked.1 = ui.button("Cancel").on_hover_text("Esc").clicked();
        });
    });
    clicked
}

/// The button of a destructive action.
pub fn danger(ui: &Ui, text: &str) -> Button<'static> {
    Button::new(RichText::new(text.to_owned()).color(ui.visuals().error_fg_color))
}
