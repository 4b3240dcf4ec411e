//! Draws the tile over the surface, with its handles.

use bevy::math::Vec2;
use bevy_egui::egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, vec2};

use super::drag::Part;
use super::sheet::Tile;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::viewport::blocking::marks;

/// The edge of a square handle and the radius of the arm's end, in points.
const SQUARE: f32 = 8.0;
const KNOB: f32 = 5.0;
/// The length of the arm in points.
const ARM: f32 = 34.0;
const EDGE: Stroke = Stroke {
    width: 1.0,
    color: Color32::BLACK,
};

/// The two ends of the arm; None behind the camera. It points to the upper edge of the picture.
pub(super) fn arm(screen: &Screen, tile: &Tile) -> Option<[Pos2; 2]> {
    let foot = tile.point(screen, Vec2::new(0.5, 0.0))?;
    let middle = tile.point(screen, Vec2::splat(0.5))?;
    let up = (foot - middle).normalized();
    Some([foot, foot + ARM * up])
}

/// Paints the tile. `lit` is the part under the pointer or being dragged.
pub(super) fn paint(painter: &Painter, screen: &Screen, tile: &Tile, lit: Option<Part>) {
    let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].map(|share| tile.world(share));
    if lit == Some(Part::Inside) {
        marks::area(painter, screen, &corners);
    }
    // The borders between tiles, where there are not too many.
    if tile.span > 1.0 && tile.span <= 8.0 {
        let count = tile.span as usize;
        for place in (1..count).map(|line| line as f32 / tile.span) {
            for (from, to) in [
                (Vec2::new(place, 0.0), Vec2::new(place, 1.0)),
                (Vec2::new(0.0, place), Vec2::new(1.0, place)),
            ] {
                if let Some(ends) = screen.segment(tile.world(from), tile.world(to)) {
                    painter.line_segment(ends, Stroke::new(1.0, marks::COLOR.gamma_multiply(0.6)));
                }
            }
        }
    }
    marks::ring(painter, screen, &corners);
    let color = |part: Part| {
        if lit == Some(part) {
            Color32::WHITE
        } else {
            marks::COLOR
        }
    };
    if let Some([foot, end]) = arm(screen, tile) {
        painter.line_segment([foot, end], Stroke::new(3.4, Color32::from_black_alpha(120)));
        painter.line_segment([foot, end], Stroke::new(1.8, color(Part::Arm)));
        painter.circle(end, KNOB, color(Part::Arm), EDGE);
    }
    for (part, share) in Part::POINTS {
        let Some(at) = tile.point(screen, share) else { continue };
        let size = match part {
            Part::Edge(..) => vec2(SQUARE - 2.0, SQUARE - 2.0),
            _ => vec2(SQUARE, SQUARE),
        };
        let square = Rect::from_center_size(at, size);
        painter.rect(square, 1.0, color(part), EDGE, bevy_egui::egui::StrokeKind::Outside);
    }
    let origin = tile.point(screen, Vec2::splat(0.5));
    painter.extend(origin.map(|at| Shape::circle_filled(at, 2.5, marks::COLOR)));
}
