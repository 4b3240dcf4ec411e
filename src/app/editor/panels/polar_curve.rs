//! The intensities of a lamp as lamp makers draw them: the curves of two planes, the beam downwards.

use std::f32::consts::TAU;

use bevy_egui::egui::{self, Align2, Color32, FontId, Sense, Stroke, Ui, vec2};

use crate::photometry::PolarCurve;
use crate::photometry::units::{Candela, Lumen};

/// The edge of the drawing in points.
const EDGE: f32 = 150.0;

/// The colours of the planes C0 and C90.
const COLORS: [Color32; 2] = [Color32::from_rgb(230, 150, 40), Color32::from_rgb(90, 150, 230)];

/// Draws the curves of the planes at the horizontal angles 0 and 90 degrees, with the flux in lumens and the greatest
/// intensity in candela that the lamp emits.
pub(super) fn polar_curve(ui: &mut Ui, curves: [&PolarCurve; 2], [lumens, peak]: [f32; 2]) {
    let most = curves[0].farthest.max(curves[1].farthest);
    if most <= 0.0 || curves[0].peak <= 0.0 {
        return;
    }
    let size = vec2(ui.available_width(), EDGE);
    let (place, response) = ui.allocate_exact_size(size, Sense::hover());
    let words = format!(
        "The intensities in the planes C0 and C90: {} in all directions, at most {}.",
        Lumen(lumens.into()),
        Candela(peak.into()),
    );
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Label, true, &words));
    response.on_hover_text(&words);
    let painter = ui.painter_at(place);
    let (middle, radius) = (place.center(), 0.45 * EDGE);
    let faint = Stroke::new(1.0, ui.visuals().weak_text_color().gamma_multiply(0.5));
    for share in [0.5, 1.0] {
        painter.circle_stroke(middle, share * radius, faint);
    }
    for spoke in 0..6 {
        let way = radius * egui::Vec2::angled(TAU * spoke as f32 / 12.0);
        painter.line_segment([middle - way, middle + way], faint);
    }
    for (curve, color) in curves.into_iter().zip(COLORS) {
        let scale = radius * curve.farthest / most;
        let points = curve.points.iter().map(|point| middle + scale * vec2(point.x, point.y));
        painter.add(egui::Shape::closed_line(points.collect(), Stroke::new(1.5, color)));
    }
    let text = |at, align, text: String, color| {
        painter.text(at, align, text, FontId::proportional(10.0), color);
    };
    let weak = ui.visuals().weak_text_color();
    let candela = Candela((most / curves[0].peak * peak).into()).to_string();
    text(middle + vec2(3.0, radius), Align2::LEFT_BOTTOM, candela, weak);
    text(place.left_top(), Align2::LEFT_TOP, "C0".to_owned(), COLORS[0]);
    text(
        place.left_top() + vec2(0.0, 12.0),
        Align2::LEFT_TOP,
        "C90".to_owned(),
        COLORS[1],
    );
}
