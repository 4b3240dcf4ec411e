//! The boxes of the copies that a series would make, drawn over the picture while its form is open.

use bevy::math::Vec3;
use bevy_egui::egui::{Color32, Painter, Stroke};

use super::blocking::marks::COLOR;
use super::extent::edges;
use super::gizmo::Target;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::arrange::Series;
use crate::math::Aabb;

/// The most boxes that are drawn. If there are more, each copy has one box around everything, and the last copies none.
const MOST: usize = 600;

/// Draws a box for each copy.
pub(super) fn paint(painter: &Painter, screen: &Screen, series: &Series, targets: &[Target]) {
    for [from, to] in lines(series, targets) {
        if let Some(ends) = screen.segment(from, to) {
            painter.line_segment(ends, Stroke::new(2.4, Color32::from_black_alpha(110)));
            painter.line_segment(ends, Stroke::new(1.0, COLOR));
        }
    }
}

/// The edges of the boxes of the copies, in world space.
fn lines(series: &Series, targets: &[Target]) -> Vec<[Vec3; 2]> {
    let mut boxes: Vec<Aabb> = targets.iter().filter_map(|target| target.bounds).collect();
    let copies = series.count.saturating_sub(1) as usize;
    if boxes.len().saturating_mul(copies) > MOST {
        boxes = boxes.into_iter().reduce(Aabb::union).into_iter().collect();
    }
    let sides: Vec<[Vec3; 2]> = boxes
        .iter()
        .flat_map(|bounds| [0, 1, 2].map(|axis| edges(bounds, axis)).concat())
        .collect();
    (1..=copies.min(MOST) as u32)
        .flat_map(|number| {
            let map = series.map(number);
            sides.iter().map(move |side| side.map(|end| map.transform_point3(end)))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use bevy::math::Affine3A;
    use bevy::prelude::World;

    use super::*;
    use crate::app::editor::command::arrange::Way;
    use crate::app::editor::model::freedom::Freedom;

    fn target(at: Vec3) -> Target {
        Target {
            entity: World::new().spawn_empty().id(),
            to_world: Affine3A::from_translation(at),
            freedom: Freedom::Affine,
            bounds: Some(Aabb { min: at, max: at + 1.0 }),
        }
    }

    fn bounds(lines: &[[Vec3; 2]]) -> Aabb {
        Aabb::from_points(lines.iter().flatten().copied())
    }

    #[test]
    fn each_copy_has_the_boxes_of_what_is_copied() {
        let targets = [target(Vec3::X), target(Vec3::Y)];
        let row = Series {
            count: 4,
            way: Way::Along(Vec3::X * 2.0),
            instances: false,
        };
        let shown = lines(&row, &targets);
        assert_eq!(shown.len(), 3 * 2 * 12);
        // The original is seen in the picture already.
        assert_eq!(bounds(&shown), bounds(&[[Vec3::X * 2.0, Vec3::new(8.0, 2.0, 1.0)]]));
        let ring = Series {
            way: Way::Around {
                axis: 1,
                degrees: 360.0,
                center: Vec3::ZERO,
            },
            ..row
        };
        // The second of four is opposite.
        let opposite = &lines(&ring, &targets[..1])[12..24];
        assert!(
            opposite.iter().flatten().all(|end| end.x < -0.99 && end.z < 1e-5),
            "{opposite:?}"
        );
        let long = Series { count: 9_999, ..row };
        assert!(lines(&long, &targets).len() <= MOST * 12);
    }
}
