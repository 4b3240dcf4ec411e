//! The camera as a sensor for light paths: which of its rays hits a point, and the density of its rays there (Veach
//! 1997, section 8.3.2.4; PBR 4th ed., section 16.1).

use glam::{Vec2, Vec3};

use super::{Camera, Projection};
use crate::math::Ray;

/// The camera ray to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayTo {
    /// The ray as [`Camera::ray`] gives it.
    pub ray: Ray,
    /// The distance of the point along it.
    pub distance: f32,
    /// The film coordinates; outside of [0, 1] if the point is outside of the picture.
    pub film: Vec2,
    /// The density of [`Camera::ray_density`] at the point. As all parts of the film have equal weight, it is also the
    /// contribution to the picture's mean radiance of a watt of light that leaves the point along the ray, per
    /// steradian and per area.
    pub density: f32,
}

impl Camera {
    /// The ray to a point, from a point of the lens; None for points that are not in front of the camera. `u_lens` in
    /// [0, 1)^2.
    pub fn ray_to(&self, place: Vec3, u_lens: Vec2) -> Option<RayTo> {
        let local = self.world_from_camera.inverse().transform_point3(place);
        if local.z <= 0.0 {
            return None;
        }
        let (origin, on_plane) = match self.projection {
            Projection::Orthographic => (local.truncate().extend(0.0), local.truncate()),
            Projection::Perspective { lens: None } => (Vec3::ZERO, local.truncate() / local.z),
            Projection::Perspective { lens: Some(lens) } => {
                let origin = lens.sample(u_lens).extend(0.0);
                let share = lens.focus_distance / local.z;
                let in_focus = origin.lerp(local, share).truncate();
                (origin, in_focus / lens.focus_distance)
            }
        };
        let way = local - origin;
        let distance = way.length();
        let dir = self.world_from_camera.transform_vector3(way / distance);
        let stretch = distance / way.z;
        let ray = Ray {
            origin: self.world_from_camera.transform_point3(origin),
            dir,
            t_min: self.near * stretch,
            t_max: self.far * stretch,
        };
        Some(RayTo {
            ray,
            distance,
            film: (on_plane - self.corner) / self.diagonal,
            density: self.ray_density(dir, distance),
        })
    }

    /// The centre of the lens; None for parallel rays.
    pub fn eye(&self) -> Option<Vec3> {
        match self.projection {
            Projection::Orthographic => None,
            Projection::Perspective { .. } => Some(self.world_from_camera.translation.into()),
        }
    }

    /// The density, per area perpendicular to a ray along `dir`, of the camera's rays from one point of its lens at
    /// this distance. Its integral over the picture is 1.
    pub fn ray_density(&self, dir: Vec3, distance: f32) -> f32 {
        let area = (self.diagonal.x * self.diagonal.y).abs();
        match self.projection {
            Projection::Orthographic => 1.0 / area,
            Projection::Perspective { .. } => {
                let cos = dir.dot(self.world_from_camera.matrix3.z_axis.into());
                1.0 / (area * cos * cos * cos * distance * distance)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::camera::ThinLens;
    use glam::Affine3A;

    fn cameras() -> [Camera; 3] {
        let pose = Affine3A::from_rotation_translation(
            glam::Quat::from_euler(glam::EulerRot::YXZ, 0.4, -0.3, 0.2),
            Vec3::new(1.0, -2.0, 3.0),
        );
        let lens = ThinLens {
            aperture_radius: 0.3,
            focus_distance: 4.0,
            blades: 5,
            blade_rotation: 0.2,
        };
        [
            Camera::new(pose, 70.0, 1.5, 0.5, 20.0, None),
            Camera::new(pose, 70.0, 1.5, 0.5, 20.0, Some(lens)),
            Camera::orthographic(pose, Vec2::new(3.0, 2.0), 0.5, 20.0),
        ]
        .map(|camera| camera.cropped(Vec2::new(0.1, 0.2), Vec2::new(0.7, 0.9)))
    }

    #[test]
    fn the_ray_to_a_place_is_that_through_its_point_of_the_film() {
        for camera in cameras() {
            let (film, u_lens) = (Vec2::new(0.3, 0.8), Vec2::new(0.2, 0.7));
            let ray = camera.ray(film, u_lens);
            let found = camera.ray_to(ray.at(6.0), u_lens).expect("before the camera");
            assert!(found.film.abs_diff_eq(film, 1e-4), "{found:?}");
            assert!((found.distance - 6.0).abs() < 1e-4, "{found:?}");
            assert!(found.ray.dir.abs_diff_eq(ray.dir, 1e-5) && found.ray.origin.abs_diff_eq(ray.origin, 1e-5));
            assert!((found.ray.t_min - ray.t_min).abs() < 1e-4 && (found.ray.t_max - ray.t_max).abs() < 1e-3);
            assert!(camera.ray_to(ray.at(-6.0), u_lens).is_none());
        }
    }

    /// Rays that hit a plane in proportion to their density.
    #[test]
    fn the_density_is_that_of_rays() {
        for camera in cameras() {
            let (film, u_lens, step) = (Vec2::new(0.3, 0.8), Vec2::new(0.2, 0.7), 1e-2);
            let at = |offset: Vec2| camera.ray(film + offset, u_lens);
            let middle = at(Vec2::ZERO);
            let place = middle.at(5.0);
            // The hits of the other rays on the plane through the point perpendicular to the ray.
            let on_plane = |offset: Vec2| {
                let ray = at(offset);
                ray.at((place - ray.origin).dot(middle.dir) / ray.dir.dot(middle.dir)) - place
            };
            let x = on_plane(Vec2::X * step) - on_plane(Vec2::X * -step);
            let y = on_plane(Vec2::Y * step) - on_plane(Vec2::Y * -step);
            let area = x.cross(y).length() / (4.0 * step * step);
            let density = camera.ray_density(middle.dir, 5.0);
            assert!((density * area - 1.0).abs() < 1e-3, "{density} {area}");
        }
    }
}
