//! The unit disk around the origin in the plane z = 0, normal +z.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::local::{LocalHit, LocalSurface, Parametrisation};
use crate::math::Ray;

/// Tests the plane, then the radius. The hit's u, v are the local x, y.
pub fn intersect(ray: &Ray) -> Option<LocalHit> {
    let t = -ray.origin.z / ray.dir.z;
    let (u, v) = (ray.origin.x + t * ray.dir.x, ray.origin.y + t * ray.dir.y);
    (t > ray.t_min && t < ray.t_max && u * u + v * v <= 1.0).then_some(LocalHit { t, u, v })
}

/// The surface at local (x, y).
pub fn surface(x: f32, y: f32) -> LocalSurface {
    LocalSurface {
        position: Vec3::new(x, y, 0.0),
        error: Vec3::ZERO,
        normal: Vec3::Z,
    }
}

/// The parametrisation at local (x, y): uv = (radius, angle from +x towards +y in turns). In the centre the position
/// does not depend on v, and u has no direction.
pub(crate) fn parametrisation(x: f32, y: f32) -> Parametrisation {
    let turn = y.atan2(x) / TAU;
    let radius = x.hypot(y);
    let outward = Vec2::new(x, y).normalize_or_zero();
    Parametrisation {
        uv: Vec2::new(radius, if turn < 0.0 { turn + 1.0 } else { turn }),
        dp_du: outward.extend(0.0),
        dp_dv: TAU * Vec3::new(-y, x, 0.0),
    }
}
