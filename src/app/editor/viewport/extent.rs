//! The box around the selection with its dimensions, drawn over the picture.

use bevy::math::Vec3;
use bevy_egui::egui::{Color32, Painter, Pos2, Stroke};

use super::marks::Tags;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::picture::axis_colors::AXIS_COLORS;
use crate::math::Aabb;
use crate::scene::LengthUnit;

/// Draws the edges of the box, and its extents beside three of them.
pub(super) fn paint(painter: &Painter, screen: &Screen, bounds: &Aabb, unit: LengthUnit, tags: &mut Tags) {
    let Some(middle) = screen.project(bounds.center()) else {
        return;
    };
    let extent = bounds.extent();
    for axis in 0..3 {
        // A box that is flat along an axis has no edges there.
        if extent[axis] <= 1e-5 * extent.max_element() {
            continue;
        }
        let color = AXIS_COLORS[axis].gamma_multiply(0.7);
        let edges = edges(bounds, axis);
        for [from, to] in edges {
            if let Some(ends) = screen.segment(from, to) {
                painter.line_segment(ends, Stroke::new(3.0, Color32::from_black_alpha(70)));
                painter.line_segment(ends, Stroke::new(1.0, color));
            }
        }
        let middles = edges.map(|[from, to]| screen.project(from.midpoint(to)));
        let outward = |at: &Pos2| (*at - middle).length_sq() + at.y - middle.y;
        let outermost = middles
            .into_iter()
            .flatten()
            .max_by(|a, b| outward(a).total_cmp(&outward(b)));
        if let Some(at) = outermost {
            let text = format!("{} {}", ["X", "Y", "Z"][axis], unit.text(extent[axis]));
            tags.tag(painter, at, &text);
        }
    }
}

/// The four edges along an axis.
pub(super) fn edges(bounds: &Aabb, axis: usize) -> [[Vec3; 2]; 4] {
    let [beside, other] = [(axis + 1) % 3, (axis + 2) % 3];
    [(false, false), (false, true), (true, true), (true, false)].map(|(far, high)| {
        let mut from = bounds.min;
        from[beside] = if far { bounds.max[beside] } else { bounds.min[beside] };
        from[other] = if high { bounds.max[other] } else { bounds.min[other] };
        let mut to = from;
        to[axis] = bounds.max[axis];
        [from, to]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_four_edges_along_each_axis() {
        let bounds = Aabb {
            min: Vec3::ZERO,
            max: Vec3::new(1.0, 2.0, 3.0),
        };
        for axis in 0..3 {
            for [from, to] in edges(&bounds, axis) {
                assert_eq!((to - from).length(), bounds.max[axis]);
                assert!(from[axis] == 0.0 && to.cmple(bounds.max).all());
            }
        }
    }
}
