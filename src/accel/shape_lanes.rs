//! Single shapes against sixteen rays, a ray per lane. Rays are in the shape's space.

use super::few::RayLanes;
use crate::math::lanes::{Lanes, copy_sign};
use crate::math::{Aabb, gamma};

/// Where lines meet a cube.
pub(super) struct CubeLanes {
    pub t: Lanes,
    /// On the face, as [`super::affine_mesh::Face::at`] takes it.
    pub u: Lanes,
    pub v: Lanes,
    /// The face: of x = -1, of x = 1, of y = -1, and so on; a small whole number.
    pub face: Lanes,
    /// The lanes whose ray meets it before `t_max`.
    pub met: Lanes,
}

/// As [`crate::geometry::rectangle::intersect`]: t, u, v, and whether it is met before `t_max`.
#[inline(always)]
pub(super) fn rectangle(ray: &RayLanes, t_max: Lanes) -> (Lanes, Lanes, Lanes, Lanes) {
    let t = -ray.origin.z / ray.dir.z;
    let (u, v) = (t.mul_add(ray.dir.x, ray.origin.x), t.mul_add(ray.dir.y, ray.origin.y));
    let inside = u.abs().simd_le(Lanes::ONE) & v.abs().simd_le(Lanes::ONE);
    (t, u, v, inside & t.simd_gt(Lanes::ZERO) & t.simd_lt(t_max))
}

/// As [`crate::geometry::sphere::intersect`], in single precision: the distance from the centre to the line is taken from the point next
/// to it, whose digits do not cancel (Haines, Günther and Akenine-Möller, Precision Improvements for Ray/Sphere Intersection, Ray
/// Tracing Gems, 2019).
#[inline(always)]
pub(super) fn sphere(ray: &RayLanes, t_max: Lanes) -> (Lanes, Lanes) {
    let zero = Lanes::ZERO;
    let a = ray.dir.length_squared();
    let b = ray.origin.dot(ray.dir);
    let c = ray.origin.length_squared() - Lanes::ONE;
    let next = ray.origin.plus_scaled(-b / a, ray.dir);
    let discriminant = a * (Lanes::ONE - next.length_squared());
    let root = discriminant.fast_max(zero).sqrt();
    let q = -(b + copy_sign(root, b));
    let (first, second) = (q / a, c / q);
    let (near, far) = (first.fast_min(second), first.fast_max(second));
    let inside = |t: Lanes| t.simd_gt(zero) & t.simd_lt(t_max);
    let near_counts = inside(near);
    let met = discriminant.simd_ge(zero) & (near_counts | inside(far));
    (near_counts.select(near, far), met)
}

/// The cube [-1, 1]³ from outside or from within, by the slab method. What is on one side of a face is never taken for the other.
#[inline(always)]
pub(super) fn cube(ray: &RayLanes, t_max: Lanes) -> CubeLanes {
    let (zero, largest) = (Lanes::ZERO, Lanes::splat(f32::MAX));
    // Multiplied and added with a single rounding, so that the signs are right. Directions without a component get the largest inverse.
    let axis = |origin: Lanes, dir: Lanes| {
        let inverse = (Lanes::ONE / dir).fast_max(-largest).fast_min(largest);
        let half = inverse.abs();
        (origin.mul_neg_sub(inverse, half), origin.mul_neg_add(inverse, half))
    };
    let (x, y, z) = (
        axis(ray.origin.x, ray.dir.x),
        axis(ray.origin.y, ray.dir.y),
        axis(ray.origin.z, ray.dir.z),
    );
    let enter = x.0.fast_max(y.0).fast_max(z.0);
    let leave = x.1.fast_min(y.1).fast_min(z.1);
    let from_within = enter.simd_le(zero);
    let t = from_within.select(leave, enter);
    let met = enter.simd_le(leave) & t.simd_gt(zero) & t.simd_lt(t_max);

    let at = ray.origin.plus_scaled(t, ray.dir);
    let on_x = from_within.select(x.1, x.0).simd_eq(t);
    let on_y = from_within.select(y.1, y.0).simd_eq(t);
    let by_axis = |x: Lanes, y: Lanes, z: Lanes| on_x.select(x, on_y.select(y, z));
    let upper = by_axis(at.x, at.y, at.z).simd_gt(zero) & Lanes::ONE;
    CubeLanes {
        t,
        u: by_axis(at.y, at.z, at.x),
        v: by_axis(at.z, at.x, at.y),
        face: by_axis(zero, Lanes::splat(2.0), Lanes::splat(4.0)) + upper,
        met,
    }
}

/// Whether the rays may meet a box before `t_max`, as [`super::node`] tests them.
#[inline(always)]
pub(super) fn meets(bounds: &Aabb, ray: &RayLanes, t_max: Lanes) -> Lanes {
    let largest = Lanes::splat(f32::MAX);
    let axis = |min: f32, max: f32, origin: Lanes, dir: Lanes| {
        // Directions without a component get the largest inverse, and faces a little farther out.
        let inverse = (Lanes::ONE / dir).fast_max(-largest).fast_min(largest);
        let margin = origin.abs() * Lanes::splat(f32::EPSILON) + Lanes::splat(1e-18);
        let a = (Lanes::splat(min) - margin - origin) * inverse;
        let b = (Lanes::splat(max) + margin - origin) * inverse;
        (a.fast_min(b), a.fast_max(b))
    };
    let (x, y, z) = (
        axis(bounds.min.x, bounds.max.x, ray.origin.x, ray.dir.x),
        axis(bounds.min.y, bounds.max.y, ray.origin.y, ray.dir.y),
        axis(bounds.min.z, bounds.max.z, ray.origin.z, ray.dir.z),
    );
    let enter = x.0.fast_max(y.0).fast_max(z.0.fast_max(Lanes::ZERO));
    let leave = x.1.fast_min(y.1).fast_min(z.1) * Lanes::splat(1.0 + 2.0 * gamma(3));
    enter.simd_le(leave.fast_min(t_max))
}
