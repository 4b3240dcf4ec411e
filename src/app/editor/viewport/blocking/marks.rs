//! Lines over the picture for the drawing, the pushed face or the cut.

use bevy::math::Vec3;
use bevy_egui::egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, StrokeKind, vec2};

use crate::app::editor::camera::screen::Screen;
use crate::app::editor::viewport::marks::tag_beside;

pub(in crate::app::editor::viewport) const COLOR: Color32 = Color32::from_rgb(255, 214, 64);
pub(super) const FILL: Color32 = Color32::from_rgba_premultiplied(50, 42, 12, 60);
const SHADOW: Color32 = Color32::from_black_alpha(120);
const WIDTH: f32 = 1.8;

/// A segment in world space, with a dark edge so that it is visible on any picture.
pub(super) fn segment(painter: &Painter, screen: &Screen, a: Vec3, b: Vec3) {
    if let Some(ends) = screen.segment(a, b) {
        painter.line_segment(ends, Stroke::new(WIDTH + 1.6, SHADOW));
        painter.line_segment(ends, Stroke::new(WIDTH, COLOR));
    }
}

/// A closed line through points in world space.
pub(in crate::app::editor::viewport) fn ring(painter: &Painter, screen: &Screen, places: &[Vec3]) {
    for (a, b) in places.iter().zip(places.iter().cycle().skip(1)) {
        segment(painter, screen, *a, *b);
    }
}

/// A flat convex polygon in world space, lightly tinted; nothing if a part of it is behind the camera.
pub(in crate::app::editor::viewport) fn area(painter: &Painter, screen: &Screen, places: &[Vec3]) {
    let points: Option<Vec<Pos2>> = places.iter().map(|place| screen.project(*place)).collect();
    if let Some(points) = points {
        painter.add(Shape::convex_polygon(points, FILL, Stroke::NONE));
    }
}

/// A text beside a point in world space.
pub(super) fn text(painter: &Painter, screen: &Screen, place: Vec3, text: &str) {
    if let Some(at) = screen.project(place) {
        tag_beside(painter, at + vec2(14.0, 14.0), text);
    }
}

/// A square at a corner that the pointer snaps to, or a dot on an edge.
pub(super) fn caught(painter: &Painter, screen: &Screen, place: Vec3, is_corner: bool) {
    let Some(at) = screen.project(place) else { return };
    if is_corner {
        let square = Rect::from_center_size(at, vec2(9.0, 9.0));
        painter.rect(square, 0.0, COLOR, Stroke::new(1.0, SHADOW), StrokeKind::Outside);
    } else {
        painter.circle(at, 4.0, COLOR, Stroke::new(1.0, SHADOW));
    }
}
