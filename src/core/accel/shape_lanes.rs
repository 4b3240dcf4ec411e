//! Vectorised tests of shapes: one shape against sixteen rays, or sixteen shapes against one. Rays are in the local
//! space of their shape.

use glam::Vec3;

use super::ray_lanes::RayLanes;
use super::rounding::{EXIT_SCALE, LEAST_MARGIN};
use crate::math::Aabb;
use crate::math::Vector;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, WordLanes, copy_sign};

/// A hit of one shape in each lane.
pub(super) struct ShapeHitLanes {
    pub t: Lanes,
    /// The coordinates on the shape: on a cube's face as [`super::affine_mesh::Face::at`] takes them, zero on a sphere.
    pub u: Lanes,
    pub v: Lanes,
    /// The face of a cube: 0 for x = -1, 1 for x = 1, 2 for y = -1, and so on; zero for other shapes.
    pub part: Lanes,
    /// The lanes whose ray meets the shape before `t_max`. The other fields are undefined elsewhere.
    pub met: Lanes,
}

/// Transforms world `rays` to spaces with origins at `places` by the `rows` of the matrices, as
/// [`super::instance::Instance::local_ray`] does.
#[inline(always)]
pub(super) fn local(rays: &RayLanes, rows: &[Vec3Lanes; 3], places: Vec3Lanes) -> RayLanes {
    let turned = |v: Vec3Lanes| Vec3Lanes::of(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v));
    RayLanes {
        origin: turned(rays.origin - places),
        dir: turned(rays.dir),
        t_min: rays.t_min,
        t_max: rays.t_max,
    }
}

/// [`local`] for a single space.
#[inline(always)]
pub(super) fn local_to(rays: &RayLanes, rows: &[Vec3; 3], place: Vec3) -> RayLanes {
    // The array's `map` would go through memory.
    let row = |row: usize| Vec3Lanes::splat(rows[row]);
    local(rays, &[row(0), row(1), row(2)], Vec3Lanes::splat(place))
}

/// Intersects the plane z = 0; `u` and `v` are x and y.
#[inline(always)]
pub(super) fn plane(ray: &RayLanes, t_max: Lanes) -> ShapeHitLanes {
    let t = -ray.origin.z / ray.dir.z;
    ShapeHitLanes {
        t,
        u: t.mul_add(ray.dir.x, ray.origin.x),
        v: t.mul_add(ray.dir.y, ray.origin.y),
        part: Lanes::ZERO,
        met: t.simd_gt(ray.t_min) & t.simd_lt(t_max),
    }
}

/// Intersects a rectangle as [`crate::geometry::rectangle::intersect`] does.
#[inline(always)]
pub(super) fn rectangle(ray: &RayLanes, t_max: Lanes) -> ShapeHitLanes {
    let mut hit = plane(ray, t_max);
    hit.met &= in_rectangle(hit.u, hit.v);
    hit
}

#[inline(always)]
pub(super) fn in_rectangle(x: Lanes, y: Lanes) -> Lanes {
    x.abs().simd_le(Lanes::ONE) & y.abs().simd_le(Lanes::ONE)
}

/// Intersects a sphere as [`crate::geometry::sphere::intersect`] does, but in single precision.
#[inline(always)]
pub(super) fn sphere(ray: &RayLanes, t_max: Lanes) -> ShapeHitLanes {
    round(ray, Lanes::ONE, t_max)
}

/// Intersects a sphere around the origin with this squared radius.
#[inline(always)]
pub(super) fn round(ray: &RayLanes, squared_radius: Lanes, t_max: Lanes) -> ShapeHitLanes {
    let zero = Lanes::ZERO;
    let hit = |t: Lanes, met: Lanes| ShapeHitLanes {
        t,
        u: zero,
        v: zero,
        part: zero,
        met,
    };
    let (o, d) = (ray.origin, ray.dir);
    let a = d.length_squared();
    let b = o.dot(d);
    let c = o.length_squared() - squared_radius;
    // The squared distance of the centre from the line, as a cross product, which does not cancel for far origins.
    let discriminant = a.mul_sub(squared_radius, o.cross(d).length_squared());
    // Tested before the expensive operations: the line passes through the sphere, not only behind the origin.
    let ahead = discriminant.simd_ge(zero) & b.fast_min(c).simd_lt(zero);
    if ahead.none() {
        return hit(zero, ahead);
    }
    let root = discriminant.fast_max(zero).sqrt();
    let q = -(b + copy_sign(root, b));
    let (first, second) = (q / a, c / q);
    let (near, far) = (first.fast_min(second), first.fast_max(second));
    let inside = |t: Lanes| t.simd_gt(ray.t_min) & t.simd_lt(t_max);
    let near_counts = inside(near);
    let met = ahead & (near_counts | inside(far));
    hit(near_counts.select(near, far), met)
}

/// Intersects the cube [-1, 1]³ by the slab method, from inside if the ray at `t_min` is in it. Which side of a face a
/// ray comes from is exact.
#[inline(always)]
pub(super) fn cube(ray: &RayLanes, t_max: Lanes) -> ShapeHitLanes {
    let (zero, largest) = (Lanes::ZERO, Lanes::splat(f32::MAX));
    // A fused multiply-add rounds once, so that the signs are right. A zero component of the direction gets the largest
    // inverse.
    let axis = |origin: Lanes, dir: Lanes| {
        let inverse = inverse_within(dir, largest);
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
    let from_within = enter.simd_le(ray.t_min);
    let t = from_within.select(leave, enter);
    let met = enter.simd_le(leave) & t.simd_gt(ray.t_min) & t.simd_lt(t_max);

    let at = ray.origin.plus_scaled(t, ray.dir);
    let on_x = from_within.select(x.1, x.0).simd_eq(t);
    let on_y = from_within.select(y.1, y.0).simd_eq(t);
    let by_axis = |x: Lanes, y: Lanes, z: Lanes| on_x.select(x, on_y.select(y, z));
    let upper = by_axis(at.x, at.y, at.z).simd_gt(zero) & Lanes::ONE;
    ShapeHitLanes {
        t,
        u: by_axis(at.y, at.z, at.x),
        v: by_axis(at.z, at.x, at.y),
        part: by_axis(zero, Lanes::splat(2.0), Lanes::splat(4.0)) + upper,
        met,
    }
}

/// Rays prepared for box tests. The test is that of [`super::node`] in another order, with only two operations per
/// face, and a margin for their rounding.
pub(super) struct SlabLanes {
    inverse: Vec3Lanes,
    /// The origins divided by the directions, for the lower and for the upper faces, which are moved outwards a little.
    lower: Vec3Lanes,
    upper: Vec3Lanes,
}

impl SlabLanes {
    #[inline(always)]
    pub fn new(ray: &RayLanes) -> Self {
        // The margin exceeds the rounding of the sum and of the product here.
        let margin = ray.origin.map(|o| {
            o.abs()
                .mul_add(Lanes::splat(2.0 * f32::EPSILON), Lanes::splat(LEAST_MARGIN))
        });
        let inverse = Vec3Lanes::of(
            inverse(ray.origin.x, ray.dir.x),
            inverse(ray.origin.y, ray.dir.y),
            inverse(ray.origin.z, ray.dir.z),
        );
        Self {
            inverse,
            lower: (ray.origin + margin) * inverse,
            upper: (ray.origin - margin) * inverse,
        }
    }

    /// The signs that all rays in `active` share, per axis (true: downwards), or None if they differ on an axis.
    #[inline(always)]
    pub fn common_signs(&self, active: u32) -> Option<[bool; 3]> {
        let negative = |inverse: Lanes| inverse.to_bitmask() & active;
        let down = [
            negative(self.inverse.x),
            negative(self.inverse.y),
            negative(self.inverse.z),
        ];
        let is_common = down.iter().all(|&bits| bits == 0 || bits == active);
        is_common.then(|| [down[0] != 0, down[1] != 0, down[2] != 0])
    }

    /// The mask of the rays that may meet a box before `t_max`.
    #[inline(always)]
    pub fn meets(&self, bounds: &Aabb, t_max: Lanes) -> Lanes {
        self.enter(bounds, t_max).1
    }

    /// The distances at which the rays enter a box, and the mask of those that may meet it before `t_max`.
    #[inline(always)]
    pub fn enter(&self, bounds: &Aabb, t_max: Lanes) -> (Lanes, Lanes) {
        self.enter_between(Vec3Lanes::splat(bounds.min), Vec3Lanes::splat(bounds.max), t_max)
    }

    /// [`Self::enter`] for the box between two corners.
    #[inline(always)]
    pub fn enter_between(&self, min: Vec3Lanes, max: Vec3Lanes, t_max: Lanes) -> (Lanes, Lanes) {
        let (a, b) = (self.distances(min, self.lower), self.distances(max, self.upper));
        let near = Vec3Lanes::of(a.x.fast_min(b.x), a.y.fast_min(b.y), a.z.fast_min(b.z));
        let far = Vec3Lanes::of(a.x.fast_max(b.x), a.y.fast_max(b.y), a.z.fast_max(b.z));
        within(near, far, t_max)
    }

    /// [`Self::enter`] given the planes by which all rays enter, one for each axis, the planes by which they leave, and
    /// their [common signs](Self::common_signs).
    #[inline(always)]
    pub fn enter_by(&self, near: Vec3Lanes, far: Vec3Lanes, down: [bool; 3], t_max: Lanes) -> (Lanes, Lanes) {
        let origins = |down: [bool; 3]| {
            let of = |down: bool, lower: Lanes, upper: Lanes| if down { upper } else { lower };
            Vec3Lanes::of(
                of(down[0], self.lower.x, self.upper.x),
                of(down[1], self.lower.y, self.upper.y),
                of(down[2], self.lower.z, self.upper.z),
            )
        };
        within(
            self.distances(near, origins(down)),
            self.distances(far, origins(down.map(|down| !down))),
            t_max,
        )
    }

    /// The distances at which the rays meet one plane per axis.
    #[inline(always)]
    fn distances(&self, planes: Vec3Lanes, origins: Vec3Lanes) -> Vec3Lanes {
        Vec3Lanes::of(
            planes.x.mul_sub(self.inverse.x, origins.x),
            planes.y.mul_sub(self.inverse.y, origins.y),
            planes.z.mul_sub(self.inverse.z, origins.z),
        )
    }
}

/// One over `dir`, limited to the largest number whose product with the origin loses no digits. Zero components get
/// that number.
#[inline(always)]
fn inverse(origin: Lanes, dir: Lanes) -> Lanes {
    const EXPONENT: WordLanes = WordLanes::new([0xff << 23; LANES]);
    const MOST: WordLanes = WordLanes::new([354 << 23; LANES]);
    let exponent = bytemuck::cast::<Lanes, WordLanes>(origin.abs().fast_max(Lanes::ONE)) & EXPONENT;
    // 2 to the power of 100, less the origin's.
    inverse_within(dir, bytemuck::cast(MOST - exponent))
}

/// One over `dir`, clamped to [-`largest`, `largest`].
#[inline(always)]
pub(super) fn inverse_within(dir: Lanes, largest: Lanes) -> Lanes {
    (Lanes::ONE / dir).fast_max(-largest).fast_min(largest)
}

/// The last entry distance, and whether it comes before all exits and `t_max`.
#[inline(always)]
fn within(near: Vec3Lanes, far: Vec3Lanes, t_max: Lanes) -> (Lanes, Lanes) {
    let enter = near.x.fast_max(near.y).fast_max(near.z.fast_max(Lanes::ZERO));
    let leave = far.x.fast_min(far.y).fast_min(far.z);
    let leave = leave.mul_add(Lanes::splat(EXIT_SCALE), Lanes::splat(f32::MIN_POSITIVE));
    (enter, enter.simd_lt(leave.fast_min(t_max)))
}
