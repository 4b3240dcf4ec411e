//! Motion in the picture: how far the surface that a pixel shows has moved since the frame before.
//!
//! Shapes are taken to be rigid, or at least to move as their transforms do: a point of a surface stays at its place in
//! the shape's own space.

use std::sync::Arc;

use glam::Vec2;

use super::camera::Camera;
use crate::accel::{Hit, Tlas};
use crate::math::Ray;

/// The shapes and the camera of the frame before. The shapes are numbered as those of the present picture.
#[derive(Clone, Debug)]
pub struct FrameBefore {
    /// The shapes at their places then.
    pub geometry: Arc<Tlas>,
    /// The camera then.
    pub camera: Camera,
}

impl PartialEq for FrameBefore {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.geometry, &other.geometry) && self.camera == other.camera
    }
}

impl FrameBefore {
    /// The way in film coordinates, to the right and down, from where the camera showed it then to where it shows it
    /// now: the surface at `hit`, which `ray` has met in `geometry`, or the sky in the direction of the ray if
    /// there is none. Zero for places that one of the cameras has behind it.
    pub(super) fn motion(&self, geometry: &Tlas, camera: &Camera, ray: &Ray, hit: Option<&Hit>) -> Vec2 {
        let (now, then) = match hit {
            Some(hit) => {
                let place = geometry.surface(ray, hit).position;
                let [now, then] = [
                    camera.project(place),
                    self.camera.project(geometry.place_in(&self.geometry, hit, place)),
                ];
                let in_front = |(film, depth): (Vec2, f32)| (depth > 0.0).then_some(film);
                (in_front(now), in_front(then))
            }
            None => (
                camera.project_direction(ray.dir),
                self.camera.project_direction(ray.dir),
            ),
        };
        match (now, then) {
            (Some(now), Some(then)) => now - then,
            _ => Vec2::ZERO,
        }
    }
}
