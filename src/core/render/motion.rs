//! Motion vectors: the displacement of the surface that a pixel shows since the previous frame.
//!
//! Shapes are assumed to move as their transforms do: a surface point keeps its position in the shape's own space.

use std::sync::Arc;

use glam::Vec2;

use super::camera::Camera;
use crate::accel::{Hit, Tlas};
use crate::math::Ray;

/// The shapes and the camera of the previous frame. The shapes are numbered as those of the current picture.
#[derive(Clone, Debug)]
pub struct FrameBefore {
    /// The shapes in the previous frame.
    pub geometry: Arc<Tlas>,
    /// The camera in the previous frame.
    pub camera: Camera,
}

impl PartialEq for FrameBefore {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.geometry, &other.geometry) && self.camera == other.camera
    }
}

impl FrameBefore {
    /// The displacement in film coordinates, to the right and down, from the previous frame to this one: of the surface
    /// at `hit`, a hit of `ray` in `geometry`, or without one of the sky in the ray's direction. Zero for points behind
    /// one of the cameras.
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
