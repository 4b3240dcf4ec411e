//! Finds the dragged widget. If several events come in one frame, egui takes the widget under the pointer at the end of
//! the frame, but users mean the one that they pressed.

use bevy_egui::egui::{Response, Ui};

/// Whether a drag begins in this frame with a press on this widget, which becomes the dragged one.
pub fn is_drag_of(ui: &Ui, response: &Response) -> bool {
    let context = ui.ctx();
    let (Some(started), Some(pressed)) = (
        context.drag_started_id(),
        ui.input(|input| input.pointer.press_origin()),
    ) else {
        return false;
    };
    let is_here = response.interact_rect.contains(pressed)
        && context
            .layer_id_at(pressed)
            .is_none_or(|layer| layer == response.layer_id);
    if is_here && started != response.id {
        context.set_dragged_id(response.id);
    }
    is_here
}
