//! The unit sphere around the origin.
//!
//! The quadratic is solved in f64, with the discriminant from the cross product (no cancellation for far origins;
//! compare PBR 4th ed. section 6.8.3) and the two roots from their product. Scalar f64 costs the same as f32 here.

use std::f32::consts::{PI, TAU};

use glam::{DVec3, Vec2, Vec3};

use super::local::{LocalHit, LocalSurface, Parametrisation};
use crate::math::{Ray, gamma};

/// The nearest of the two intersections with t_min < t < t_max.
pub fn intersect(ray: &Ray) -> Option<LocalHit> {
    let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
    let a = dir.length_squared();
    let b = origin.dot(dir);
    let c = origin.length_squared() - 1.0;
    let discriminant = a - origin.cross(dir).length_squared();
    if discriminant < 0.0 {
        return None;
    }
    let q = -(b + discriminant.sqrt().copysign(b));
    let (first, second) = (q / a, c / q);
    let (near, far) = if first <= second {
        (first, second)
    } else {
        (second, first)
    };
    let inside = |t: f32| t > ray.t_min && t < ray.t_max;
    let t = [near as f32, far as f32].into_iter().find(|&t| inside(t))?;
    Some(LocalHit { t, u: 0.0, v: 0.0 })
}

/// The surface where `ray` meets the sphere at parameter `t`; the normal points outwards and has unit length.
pub fn surface(ray: &Ray, t: f32) -> LocalSurface {
    let on_ray = ray.origin.as_dvec3() + f64::from(t) * ray.dir.as_dvec3();
    let position = on_ray.try_normalize().unwrap_or(DVec3::Z).as_vec3();
    LocalSurface {
        position,
        error: gamma(3) * position.abs(),
        normal: position,
    }
}

/// The parametrisation at a point of the sphere: uv = (phi / 2 pi in [0, 1), theta / pi in [0, 1]) with phi from +x
/// towards +y and theta from +z. At the poles, where the position does not depend on u, v grows towards +x.
pub(crate) fn parametrisation(position: Vec3) -> Parametrisation {
    Parametrisation {
        uv: uv(position),
        dp_du: TAU * Vec3::new(-position.y, position.x, 0.0),
        dp_dv: PI * down(position),
    }
}

/// The unit vector along which theta grows.
fn down(p: Vec3) -> Vec3 {
    let across = p.truncate().length();
    if across == 0.0 {
        return Vec3::X;
    }
    let outward = p.truncate() / across;
    (p.z * outward).extend(-across)
}

/// The texture coordinates of a unit vector.
pub fn uv(p: Vec3) -> Vec2 {
    let phi = p.y.atan2(p.x);
    let theta = (p.x * p.x + p.y * p.y).sqrt().atan2(p.z);
    let turn = if phi < 0.0 { phi / TAU + 1.0 } else { phi / TAU };
    Vec2::new(if turn < 1.0 { turn } else { 0.0 }, theta / PI)
}
