//! The open cylinder of radius 1 around the z axis, from z = 0 to z = 1, without caps.
//!
//! The quadratic is solved in f64, as for the sphere.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::local::{LocalHit, LocalSurface, Parametrisation};
use crate::math::{Ray, gamma};

/// The nearer of the two intersections with t_min < t < t_max and z between the ends. Both sides can be hit.
pub fn intersect(ray: &Ray) -> Option<LocalHit> {
    let (origin, dir) = (ray.origin.as_dvec3(), ray.dir.as_dvec3());
    let (o, d) = (origin.truncate(), dir.truncate());
    let a = d.length_squared();
    let b = o.dot(d);
    let c = o.length_squared() - 1.0;
    let discriminant = a - o.perp_dot(d).powi(2);
    if discriminant < 0.0 || a == 0.0 {
        return None;
    }
    let q = -(b + discriminant.sqrt().copysign(b));
    let (first, second) = (q / a, c / q);
    let (near, far) = if first <= second {
        (first, second)
    } else {
        (second, first)
    };
    let met = |&t: &f64| {
        let z = origin.z + t * dir.z;
        t as f32 > ray.t_min && (t as f32) < ray.t_max && (0.0..=1.0).contains(&z)
    };
    let t = [near, far].into_iter().find(met)? as f32;
    Some(LocalHit { t, u: 0.0, v: 0.0 })
}

/// The surface where `ray` meets the cylinder at parameter `t`; the normal points outwards.
pub fn surface(ray: &Ray, t: f32) -> LocalSurface {
    let on_ray = ray.origin.as_dvec3() + f64::from(t) * ray.dir.as_dvec3();
    let around = on_ray.truncate().normalize_or(glam::DVec2::X).as_vec2();
    let position = around.extend(on_ray.z.clamp(0.0, 1.0) as f32);
    LocalSurface {
        position,
        error: gamma(3) * around.abs().extend(0.0),
        normal: around.extend(0.0),
    }
}

/// The parametrisation at a point of the cylinder: uv = (angle from +x towards +y in turns, in [0, 1), z).
pub(crate) fn parametrisation(position: Vec3) -> Parametrisation {
    Parametrisation {
        uv: uv(position),
        dp_du: TAU * Vec3::new(-position.y, position.x, 0.0),
        dp_dv: Vec3::Z,
    }
}

/// The texture coordinates at a point of the cylinder.
pub fn uv(p: Vec3) -> Vec2 {
    let turn = p.y.atan2(p.x) / TAU;
    let turn = if turn < 0.0 { turn + 1.0 } else { turn };
    Vec2::new(if turn < 1.0 { turn } else { 0.0 }, p.z)
}
