//! The rectangle [-1, 1]^2 in the plane z = 0, normal +z.

use glam::{Vec2, Vec3};

use super::local::{LocalHit, LocalSurface, Parametrisation};
use crate::math::Ray;

/// Tests the plane, then the bounds. The hit's u, v are the local x, y.
pub fn intersect(ray: &Ray) -> Option<LocalHit> {
    let t = -ray.origin.z / ray.dir.z;
    let (u, v) = (ray.origin.x + t * ray.dir.x, ray.origin.y + t * ray.dir.y);
    (t > ray.t_min && t < ray.t_max && u.abs() <= 1.0 && v.abs() <= 1.0).then_some(LocalHit { t, u, v })
}

/// The surface at local (x, y).
pub fn surface(x: f32, y: f32) -> LocalSurface {
    LocalSurface {
        position: Vec3::new(x, y, 0.0),
        error: Vec3::ZERO,
        normal: Vec3::Z,
    }
}

/// The parametrisation at local (x, y): uv runs from 0 to 1 along x and y.
pub(crate) fn parametrisation(x: f32, y: f32) -> Parametrisation {
    Parametrisation {
        uv: Vec2::new(0.5 * x + 0.5, 0.5 * y + 0.5),
        dp_du: 2.0 * Vec3::X,
        dp_dv: 2.0 * Vec3::Y,
    }
}
