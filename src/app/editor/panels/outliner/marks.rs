//! The buttons in the lines of the list, to hide and lock.

use bevy_egui::egui::{self, Color32, Painter, Pos2, Rect, Response, Sense, Stroke, Ui, pos2, vec2};

/// Width of each of the two buttons at the right, in points.
pub const BUTTON: f32 = 18.0;

/// A mark that can be clicked and is on or off.
pub fn mark(ui: &mut Ui, help: &str, is_on: bool, paint: fn(&Painter, Rect, Stroke)) -> Response {
    let (rect, response) = ui.allocate_exact_size(vec2(BUTTON, ui.spacing().interact_size.y), Sense::click());
    let color: Color32 = if is_on || response.hovered() {
        ui.visuals().text_color()
    } else {
        ui.visuals().weak_text_color().gamma_multiply(0.5)
    };
    let face = Rect::from_center_size(rect.center(), vec2(12.0, 12.0));
    paint(ui.painter(), face, Stroke::new(1.2, color));
    response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Button, true, is_on, help));
    response.on_hover_text(help)
}

pub fn eye(painter: &Painter, face: Rect, stroke: Stroke) {
    let (middle, width) = (face.center(), 0.5 * face.width());
    let lid = |height: f32| -> Vec<Pos2> {
        let points = (0..=8).map(|i| i as f32 / 4.0 - 1.0);
        points
            .map(|x| middle + vec2(x * width, height * (1.0 - x * x)))
            .collect()
    };
    painter.line(lid(4.0), stroke);
    painter.line(lid(-4.0), stroke);
    painter.circle_filled(middle, 2.0, stroke.color);
}

pub fn padlock(painter: &Painter, face: Rect, stroke: Stroke) {
    let body = Rect::from_min_max(
        face.left_center() + vec2(1.5, -0.5),
        face.right_bottom() + vec2(-1.5, 0.0),
    );
    painter.rect_filled(body, 1.0, stroke.color);
    let bow = [
        (-3.0, 0.0),
        (-3.0, -1.5),
        (-1.5, -3.2),
        (1.5, -3.2),
        (3.0, -1.5),
        (3.0, 0.0),
    ];
    let top = face.top() + 5.5;
    let bow = bow.iter().map(|&(x, y)| pos2(face.center().x + x, top + y));
    painter.line(bow.collect(), stroke);
}
