//! Maps between the world and the window: the point of the window for a position, and the ray through a point of the
//! window.

use bevy::math::{Vec2, Vec3};
use bevy_egui::egui::{Pos2, Rect};

use crate::math::Ray;
use crate::render::camera::Camera;

/// A picture in the window and the camera that took it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screen {
    /// The camera that the picture was rendered with.
    pub camera: Camera,
    /// The rectangle of the picture, in points.
    pub picture: Rect,
}

impl Screen {
    /// The film coordinates of a point, (0, 0) top left, (1, 1) bottom right; beyond that outside the picture.
    pub fn film(&self, at: Pos2) -> Vec2 {
        let film = (at - self.picture.min) / self.picture.size();
        Vec2::new(film.x, film.y)
    }

    pub(crate) fn point_of_film(&self, film: Vec2) -> Pos2 {
        self.picture.min + bevy_egui::egui::vec2(film.x, film.y) * self.picture.size()
    }

    /// The point of the window for a position in world space; None behind the camera.
    pub fn project(&self, world: Vec3) -> Option<Pos2> {
        let (film, depth) = self.camera.project(world);
        (depth > 0.0 && film.is_finite()).then(|| self.point_of_film(film))
    }

    /// The part of a segment that is in front of the camera.
    pub(crate) fn segment(&self, a: Vec3, b: Vec3) -> Option<[Pos2; 2]> {
        segment(&self.camera, a, b).map(|ends| ends.map(|film| self.point_of_film(film)))
    }

    /// Distance along the view axis; negative behind the camera.
    pub(crate) fn depth(&self, world: Vec3) -> f32 {
        self.camera.project(world).1
    }

    pub(crate) fn unproject(&self, at: Pos2, depth: f32) -> Vec3 {
        self.camera.unproject(self.film(at), depth)
    }

    /// The ray through a point of the window, through the middle of the lens. Its `t` is the distance along the view
    /// axis.
    pub fn ray(&self, at: Pos2) -> Ray {
        let origin = self.unproject(at, 0.0);
        Ray::new(origin, self.unproject(at, 1.0) - origin)
    }

    /// The unit view direction: the normal of the image plane, whatever crop of it the picture is.
    pub fn forward(&self) -> Vec3 {
        let [corner, right, below] = [Vec2::ZERO, Vec2::X, Vec2::Y].map(|film| self.camera.unproject(film, 1.0));
        let normal = (right - corner).cross(below - corner).normalize_or_zero();
        let ahead = corner - self.camera.unproject(Vec2::ZERO, 0.0);
        normal * normal.dot(ahead).signum()
    }

    /// The unit direction from the viewer to a point in world space.
    pub fn direction_to(&self, world: Vec3) -> Vec3 {
        let (film, _) = self.camera.project(world);
        (self.camera.unproject(film, 1.0) - self.camera.unproject(film, 0.0)).normalize_or_zero()
    }

    /// The width in world units of one point of the window at this distance along the view axis.
    pub(crate) fn units_per_point(&self, depth: f32) -> f32 {
        let across = self.camera.unproject(Vec2::X, depth) - self.camera.unproject(Vec2::ZERO, depth);
        across.length() / self.picture.width()
    }
}

/// A segment in world space as film coordinates; None if all of it is behind the camera.
pub(crate) fn segment(camera: &Camera, a: Vec3, b: Vec3) -> Option<[Vec2; 2]> {
    let ((film_a, depth_a), (film_b, depth_b)) = (camera.project(a), camera.project(b));
    let nearest = 1e-3 * depth_a.abs().max(depth_b.abs());
    match (depth_a > nearest, depth_b > nearest) {
        (true, true) => Some([film_a, film_b]),
        (false, false) => None,
        // Depth is linear along the segment, so the hidden end is moved to just before the camera.
        (a_seen, _) => {
            let cut = a.lerp(b, (nearest - depth_a) / (depth_b - depth_a));
            let (film_cut, _) = camera.project(cut);
            Some(if a_seen { [film_a, film_cut] } else { [film_cut, film_b] })
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use bevy::math::Affine3A;

    use super::*;

    /// A screen of 400 x 300 points from (50, 20) on, seen from z = -8 with 90 degrees across.
    pub fn perspective() -> Screen {
        let pose = Affine3A::from_translation(Vec3::new(0.0, 0.0, -8.0));
        Screen {
            camera: Camera::new(pose, 90.0, 4.0 / 3.0, 0.01, 1000.0, None),
            picture: picture(),
        }
    }

    /// The same window, sixteen units wide.
    pub fn orthographic() -> Screen {
        let pose = Affine3A::from_translation(Vec3::new(0.0, 0.0, -8.0));
        Screen {
            camera: Camera::orthographic(pose, Vec2::new(8.0, 6.0), 0.01, 1000.0),
            picture: picture(),
        }
    }

    fn picture() -> Rect {
        Rect::from_min_size(Pos2::new(50.0, 20.0), bevy_egui::egui::vec2(400.0, 300.0))
    }

    #[test]
    fn points_and_places_agree() {
        for screen in [perspective(), orthographic()] {
            let world = Vec3::new(1.0, -2.0, 3.0);
            let at = screen.project(world).expect("it is in front");
            let back = screen.ray(at).at(screen.depth(world));
            assert!(back.abs_diff_eq(world, 1e-4), "{back}");
            assert!(screen.forward().abs_diff_eq(Vec3::Z, 1e-5));
            // Both views are sixteen units and 400 points wide at distance eight.
            assert!((screen.units_per_point(8.0) - 0.04).abs() < 1e-5);
            assert!(screen.project(Vec3::new(0.0, 0.0, -9.0)).is_none());
        }
    }

    #[test]
    fn a_cropped_picture_looks_the_same_way() {
        let whole = perspective();
        let part = Screen {
            camera: whole.camera.cropped(Vec2::new(0.6, 0.1), Vec2::new(0.9, 0.4)),
            ..whole
        };
        assert!(part.forward().abs_diff_eq(Vec3::Z, 1e-5), "{}", part.forward());
    }
}
