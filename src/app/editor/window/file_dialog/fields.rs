//! The text fields of the dialog.

use bevy_egui::egui::text::CCursorRange;
use bevy_egui::egui::text_edit::TextEditState;
use bevy_egui::egui::{Context, Id, Key, Modifiers, Ui};

/// Selects letters of a text field.
pub(super) fn select(context: &Context, field: Id, letters: CCursorRange) {
    let mut state = TextEditState::load(context, field).unwrap_or_default();
    state.cursor.set_char_range(Some(letters));
    state.store(context, field);
}

/// Consumes a press of Enter; returns whether there was one.
pub(super) fn is_entered(ui: &Ui) -> bool {
    ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Enter))
}
