//! The plane of the grid: the ground, or in an orthographic view along an axis the plane that faces the viewer; and the
//! step of the grid there.

use bevy::math::Vec3;

use super::screen::Screen;
use crate::app::editor::command::grid_settings::GridSettings;
use crate::math::Ray;

/// A plane through the world's origin that two axes of the world span.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPlane {
    /// The unit axes in the plane.
    pub axes: [Vec3; 2],
    /// The unit normal, an axis of the world.
    pub normal: Vec3,
}

/// The cosine of the largest angle between an axis and the view direction that counts as a view along the axis.
const ALONG: f32 = 0.99999;
/// The largest distance of the point that decides the step, in heights above the plane.
const FARTHEST: f32 = 6.0;
/// The least height of a camera above the plane, as a share of the distance to the origin.
const LOWEST: f32 = 1e-3;

impl GridPlane {
    /// The plane for a view. `up` is the world's upward axis.
    pub fn of(screen: &Screen, up: Vec3) -> Self {
        let forward = screen.forward();
        let is_along = screen.camera.is_orthographic() && forward.abs().max_element() > ALONG;
        Self::across(if is_along { forward } else { up })
    }

    /// The plane whose normal is the axis nearest to a direction.
    fn across(direction: Vec3) -> Self {
        match direction.abs().max_position() {
            0 => Self {
                axes: [Vec3::Y, Vec3::Z],
                normal: Vec3::X,
            },
            1 => Self {
                axes: [Vec3::X, Vec3::Z],
                normal: Vec3::Y,
            },
            _ => Self {
                axes: [Vec3::X, Vec3::Y],
                normal: Vec3::Z,
            },
        }
    }

    /// The point where a ray meets the plane ahead of the ray's origin; None if it does not.
    pub fn hit(&self, ray: &Ray) -> Option<Vec3> {
        let t = -self.normal.dot(ray.origin) / self.normal.dot(ray.dir);
        (t.is_finite() && t >= 0.0).then(|| ray.at(t))
    }

    /// The point of the plane in the middle of the view. Its distance is limited, even if the view is above the
    /// horizon.
    pub fn middle(&self, screen: &Screen) -> Vec3 {
        let ray = screen.ray(screen.picture.center());
        let eye = ray.origin;
        let hit = self.hit(&ray);
        if screen.camera.is_orthographic() {
            return hit.unwrap_or(eye - self.normal * self.normal.dot(eye));
        }
        let height = self.normal.dot(eye);
        let foot = eye - self.normal * height;
        let farthest = FARTHEST * height.abs();
        match hit {
            Some(hit) if hit.distance(foot) <= farthest => hit,
            _ => {
                let level = ray.dir - self.normal * self.normal.dot(ray.dir);
                foot + level.normalize_or_zero() * farthest
            }
        }
    }

    /// The distance between the lines of the grid in world units.
    pub fn step(&self, screen: &Screen, settings: &GridSettings) -> f32 {
        let middle = self.middle(screen);
        let eye = screen.ray(screen.picture.center()).origin;
        let least = LOWEST * eye.length().max(1e-3);
        settings.step_at(screen.units_per_point(screen.depth(middle).max(least)))
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Affine3A;

    use super::super::screen::tests::{orthographic, perspective};
    use super::*;
    use crate::render::camera::Camera;

    fn above(height: f32, degrees_down: f32) -> Screen {
        let turn = Affine3A::from_rotation_x(degrees_down.to_radians());
        let pose = Affine3A::from_translation(Vec3::Y * height) * turn;
        Screen {
            camera: Camera::new(pose, 90.0, 4.0 / 3.0, 0.01, 1000.0, None),
            ..perspective()
        }
    }

    #[test]
    fn a_parallel_view_along_an_axis_has_a_grid_that_faces_it() {
        assert_eq!(GridPlane::of(&orthographic(), Vec3::Y).normal, Vec3::Z);
        assert_eq!(GridPlane::of(&perspective(), Vec3::Y).normal, Vec3::Y);
        assert_eq!(GridPlane::of(&perspective(), Vec3::Z).normal, Vec3::Z);
    }

    #[test]
    fn the_middle_is_where_one_looks_but_never_beyond_the_horizon() {
        let plane = GridPlane::across(Vec3::Y);
        let middle = plane.middle(&above(2.0, 45.0));
        assert!(middle.abs_diff_eq(Vec3::new(0.0, 0.0, 2.0), 1e-4), "{middle}");
        for degrees in [1.0, -20.0] {
            let middle = plane.middle(&above(2.0, degrees));
            assert!(middle.abs_diff_eq(Vec3::new(0.0, 0.0, 12.0), 1e-3), "{middle}");
        }
    }

    #[test]
    fn the_step_grows_with_the_distance() {
        let (plane, settings) = (GridPlane::across(Vec3::Y), GridSettings::default());
        let step = |height| plane.step(&above(height, 45.0), &settings);
        assert!((step(1.0) - 0.1).abs() < 1e-6, "{}", step(1.0));
        assert!((step(10.0) - 1.0).abs() < 1e-5 && (step(100.0) - 10.0).abs() < 1e-4);
        assert!(step(0.0).is_finite() && step(0.0) > 0.0);
    }
}
