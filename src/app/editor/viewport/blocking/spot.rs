//! Places on the ground and on surfaces, on the points of the grid.

use bevy::math::Vec3;
use bevy_egui::egui::Pos2;

use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::blocking::block::Plane;
use crate::app::editor::command::blocking::snapped;

/// A place that something can be drawn from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    pub place: Vec3,
    pub plane: Plane,
}

/// The share of a step to which places across a plane are rounded, so that a surface at 0 is not at 0.0000001.
const ROUNDING: f32 = 1e-3;
/// The ground counts where it is no farther than this number of steps of the grid.
const FARTHEST: f32 = 2000.0;

impl Spot {
    /// The place under the pointer: on the surface that is seen there (its place and normal), else on the ground through the origin. `step` 0 rounds nothing.
    pub fn under(
        pointer: Pos2,
        seen: Option<[Vec3; 2]>,
        screen: &Screen,
        up: Vec3,
        grid: f32,
        step: f32,
    ) -> Option<Self> {
        let (place, normal) = match seen {
            Some([place, normal]) => (place, normal),
            None => {
                let place = on_plane(screen, pointer, Vec3::ZERO, up)?;
                let distance = screen.depth(place);
                if distance > FARTHEST * grid {
                    return None;
                }
                (place, up)
            }
        };
        let plane = Plane::of_normal(normal, up);
        Some(Self {
            place: rounded(place, &plane, grid, step),
            plane,
        })
    }
}

/// The place under the pointer on a plane; None where the pointer is above its horizon.
pub(super) fn on_plane(screen: &Screen, pointer: Pos2, through: Vec3, normal: Vec3) -> Option<Vec3> {
    let ray = screen.ray(pointer);
    let towards = ray.dir.dot(normal);
    let t = (through - ray.origin).dot(normal) / towards;
    let is_seen = t.is_finite() && t > 0.0 && towards.abs() > 1e-4 * ray.dir.length();
    is_seen.then(|| ray.at(t))
}

/// The point of the plane's grid nearest to a place of the plane. The grid is that of the world: its points are multiples of the step.
pub(super) fn rounded(place: Vec3, plane: &Plane, grid: f32, step: f32) -> Vec3 {
    let (along, across) = (plane.along, plane.across());
    let above = snapped(place.dot(plane.normal), ROUNDING * grid);
    let level = [along, across].map(|direction| direction * snapped(place.dot(direction), step));
    let place = level[0] + level[1] + plane.normal * above;
    // A zero has no minus in files.
    place + Vec3::ZERO
}
