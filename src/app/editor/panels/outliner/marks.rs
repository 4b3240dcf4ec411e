//! Paints small marks in the lines of the list: the icon of the kind, and the buttons to hide and lock.

use std::f32::consts::TAU;

use bevy_egui::egui::{self, Color32, Painter, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2};

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

/// Paints the icon of a kind, as the outline names it, within 12 by 12 points around `middle`.
pub fn kind(painter: &Painter, middle: Pos2, kind: &str, color: Color32) {
    let stroke = Stroke::new(1.2, color);
    let loop_of = |points: &[(f32, f32)]| {
        let points = points.iter().map(|&(x, y)| middle + vec2(x, y)).collect();
        painter.add(Shape::closed_line(points, stroke));
    };
    let line = |a: (f32, f32), b: (f32, f32)| {
        painter.line_segment([middle + vec2(a.0, a.1), middle + vec2(b.0, b.1)], stroke);
    };
    let ellipse = |y: f32| painter.add(Shape::ellipse_stroke(middle + vec2(0.0, y), vec2(5.0, 2.2), stroke));
    match kind {
        "sphere" => {
            painter.circle_stroke(middle, 5.0, stroke);
        }
        "rectangle" => loop_of(&[(-3.0, -3.0), (5.5, -3.0), (3.0, 3.0), (-5.5, 3.0)]),
        "cube" => {
            loop_of(&[
                (0.0, -5.5),
                (5.0, -2.8),
                (5.0, 2.8),
                (0.0, 5.5),
                (-5.0, 2.8),
                (-5.0, -2.8),
            ]);
            for corner in [(0.0, 5.5), (5.0, -2.8), (-5.0, -2.8)] {
                line((0.0, 0.0), corner);
            }
        }
        "disk" => {
            ellipse(0.0);
        }
        "cylinder" => {
            ellipse(-3.0);
            line((-5.0, -3.0), (-5.0, 3.5));
            line((5.0, -3.0), (5.0, 3.5));
            line((-5.0, 3.5), (0.0, 5.5));
            line((5.0, 3.5), (0.0, 5.5));
        }
        "wall" => {
            loop_of(&[(-5.5, -4.0), (5.5, -4.0), (5.5, 4.5), (-5.5, 4.5)]);
            loop_of(&[(-2.0, -1.5), (2.0, -1.5), (2.0, 1.5), (-2.0, 1.5)]);
        }
        "stairs" => loop_of(&[
            (-5.5, 5.0),
            (-5.5, 1.7),
            (-1.8, 1.7),
            (-1.8, -1.6),
            (1.9, -1.6),
            (1.9, -5.0),
            (5.5, -5.0),
            (5.5, 5.0),
        ]),
        "prism" => {
            loop_of(&[
                (-2.5, -5.5),
                (2.5, -5.5),
                (5.5, -3.5),
                (2.5, -1.5),
                (-2.5, -1.5),
                (-5.5, -3.5),
            ]);
            for (x, foot) in [(-5.5, 3.5), (-2.5, 5.5), (2.5, 5.5), (5.5, 3.5)] {
                line((x, foot - 7.0), (x, foot));
            }
            for ends in [
                ((-5.5, 3.5), (-2.5, 5.5)),
                ((-2.5, 5.5), (2.5, 5.5)),
                ((2.5, 5.5), (5.5, 3.5)),
            ] {
                line(ends.0, ends.1);
            }
        }
        "medium" | "volume" | "fog" => {
            for (place, radius) in [((-2.5, 1.0), 3.0), ((1.0, -1.5), 3.8), ((3.5, 2.0), 2.4)] {
                painter.circle_stroke(middle + vec2(place.0, place.1), radius, stroke);
            }
        }
        "triangle" => loop_of(&[(0.0, -5.0), (5.0, 4.0), (-5.0, 4.0)]),
        "mesh" => {
            loop_of(&[(0.0, -5.0), (5.5, 4.0), (-5.5, 4.0)]);
            loop_of(&[(0.0, 4.0), (-2.75, -0.5), (2.75, -0.5)]);
        }
        "instance" => {
            loop_of(&[(-5.0, -5.0), (2.0, -5.0), (2.0, 2.0), (-5.0, 2.0)]);
            loop_of(&[(-2.0, -2.0), (5.0, -2.0), (5.0, 5.0), (-2.0, 5.0)]);
        }
        "camera" => {
            loop_of(&[(-5.5, -3.0), (2.0, -3.0), (2.0, 3.0), (-5.5, 3.0)]);
            loop_of(&[(2.0, 0.0), (5.5, -3.0), (5.5, 3.0)]);
        }
        // All other things in the list are lights.
        _ => {
            painter.circle_stroke(middle, 2.5, stroke);
            for ray in 0..8 {
                let direction = Vec2::angled(TAU * ray as f32 / 8.0);
                painter.line_segment([middle + 4.0 * direction, middle + 6.0 * direction], stroke);
            }
        }
    }
}
