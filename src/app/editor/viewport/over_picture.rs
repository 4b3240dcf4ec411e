//! Whether the pointer is on the picture itself, where tools and navigation may use a press.

use bevy_egui::egui::{Response, Ui};

/// Whether a press now would hit the picture, and not an overlay such as a button.
pub(super) fn is_over(ui: &Ui, response: &Response) -> bool {
    let is_its_own = ui.ctx().viewport(|viewport| {
        let hits = [&viewport.hits.click, &viewport.hits.drag];
        hits.into_iter().flatten().all(|hit| hit.id == response.id)
    });
    is_its_own && response.contains_pointer()
}
