//! The sections of a panel: a header flush left on a strip, and indented rows below it.

use bevy_egui::egui::collapsing_header::{CollapsingState, paint_default_icon};
use bevy_egui::egui::{self, Align2, Frame, Margin, Sense, TextStyle, Ui, WidgetInfo, WidgetType};

use super::look;

/// The height of a header, in points.
const HEIGHT: f32 = 22.0;
/// The room between two sections, in points.
const GAP: f32 = 4.0;
/// The room that the triangle takes at the left of a header, in points.
const ICON: f32 = 20.0;
/// How far the rows of a section are indented, in points.
const INDENT: i8 = 6;
/// The distance in points between two paintings of the title, which make it bold: the fonts of egui have no bold face.
const BOLD: f32 = 0.5;

/// Shows a section that a click on its header opens and closes. It is open at first.
pub fn section(ui: &mut Ui, title: &str, content: impl FnOnce(&mut Ui)) {
    section_with(ui, title, true, content);
}

/// Shows a section that is open or closed at first.
pub fn section_with(ui: &mut Ui, title: &str, is_open: bool, content: impl FnOnce(&mut Ui)) {
    let id = ui.make_persistent_id(("section", title));
    let mut state = CollapsingState::load_with_default_open(ui.ctx(), id, is_open);
    ui.add_space(GAP);
    let (rect, response) = ui.allocate_exact_size(egui::vec2(ui.available_width(), HEIGHT), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::CollapsingHeader, ui.is_enabled(), title));
    if response.clicked() {
        state.toggle(ui);
    }
    if ui.is_rect_visible(rect) {
        let fill = match response.hovered() {
            true => ui.visuals().widgets.hovered.weak_bg_fill,
            false => look::strip(ui.visuals()),
        };
        ui.painter().rect_filled(rect, 3.0, fill);
        let triangle = egui::Rect::from_center_size(
            rect.left_center() + egui::vec2(0.5 * ICON, 0.0),
            egui::Vec2::splat(10.0),
        );
        paint_default_icon(ui, state.openness(ui.ctx()), &response.clone().with_new_rect(triangle));
        let font = TextStyle::Body.resolve(ui.style());
        let color = ui.visuals().strong_text_color();
        for shift in [0.0, BOLD] {
            let place = rect.left_center() + egui::vec2(ICON + shift, 0.0);
            ui.painter()
                .text(place, Align2::LEFT_CENTER, title, font.clone(), color);
        }
    }
    state.show_body_unindented(ui, |ui| {
        let margin = Margin {
            left: INDENT,
            right: 0,
            top: 2,
            bottom: 2,
        };
        Frame::NONE.inner_margin(margin).show(ui, content);
    });
}
