//! The look of all questions of the program: a heading, sentences about what each answer does, and one row of buttons. An answer that loses something
//! stands at the left, apart from the others; the usual answer stands at the right, in the colour of the primary button.

use bevy_egui::egui::{self, Id, Modal, ModalResponse, RichText, Ui};

/// Asks a question.
pub fn question<R>(
    context: &egui::Context,
    id: &str,
    width: f32,
    heading: &str,
    content: impl FnOnce(&mut Ui) -> R,
) -> ModalResponse<R> {
    Modal::new(Id::new(id)).show(context, |ui| {
        ui.set_width(width);
        ui.label(RichText::new(heading).heading().strong());
        ui.add_space(6.0);
        content(ui)
    })
}

/// The consequence of an answer, as a sentence.
pub fn consequence(ui: &mut Ui, answer: &str, what: &str) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.strong(format!("{answer}:"));
        ui.label(what);
    });
}

/// The row of buttons: first those at the left, then those from the right.
pub fn answers(ui: &mut Ui, left: impl FnOnce(&mut Ui), right: impl FnOnce(&mut Ui)) {
    ui.add_space(10.0);
    ui.horizontal(|ui| {
        left(ui);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), right);
    });
}
