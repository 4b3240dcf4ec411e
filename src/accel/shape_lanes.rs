//! Shapes against rays, in lanes: one shape against sixteen rays, or sixteen shapes against one. Rays are in their shape's space.

use glam::Vec3;

use super::ray_lanes::RayLanes;
use crate::math::lanes::{Lanes, Vec3Lanes, copy_sign};
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

/// World `rays` in spaces whose origins are at `places`, by the rows of the matrices to there; as [`super::instance::Instance::local_ray`].
#[inline(always)]
pub(super) fn local(rays: &RayLanes, rows: &[Vec3Lanes; 3], places: Vec3Lanes) -> RayLanes {
    let turned = |v: Vec3Lanes| Vec3Lanes::of(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v));
    RayLanes {
        origin: turned(rays.origin - places),
        dir: turned(rays.dir),
        t_max: rays.t_max,
    }
}

/// [`local`] for one space.
#[inline(always)]
pub(super) fn local_to(rays: &RayLanes, rows: &[Vec3; 3], place: Vec3) -> RayLanes {
    // Not by `map` of the array, which goes through memory.
    let row = |row: usize| Vec3Lanes::splat(rows[row]);
    local(rays, &[row(0), row(1), row(2)], Vec3Lanes::splat(place))
}

/// The plane z = 0: t, x, y, and whether it is met before `t_max`.
#[inline(always)]
pub(super) fn plane(ray: &RayLanes, t_max: Lanes) -> (Lanes, Lanes, Lanes, Lanes) {
    let t = -ray.origin.z / ray.dir.z;
    let (x, y) = (t.mul_add(ray.dir.x, ray.origin.x), t.mul_add(ray.dir.y, ray.origin.y));
    (t, x, y, t.simd_gt(Lanes::ZERO) & t.simd_lt(t_max))
}

/// As [`crate::geometry::rectangle::intersect`]: t, u, v, and whether it is met before `t_max`.
#[inline(always)]
pub(super) fn rectangle(ray: &RayLanes, t_max: Lanes) -> (Lanes, Lanes, Lanes, Lanes) {
    let (t, x, y, met) = plane(ray, t_max);
    (t, x, y, met & in_rectangle(x, y))
}

#[inline(always)]
pub(super) fn in_rectangle(x: Lanes, y: Lanes) -> Lanes {
    x.abs().simd_le(Lanes::ONE) & y.abs().simd_le(Lanes::ONE)
}

/// As [`crate::geometry::sphere::intersect`], in single precision: the nearest distance within, and whether it is met before `t_max`.
#[inline(always)]
pub(super) fn sphere(ray: &RayLanes, t_max: Lanes) -> (Lanes, Lanes) {
    round(ray, Lanes::ONE, t_max)
}

/// A sphere around the origin, given its squared radius.
#[inline(always)]
pub(super) fn round(ray: &RayLanes, squared_radius: Lanes, t_max: Lanes) -> (Lanes, Lanes) {
    let zero = Lanes::ZERO;
    let (o, d) = (ray.origin, ray.dir);
    let a = d.length_squared();
    let b = o.dot(d);
    let c = o.length_squared() - squared_radius;
    // The distance of the centre from the line, from a product whose digits do not cancel for far origins.
    let discriminant = a.mul_sub(squared_radius, o.cross(d).length_squared());
    // Before the dear operations: the line passes through, and not all of it behind the origin.
    let ahead = discriminant.simd_ge(zero) & b.fast_min(c).simd_lt(zero);
    if ahead.none() {
        return (zero, ahead);
    }
    let root = discriminant.fast_max(zero).sqrt();
    let q = -(b + copy_sign(root, b));
    let (first, second) = (q / a, c / q);
    let (near, far) = (first.fast_min(second), first.fast_max(second));
    let inside = |t: Lanes| t.simd_gt(zero) & t.simd_lt(t_max);
    let near_counts = inside(near);
    let met = ahead & (near_counts | inside(far));
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

/// Rays as boxes want them, which are tested as by [`super::node`].
pub(super) struct SlabLanes {
    inverse: Vec3Lanes,
    /// The origins as the lower and the upper faces see them, which lie a little farther out.
    lower: Vec3Lanes,
    upper: Vec3Lanes,
}

impl SlabLanes {
    #[inline(always)]
    pub fn new(ray: &RayLanes) -> Self {
        let margin = ray
            .origin
            .map(|o| o.abs().mul_add(Lanes::splat(f32::EPSILON), Lanes::splat(1e-18)));
        // Directions without a component get the largest inverse.
        let largest = Lanes::splat(f32::MAX);
        Self {
            inverse: ray.dir.map(|d| (Lanes::ONE / d).fast_max(-largest).fast_min(largest)),
            lower: ray.origin + margin,
            upper: ray.origin - margin,
        }
    }

    /// Whether the rays may meet a box before `t_max`.
    #[inline(always)]
    pub fn meets(&self, bounds: &Aabb, t_max: Lanes) -> Lanes {
        self.enter(bounds, t_max).1
    }

    /// Where they enter it, too.
    #[inline(always)]
    pub fn enter(&self, bounds: &Aabb, t_max: Lanes) -> (Lanes, Lanes) {
        self.enter_between(Vec3Lanes::splat(bounds.min), Vec3Lanes::splat(bounds.max), t_max)
    }

    /// The same of the box between two corners.
    #[inline(always)]
    pub fn enter_between(&self, min: Vec3Lanes, max: Vec3Lanes, t_max: Lanes) -> (Lanes, Lanes) {
        let a = (min - self.lower) * self.inverse;
        let b = (max - self.upper) * self.inverse;
        let (x, y, z) = (a.x.fast_min(b.x), a.y.fast_min(b.y), a.z.fast_min(b.z));
        let enter = x.fast_max(y).fast_max(z.fast_max(Lanes::ZERO));
        let (x, y, z) = (a.x.fast_max(b.x), a.y.fast_max(b.y), a.z.fast_max(b.z));
        let leave = x.fast_min(y).fast_min(z);
        let leave = leave * Lanes::splat(1.0 + 2.0 * gamma(3));
        (enter, enter.simd_le(leave.fast_min(t_max)))
    }
}
