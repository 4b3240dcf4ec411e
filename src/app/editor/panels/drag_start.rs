//! Finds what is dragged. Where several events come in one frame, egui looks at where the pointer is at the end of the
//! frame, but users mean what they pressed.

use bevy_egui::egui::{Response, Ui};

/// Whether a drag begins in this frame that was pressed on this widget. The widget is the dragged one then.
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
