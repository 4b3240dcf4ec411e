//! Perspective cameras with a pinhole or a thin lens (PBR 4th ed., section 5.2).
//!
//! Camera space looks along +z with +x to the left and +y up, as in the scene format.

use glam::{Affine3A, Vec2, Vec3};

use crate::math::Ray;
use crate::sampling::warp;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinLens {
    /// World units.
    pub aperture_radius: f32,
    /// Distance of the sharp plane along the view axis.
    pub focus_distance: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    world_from_camera: Affine3A,
    /// Half extent of the image plane at distance 1.
    half_extent: Vec2,
    near: f32,
    far: f32,
    lens: Option<ThinLens>,
}

impl Camera {
    /// `world_from_camera` is rigid; `fov_x` in degrees, in (0, 180); `aspect` is width over height; `near` and `far` are distances
    /// along the view axis.
    pub fn new(
        world_from_camera: Affine3A,
        fov_x: f32,
        aspect: f32,
        near: f32,
        far: f32,
        lens: Option<ThinLens>,
    ) -> Self {
        let half_width = (0.5 * fov_x.to_radians()).tan();
        Self {
            world_from_camera,
            half_extent: Vec2::new(half_width, half_width / aspect),
            near,
            far,
            lens,
        }
    }

    /// The ray through `film`, (0, 0) at the top left and (1, 1) at the bottom right of the picture; `u_lens` in [0, 1)^2.
    ///
    /// Its direction has unit length; it begins at the near plane and ends at the far plane.
    pub fn ray(&self, film: Vec2, u_lens: Vec2) -> Ray {
        let on_plane = (1.0 - 2.0 * film) * self.half_extent;
        let (origin, toward) = match self.lens {
            None => (Vec3::ZERO, on_plane.extend(1.0)),
            Some(lens) => {
                let origin = (lens.aperture_radius * warp::concentric_disk(u_lens)).extend(0.0);
                (origin, lens.focus_distance * on_plane.extend(1.0) - origin)
            }
        };
        let dir = toward.normalize();
        // Distance along the ray per distance along the view axis.
        let stretch = 1.0 / dir.z;
        Ray {
            origin: self
                .world_from_camera
                .transform_point3(origin + self.near * stretch * dir),
            dir: self.world_from_camera.transform_vector3(dir),
            t_max: (self.far - self.near) * stretch,
        }
    }

    /// World to film coordinates as in [`Self::ray`], with the distance along the view axis; for drawing over the picture.
    /// Points with a distance of zero or less are behind the camera and their film coordinates mean nothing.
    pub fn project(&self, world: Vec3) -> (Vec2, f32) {
        let p = self.world_from_camera.inverse().transform_point3(world);
        let film = 0.5 * (1.0 - p.truncate() / p.z / self.half_extent);
        (film, p.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(lens: Option<ThinLens>) -> Camera {
        Camera::new(Affine3A::IDENTITY, 90.0, 2.0, 0.5, 10.0, lens)
    }

    #[test]
    fn left_of_the_picture_is_plus_x_and_top_is_plus_y() {
        let ray = camera(None).ray(Vec2::ZERO, Vec2::splat(0.5));
        let at_one = ray.dir / ray.dir.z;
        assert!(at_one.abs_diff_eq(Vec3::new(1.0, 0.5, 1.0), 1e-6), "{at_one}");
    }

    #[test]
    fn rays_run_from_the_near_to_the_far_plane() {
        let ray = camera(None).ray(Vec2::new(0.1, 0.8), Vec2::splat(0.5));
        assert!((ray.origin.z - 0.5).abs() < 1e-6);
        assert!((ray.at(ray.t_max).z - 10.0).abs() < 1e-5);
    }

    #[test]
    fn a_lens_is_sharp_in_its_focal_plane_only() {
        let camera = camera(Some(ThinLens {
            aperture_radius: 0.3,
            focus_distance: 4.0,
        }));
        let at = |u: Vec2, z: f32| {
            let ray = camera.ray(Vec2::new(0.3, 0.6), u);
            ray.at((z - ray.origin.z) / ray.dir.z)
        };
        let (a, b) = (Vec2::new(0.1, 0.2), Vec2::new(0.9, 0.7));
        assert!(at(a, 4.0).abs_diff_eq(at(b, 4.0), 1e-5));
        assert!(at(a, 2.0).distance(at(b, 2.0)) > 0.1);
    }

    #[test]
    fn project_inverts_ray() {
        let camera = camera(None);
        let film = Vec2::new(0.2, 0.9);
        let (back, depth) = camera.project(camera.ray(film, Vec2::ZERO).at(3.0));
        assert!(back.abs_diff_eq(film, 1e-5) && depth > 0.0);
    }
}
