//! Cameras: perspective with a pinhole or a thin lens (PBR 4th ed., section 5.2), and orthographic.
//!
//! Camera space looks along +z with +x to the left and +y up, as in the scene format.

mod importance;

use std::f32::consts::TAU;

use glam::{Affine3A, DAffine3, DMat4, DVec3, DVec4, Mat3, Mat4, Vec2, Vec3};

use crate::accel::RayLanes;
use crate::math::lanes::{Lanes, Vec3Lanes};
use crate::math::{Aabb, Ray, Vector};
use crate::sampling::warp;

pub use importance::RayTo;

/// A thin lens with a circular or polygonal aperture: objects off the focus plane are blurred.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinLens {
    /// The radius in world units; of the circle around the blades' corners, if there are blades.
    pub aperture_radius: f32,
    /// Distance of the focus plane along the view axis.
    pub focus_distance: f32,
    /// The number of edges of the aperture; below 3 it is round.
    pub blades: u32,
    /// The rotation of the blades in radians, from the camera's +x towards +y. At 0 the first corner is at +x.
    pub blade_rotation: f32,
}

impl ThinLens {
    /// A uniform point of the aperture.
    fn sample(&self, u: Vec2) -> Vec2 {
        if self.blades < 3 {
            return self.aperture_radius * Vec2::from(warp::concentric_disk(u.to_array()));
        }
        let scaled = u.x * self.blades as f32;
        let blade = scaled.floor().min((self.blades - 1) as f32);
        let corner = |number: f32| {
            Vec2::from_angle(self.blade_rotation + TAU * number / self.blades as f32) * self.aperture_radius
        };
        let weights = warp::uniform_triangle(Vec2::new(scaled - blade, u.y));
        weights.x * corner(blade) + weights.y * corner(blade + 1.0)
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Projection {
    Perspective { lens: Option<ThinLens> },
    Orthographic,
}

/// The map from points of the film and of the lens to rays in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    world_from_camera: Affine3A,
    projection: Projection,
    /// The picture's top left on the image plane (of a perspective at distance 1), and (next) the vector from there to
    /// its bottom right.
    corner: Vec2,
    diagonal: Vec2,
    near: f32,
    far: f32,
}

impl Camera {
    /// A perspective camera. `world_from_camera` is rigid; `fov_x` is in degrees, in (0, 180); `aspect` is width over
    /// height; `near` and `far` are distances along the view axis.
    pub fn new(
        world_from_camera: Affine3A,
        fov_x: f32,
        aspect: f32,
        near: f32,
        far: f32,
        lens: Option<ThinLens>,
    ) -> Self {
        let half_width = (0.5 * fov_x.to_radians()).tan();
        let half_extent = Vec2::new(half_width, half_width / aspect);
        Self::with_plane(
            world_from_camera,
            Projection::Perspective { lens },
            half_extent,
            near,
            far,
        )
    }

    /// A camera of parallel rays; `half_extent` is that of the picture in world units, the rest as for [`Self::new`].
    pub fn orthographic(world_from_camera: Affine3A, half_extent: Vec2, near: f32, far: f32) -> Self {
        Self::with_plane(world_from_camera, Projection::Orthographic, half_extent, near, far)
    }

    fn with_plane(world_from_camera: Affine3A, projection: Projection, half_extent: Vec2, near: f32, far: f32) -> Self {
        Self {
            world_from_camera,
            projection,
            corner: half_extent,
            diagonal: -2.0 * half_extent,
            near,
            far,
        }
    }

    /// The camera for the part of this one's picture from `min` to `max`, in film coordinates of this one; they may be
    /// outside.
    pub fn cropped(self, min: Vec2, max: Vec2) -> Self {
        Self {
            corner: self.corner + min * self.diagonal,
            diagonal: (max - min) * self.diagonal,
            ..self
        }
    }

    /// The film coordinates, in the picture of a camera that looks the same way from the same place, of the point that
    /// is at `film` in this one's picture.
    pub fn film_of(&self, film: Vec2, other: &Self) -> Vec2 {
        (self.corner + film * self.diagonal - other.corner) / other.diagonal
    }

    /// Half the width and height of the picture on the image plane: of a perspective the tangents of half the angles of
    /// view, else in world units.
    pub fn half_extent(&self) -> Vec2 {
        0.5 * self.diagonal.abs()
    }

    /// The same camera with a pinhole at the centre of the lens, so that the whole scene is in focus.
    pub fn sharp(self) -> Self {
        let projection = match self.projection {
            Projection::Perspective { .. } => Projection::Perspective { lens: None },
            Projection::Orthographic => Projection::Orthographic,
        };
        Self { projection, ..self }
    }

    /// The ray through `film`, (0, 0) at the top left and (1, 1) at the bottom right of the picture; `u_lens` in [0,
    /// 1)^2.
    ///
    /// Its direction has unit length. Its origin is the pinhole, a point of the lens or of an orthographic camera's
    /// plane; it runs from the near plane to the far plane. The near plane is a `t_min`, because rounding would shift
    /// an origin there, by more the farther the camera is from the world's origin.
    pub fn ray(&self, film: Vec2, u_lens: Vec2) -> Ray {
        let on_plane = self.corner + film * self.diagonal;
        let (origin, toward) = match self.projection {
            Projection::Orthographic => (on_plane.extend(0.0), Vec3::Z),
            Projection::Perspective { lens: None } => (Vec3::ZERO, on_plane.extend(1.0)),
            Projection::Perspective { lens: Some(lens) } => {
                // The ray is aimed from its rounded origin, so that all rays through the lens meet in the plane of
                // focus.
                let origin = self.rounded(lens.sample(u_lens));
                (origin, lens.focus_distance * on_plane.extend(1.0) - origin)
            }
        };
        let dir = toward.normalize();
        // Distance along the ray per distance along the view axis.
        let stretch = 1.0 / dir.z;
        Ray {
            origin: self.world_from_camera.transform_point3(origin),
            dir: self.world_from_camera.transform_vector3(dir),
            t_min: ((self.near - origin.z) * stretch).max(0.0),
            t_max: (self.far - origin.z) * stretch,
        }
    }

    /// A point of the plane z = 0 of camera space, after rounding in world space.
    fn rounded(&self, point: Vec2) -> Vec3 {
        let place = self.world_from_camera.translation;
        let rounded = self.world_from_camera.transform_point3a(point.extend(0.0).into()) - place;
        (self.world_from_camera.matrix3.transpose() * rounded).into()
    }

    /// [`Self::ray`] for sixteen points of the film, by their x and y. None unless all rays go through one point.
    #[inline(always)]
    pub(crate) fn pinhole_rays(&self, film: [Lanes; 2]) -> Option<RayLanes> {
        if self.projection != (Projection::Perspective { lens: None }) {
            return None;
        }
        let on_plane =
            |film: Lanes, corner: f32, diagonal: f32| film.mul_add(Lanes::splat(diagonal), Lanes::splat(corner));
        let x = on_plane(film[0], self.corner.x, self.diagonal.x);
        let y = on_plane(film[1], self.corner.y, self.diagonal.y);
        // The reciprocal of the cosine with the view axis.
        let stretch = x.mul_add(x, y.mul_add(y, Lanes::ONE)).sqrt();
        let scale = Lanes::ONE / stretch;
        let columns = [
            self.world_from_camera.matrix3.x_axis,
            self.world_from_camera.matrix3.y_axis,
            self.world_from_camera.matrix3.z_axis,
        ];
        let [x_axis, y_axis, z_axis] = columns.map(|column| Vec3Lanes::splat(column.into()));
        let toward = z_axis.plus_scaled(x, x_axis).plus_scaled(y, y_axis);
        Some(RayLanes {
            origin: Vec3Lanes::splat(self.world_from_camera.translation.into()),
            dir: toward * scale,
            t_min: Lanes::splat(self.near) * stretch,
            t_max: Lanes::splat(self.far) * stretch,
        })
    }

    /// World to film coordinates as in [`Self::ray`], with the distance along the view axis; for drawing over the
    /// picture. Points with a distance of zero or less are behind the camera, and their film coordinates are
    /// meaningless.
    pub fn project(&self, world: Vec3) -> (Vec2, f32) {
        let p = self.world_from_camera.inverse().transform_point3(world);
        let on_plane = match self.projection {
            Projection::Orthographic => p.truncate(),
            Projection::Perspective { .. } => p.truncate() / p.z,
        };
        ((on_plane - self.corner) / self.diagonal, p.z)
    }

    /// The film coordinates of a direction in world space, for points at infinity; None behind the camera, and for
    /// parallel rays.
    pub fn project_direction(&self, direction: Vec3) -> Option<Vec2> {
        let toward = self.direction_in_camera(direction);
        let on_plane = toward.truncate() / toward.z;
        (!self.is_orthographic() && toward.z > 0.0).then(|| (on_plane - self.corner) / self.diagonal)
    }

    /// The inverse of [`Self::project`]: the point with these film coordinates and this distance along the view axis.
    pub fn unproject(&self, film: Vec2, depth: f32) -> Vec3 {
        let on_plane = self.corner + film * self.diagonal;
        let p = match self.projection {
            Projection::Orthographic => on_plane.extend(depth),
            Projection::Perspective { .. } => on_plane.extend(1.0) * depth,
        };
        self.world_from_camera.transform_point3(p)
    }

    /// The matrix from the world to the camera space of OpenEXR: x to the right of the picture, y up, z along the view
    /// axis.
    pub fn right_up_forward_from_world(&self) -> Mat4 {
        let to_right = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let world_from_camera = self.world_from_camera.as_daffine3();
        DMat4::from(to_right * world_from_camera.inverse()).as_mat4()
    }

    /// The projective matrix from the world to film coordinates as in [`Self::ray`], and depths from 0 at the near
    /// plane to 1 at the far plane.
    pub fn film_from_world(&self) -> Mat4 {
        let (corner, diagonal) = (self.corner.as_dvec2(), self.diagonal.as_dvec2());
        let (near, far) = (f64::from(self.near), f64::from(self.far));
        let (scale, shift) = (1.0 / diagonal, -corner / diagonal);
        let x = DVec4::new(scale.x, 0.0, 0.0, 0.0);
        let y = DVec4::new(0.0, scale.y, 0.0, 0.0);
        let shift = shift.extend(0.0);
        let depth = far / (far - near);
        let film_from_camera = match self.projection {
            Projection::Perspective { .. } => {
                let z = DVec4::new(shift.x, shift.y, depth, 1.0);
                DMat4::from_cols(x, y, z, DVec4::new(0.0, 0.0, -near * depth, 0.0))
            }
            Projection::Orthographic => {
                let z = DVec4::new(0.0, 0.0, 1.0 / (far - near), 0.0);
                DMat4::from_cols(x, y, z, DVec4::new(shift.x, shift.y, -near / (far - near), 1.0))
            }
        };
        (film_from_camera * DMat4::from(self.world_from_camera.as_daffine3().inverse())).as_mat4()
    }

    /// A direction of the world in camera space: x to the left of the picture, y up, z along the view axis.
    pub fn direction_in_camera(&self, world: Vec3) -> Vec3 {
        self.world_from_camera.matrix3.transpose() * world
    }

    /// The axes of camera space in the world, one after the other.
    pub fn axes(&self) -> [f32; 9] {
        self.world_from_camera.matrix3.to_cols_array()
    }

    /// A camera at the origin with these [axes](Self::axes), for directions only.
    pub fn of_axes(axes: &[f32; 9]) -> Self {
        let world_from_camera = Affine3A::from_mat3(Mat3::from_cols_array(axes));
        Self::orthographic(world_from_camera, Vec2::ONE, 0.0, 1.0)
    }

    /// The distances of the near and the far clip plane along the view axis.
    pub fn clip_distances(&self) -> (f32, f32) {
        (self.near, self.far)
    }

    /// The least and the largest distance along the view axis of a box's points; negative behind the camera.
    pub fn depth_range(&self, bounds: &Aabb) -> (f32, f32) {
        let forward = Vec3::from(self.world_from_camera.matrix3.z_axis);
        let center = (bounds.center() - Vec3::from(self.world_from_camera.translation)).dot(forward);
        let half = 0.5 * bounds.extent().dot(forward.abs());
        (center - half, center + half)
    }

    /// Whether all rays are parallel.
    pub fn is_orthographic(&self) -> bool {
        self.projection == Projection::Orthographic
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(lens: Option<ThinLens>) -> Camera {
        Camera::new(Affine3A::IDENTITY, 90.0, 2.0, 0.5, 10.0, lens)
    }

    fn orthographic() -> Camera {
        Camera::orthographic(Affine3A::IDENTITY, Vec2::new(3.0, 1.5), 0.5, 10.0)
    }

    fn lens(blades: u32) -> ThinLens {
        ThinLens {
            aperture_radius: 0.3,
            focus_distance: 4.0,
            blades,
            blade_rotation: 0.2,
        }
    }

    #[test]
    fn left_of_the_picture_is_plus_x_and_top_is_plus_y() {
        let ray = camera(None).ray(Vec2::ZERO, Vec2::splat(0.5));
        let at_one = ray.dir / ray.dir.z;
        assert!(at_one.abs_diff_eq(Vec3::new(1.0, 0.5, 1.0), 1e-6), "{at_one}");
        let ray = orthographic().ray(Vec2::ZERO, Vec2::splat(0.5));
        assert_eq!((ray.origin, ray.dir), (Vec3::new(3.0, 1.5, 0.0), Vec3::Z));
    }

    #[test]
    fn rays_run_from_the_near_to_the_far_plane() {
        for camera in [camera(None), camera(Some(lens(5))), orthographic()] {
            let ray = camera.ray(Vec2::new(0.1, 0.8), Vec2::splat(0.5));
            assert!((ray.at(ray.t_min).z - 0.5).abs() < 1e-6);
            assert!((ray.at(ray.t_max).z - 10.0).abs() < 1e-5);
        }
    }

    #[test]
    fn a_lens_is_sharp_in_its_focal_plane_only() {
        for blades in [0, 6] {
            let camera = camera(Some(lens(blades)));
            let at = |u: Vec2, z: f32| {
                let ray = camera.ray(Vec2::new(0.3, 0.6), u);
                ray.at((z - ray.origin.z) / ray.dir.z)
            };
            let (a, b) = (Vec2::new(0.1, 0.8), Vec2::new(0.6, 0.7));
            assert!(at(a, 4.0).abs_diff_eq(at(b, 4.0), 1e-5));
            assert!(at(a, 2.0).distance(at(b, 2.0)) > 0.1);
        }
    }

    #[test]
    fn project_inverts_ray() {
        let window = (Vec2::new(0.25, -0.1), Vec2::new(0.5, 0.7));
        for camera in [camera(None), orthographic()] {
            for camera in [camera, camera.cropped(window.0, window.1)] {
                let film = Vec2::new(0.2, 0.9);
                let (back, depth) = camera.project(camera.ray(film, Vec2::ZERO).at(3.0));
                assert!(back.abs_diff_eq(film, 1e-5) && depth > 0.0);
                assert!(
                    camera
                        .unproject(back, depth)
                        .abs_diff_eq(camera.ray(film, Vec2::ZERO).at(3.0), 1e-5)
                );
            }
        }
    }

    #[test]
    fn matrices_do_what_projecting_does() {
        let pose = Affine3A::from_rotation_translation(
            glam::Quat::from_euler(glam::EulerRot::YXZ, 0.4, -0.3, 0.2),
            Vec3::new(1.0, -2.0, 3.0),
        );
        let placed = |camera: Camera| Camera {
            world_from_camera: pose,
            ..camera
        };
        for camera in [camera(None), orthographic()].map(placed) {
            let camera = camera.cropped(Vec2::new(0.25, -0.1), Vec2::new(0.5, 0.7));
            for (film, depth) in [(Vec2::new(0.2, 0.9), 0.5), (Vec2::ONE, 3.0), (Vec2::ZERO, 10.0)] {
                let place = camera.unproject(film, depth);
                let found = camera.film_from_world().project_point3(place);
                assert!(found.truncate().abs_diff_eq(film, 1e-4), "{found}");
                let seen = camera.right_up_forward_from_world().transform_point3(place);
                let own = pose.inverse().transform_point3(place);
                assert!(seen.abs_diff_eq(Vec3::new(-own.x, own.y, depth), 1e-4), "{seen}");
            }
            let depth = |depth| {
                camera
                    .film_from_world()
                    .project_point3(camera.unproject(Vec2::ONE, depth))
                    .z
            };
            assert!(depth(0.5).abs() < 1e-4 && (depth(10.0) - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn a_crop_is_a_part_of_the_picture() {
        let (min, max) = (Vec2::new(0.25, 0.5), Vec2::new(0.75, 0.625));
        for whole in [camera(None), orthographic()] {
            let part = whole.cropped(min, max);
            let film = Vec2::new(0.3, 0.8);
            let expected = whole.ray(min + film * (max - min), Vec2::ZERO);
            let ray = part.ray(film, Vec2::ZERO);
            assert!(ray.origin.abs_diff_eq(expected.origin, 1e-6) && ray.dir.abs_diff_eq(expected.dir, 1e-6));
        }
    }
}
