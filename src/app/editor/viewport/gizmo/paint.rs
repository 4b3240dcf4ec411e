//! Paints the gizmo.

use bevy::math::Vec3;
use bevy_egui::egui::epaint::RectShape;
use bevy_egui::egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, Vec2};

use super::Frame;
use super::constraint::Constraint;
use super::drag::{Change, Drag};
use super::handles::{Form, Handle, MIDDLE, TIP};
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::camera::snapping::SnapPoint;
use crate::app::editor::command::gizmo_settings::Mode;
use crate::app::editor::command::snapping::SnapTo;
use crate::app::editor::picture::axis_colors::AXIS_COLORS;

const NEUTRAL: Color32 = Color32::from_gray(225);
const LIT: Color32 = Color32::from_rgb(255, 214, 64);
/// The dark edge of every handle, so that it is visible on any picture.
const SHADOW: Color32 = Color32::from_black_alpha(190);
/// The width of that edge at each side, in points.
const EDGE: f32 = 1.0;
const LINE: f32 = 2.5;
/// The width of the line along the axis of a drag.
const GUIDE: f32 = 1.0;
/// Half the size of the mark at a snapped place, in points.
const MARK: f32 = 6.0;

/// The handles; `lit` is the one under the pointer.
pub fn paint(painter: &Painter, handles: &[Handle], mode: Mode, lit: Option<Constraint>) {
    for handle in handles {
        let is_lit = lit == Some(handle.constraint);
        let color = if is_lit { LIT } else { color_of(handle.constraint) };
        match &handle.form {
            Form::Line([start, tip]) => {
                line(painter, &[*start, *tip], color, LINE);
                painter.add(if mode == Mode::Scale {
                    block(*tip, color)
                } else {
                    arrow_head(*start, *tip, color)
                });
            }
            Form::Square(corners) => {
                let fill = color.gamma_multiply(if is_lit { 0.75 } else { 0.35 });
                let edge = Stroke::new(1.0 + 2.0 * EDGE, SHADOW);
                painter.add(Shape::closed_line(corners.to_vec(), edge));
                painter.add(Shape::convex_polygon(corners.to_vec(), fill, Stroke::new(1.0, color)));
            }
            Form::Ring { front, back } => {
                for ends in back {
                    painter.line_segment(*ends, Stroke::new(1.0, color.gamma_multiply(0.35)));
                }
                let width = if is_lit { LINE + 1.0 } else { LINE };
                for (stroke, ends) in [
                    (Stroke::new(width + 2.0 * EDGE, SHADOW), front),
                    (Stroke::new(width, color), front),
                ] {
                    painter.extend(ends.iter().map(|ends| Shape::line_segment(*ends, stroke)));
                }
            }
            Form::Circle { middle, radius } if *radius <= MIDDLE => {
                painter.circle_stroke(*middle, *radius, Stroke::new(1.5 + 2.0 * EDGE, SHADOW));
                painter.circle(*middle, *radius, color.gamma_multiply(0.3), Stroke::new(1.5, color));
            }
            Form::Circle { middle, radius } => {
                painter.circle_stroke(*middle, *radius, Stroke::new(1.5 + 2.0 * EDGE, SHADOW));
                painter.circle_stroke(*middle, *radius, Stroke::new(1.5, color));
            }
        }
    }
}

/// Paints a drag instead of the handles: the axes of its constraint, and in a rotation the line from the middle to the
/// pointer.
pub(crate) fn paint_drag(
    painter: &Painter,
    drag: &Drag,
    change: Option<Change>,
    screen: &Screen,
    pointer: Option<Pos2>,
) {
    let Frame { mut origin, axes } = drag.frame;
    if let Some(Change::Moved(by) | Change::Laid { by, .. }) = change {
        origin += by;
    }
    let held_to: Vec<usize> = match (drag.constraint, drag.mode()) {
        (Constraint::Axis(k), _) | (Constraint::Plane(k), Mode::Rotate) => vec![k],
        (Constraint::Plane(normal), _) => (0..3).filter(|&k| k != normal).collect(),
        (Constraint::Free, _) => Vec::new(),
    };
    let far = 40.0 * screen.picture.width() * screen.units_per_point(screen.depth(origin));
    for k in held_to {
        let reach: Vec3 = axes[k] * far;
        if let Some(ends) = screen.segment(origin - reach, origin + reach) {
            line(painter, &ends, AXIS_COLORS[k], GUIDE);
        }
    }
    let Some(middle) = screen.project(origin) else { return };
    if let (Mode::Rotate | Mode::Scale, Some(pointer)) = (drag.mode(), pointer) {
        line(painter, &[middle, pointer], NEUTRAL, GUIDE);
    }
    painter.circle_filled(middle, 3.5, LIT);
}

/// Marks a snapped place: a square for a corner, a triangle for an edge, a ring for a surface.
pub(crate) fn paint_snap(painter: &Painter, point: &SnapPoint, screen: &Screen) {
    let Some(at) = screen.project(point.place) else { return };
    let corners = match point.of {
        SnapTo::Faces => {
            painter.circle_stroke(at, MARK, Stroke::new(LINE + 1.5, SHADOW));
            painter.circle_stroke(at, MARK, Stroke::new(LINE, LIT));
            return;
        }
        SnapTo::Edges => vec![
            at - MARK * Vec2::Y,
            at + MARK * Vec2::new(1.0, 0.8),
            at + MARK * Vec2::new(-1.0, 0.8),
        ],
        SnapTo::Vertices | SnapTo::Grid | SnapTo::Increments => [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| at + MARK * Vec2::new(x, y))
            .to_vec(),
    };
    for stroke in [Stroke::new(LINE + 1.5, SHADOW), Stroke::new(LINE, LIT)] {
        painter.add(Shape::closed_line(corners.clone(), stroke));
    }
}

fn color_of(constraint: Constraint) -> Color32 {
    match constraint {
        Constraint::Axis(k) | Constraint::Plane(k) => AXIS_COLORS[k],
        Constraint::Free => NEUTRAL,
    }
}

fn line(painter: &Painter, ends: &[Pos2; 2], color: Color32, width: f32) {
    painter.line_segment(*ends, Stroke::new(width + 2.0 * EDGE, SHADOW));
    painter.line_segment(*ends, Stroke::new(width, color));
}

fn arrow_head(start: Pos2, tip: Pos2, color: Color32) -> Shape {
    let along = (tip - start).normalized() * TIP;
    let across = Vec2::new(-along.y, along.x);
    let corners = vec![tip + 1.6 * along, tip - across - along, tip + across - along];
    Shape::convex_polygon(corners, color, Stroke::new(EDGE, SHADOW))
}

fn block(tip: Pos2, color: Color32) -> Shape {
    let rect = Rect::from_center_size(tip, Vec2::splat(2.0 * TIP));
    Shape::Rect(RectShape::new(
        rect,
        1.0,
        color,
        Stroke::new(EDGE, SHADOW),
        StrokeKind::Outside,
    ))
}
