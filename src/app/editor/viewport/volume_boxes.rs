//! The boxes of the volumes of the selection's media, drawn into the picture.

use bevy::math::{Affine3A, Vec3};
use bevy_egui::egui::{self, Color32, Shape, Stroke};

use crate::app::editor::camera::screen::Screen;

const COLOR: Color32 = Color32::from_rgb(120, 210, 235);
const EDGE: Color32 = Color32::from_black_alpha(110);

/// Paints the edges. Each box is given as world from the unit cube.
pub(super) fn paint(painter: &egui::Painter, screen: &Screen, boxes: &[Affine3A]) {
    for ends in boxes.iter().flat_map(edges) {
        if let Some(ends) = screen.segment(ends[0], ends[1]) {
            painter.line_segment(ends, Stroke::new(2.5, EDGE));
            painter.extend(Shape::dashed_line(&ends, Stroke::new(1.2, COLOR), 5.0, 4.0));
        }
    }
}

/// The twelve edges of a box.
fn edges(world_from_unit: &Affine3A) -> [[Vec3; 2]; 12] {
    std::array::from_fn(|edge| {
        let (axis, corner) = (edge / 4, edge % 4);
        let (along, first, second) = (Vec3::AXES[axis], Vec3::AXES[(axis + 1) % 3], Vec3::AXES[(axis + 2) % 3]);
        let start = first * (corner & 1) as f32 + second * (corner >> 1) as f32;
        [start, start + along].map(|end| world_from_unit.transform_point3(end))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_has_twelve_edges_of_its_sides() {
        let size = Vec3::new(1.0, 2.0, 4.0);
        let all = edges(&(Affine3A::from_translation(Vec3::ONE) * Affine3A::from_scale(size)));
        for (axis, length) in size.to_array().into_iter().enumerate() {
            let along = all.iter().filter(|ends| {
                let way = ends[1] - ends[0];
                (way[axis] - length).abs() < 1e-6 && (way.length() - length).abs() < 1e-6
            });
            assert_eq!(along.count(), 4);
        }
        let mut starts: Vec<String> = all.iter().map(|ends| format!("{ends:?}")).collect();
        starts.sort();
        starts.dedup();
        assert_eq!(starts.len(), 12);
    }
}
