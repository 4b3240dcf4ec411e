//! The diamonds of keys, and the buttons of the timeline for keys: a diamond with a sign.

use bevy_egui::egui::{Button, Color32, Pos2, Shape, Stroke, Ui, Vec2, WidgetInfo, WidgetType, vec2};

/// The half diagonal of a key's mark, and the distance within which the pointer hits it.
pub(super) const MARK: f32 = 6.5;

/// The sign beside the diamond on a button for keys.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Sign {
    Before,
    After,
    Plus,
    Minus,
}

/// Shows a button with a diamond and a sign; returns true if it was clicked. `name` names it for assistive technology.
pub(super) fn sign_button(ui: &mut Ui, sign: Sign, name: &str, hint: String) -> bool {
    const WIDTH: f32 = 30.0;
    const APART: f32 = 7.0;
    let button = Button::new("").min_size(vec2(WIDTH, 0.0));
    let response = ui.add(button);
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, name));
    let (middle, painter) = (response.rect.center(), ui.painter());
    let color = ui.visuals().text_color();
    let side = if sign == Sign::Before { -APART } else { APART };
    painter.add(mark(middle - vec2(side, 0.0), key_color(ui), 0.75));
    let at = middle + vec2(side, 0.0);
    let stroke = Stroke::new(1.5, color);
    match sign {
        Sign::Before | Sign::After => {
            let tip = if sign == Sign::Before { -3.5 } else { 3.5 };
            let corners = [vec2(tip, 0.0), vec2(-tip, -4.0), vec2(-tip, 4.0)].map(|corner| at + corner);
            painter.add(Shape::convex_polygon(corners.into(), color, Stroke::NONE));
        }
        Sign::Plus | Sign::Minus => {
            painter.hline(at.x - 3.5..=at.x + 3.5, at.y, stroke);
            if sign == Sign::Plus {
                painter.vline(at.x, at.y - 3.5..=at.y + 3.5, stroke);
            }
        }
    }
    response.on_hover_text(hint).clicked()
}

/// The colour of keys.
pub(crate) fn key_color(ui: &Ui) -> Color32 {
    match ui.visuals().dark_mode {
        true => Color32::from_rgb(240, 190, 70),
        false => Color32::from_rgb(190, 120, 0),
    }
}

/// A diamond.
pub(crate) fn mark(place: Pos2, color: Color32, size: f32) -> Shape {
    let half = MARK * size;
    let corners = [vec2(0.0, -half), vec2(half, 0.0), vec2(0.0, half), vec2(-half, 0.0)];
    let corners = corners.map(|corner: Vec2| place + corner);
    Shape::convex_polygon(corners.to_vec(), color, Stroke::NONE)
}
