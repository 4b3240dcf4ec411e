//! The wide node and its box test.
//!
//! Eight child boxes in structure-of-arrays form, one per vector lane. The test is the slab method, made conservative by widening the
//! exit distance (PBR 4th ed. section 6.8.2). Directions are inverted so that no component is infinite, hence no product is NaN.

use glam::Vec3;
use wide::f32x8;

use crate::math::{Aabb, Ray, gamma};

pub(super) const WIDTH: usize = 8;

/// Up to eight children, which fill the slots from the first on. Empty slots have empty boxes, which no ray hits.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// `planes[axis][0]` are the lower, `planes[axis][1]` the upper faces.
    planes: [[f32x8; 2]; 3],
    /// A node's index if `count` is zero, else where the leaf's primitives start in the order.
    pub child: [u32; WIDTH],
    /// Primitives of a leaf; zero for inner children and empty slots.
    pub count: [u32; WIDTH],
}

pub(super) const NO_CHILD: u32 = u32::MAX;

impl Node {
    pub const EMPTY: Self = Self {
        planes: [[f32x8::splat(f32::INFINITY), f32x8::splat(f32::NEG_INFINITY)]; 3],
        child: [NO_CHILD; WIDTH],
        count: [0; WIDTH],
    };

    pub fn set(&mut self, slot: usize, bounds: &Aabb, child: u32, count: u32) {
        for axis in 0..3 {
            self.planes[axis][0].as_mut_array()[slot] = bounds.min[axis];
            self.planes[axis][1].as_mut_array()[slot] = bounds.max[axis];
        }
        self.child[slot] = child;
        self.count[slot] = count;
    }

    pub fn slots_used(&self) -> usize {
        self.child.iter().take_while(|&&child| child != NO_CHILD).count()
    }

    pub fn bounds(&self, slot: usize) -> Aabb {
        let corner = |side: usize| Vec3::from_array(self.planes.each_ref().map(|axis| axis[side].as_array()[slot]));
        Aabb {
            min: corner(0),
            max: corner(1),
        }
    }

    /// Where `ray` enters each box, and a bit per box for those that it meets before `t_max`.
    #[inline(always)]
    pub fn entries(&self, ray: &RaySlabs, t_max: f32) -> ([f32; WIDTH], u32) {
        let faces = |axis: usize| {
            let [lower, upper] = &self.planes[axis];
            let (near, far) = if ray.reversed[axis] {
                (upper, lower)
            } else {
                (lower, upper)
            };
            let distance = |face: &f32x8, origin: f32x8| (*face - origin) * ray.inverse[axis];
            (
                distance(near, ray.origin_near[axis]),
                distance(far, ray.origin_far[axis]),
            )
        };
        let (near, far) = ([0, 1, 2].map(|axis| faces(axis).0), [0, 1, 2].map(|axis| faces(axis).1));
        let enter = near[0].fast_max(near[1]).fast_max(near[2].fast_max(f32x8::ZERO));
        let leave = far[0].fast_min(far[1]).fast_min(far[2]) * f32x8::splat(EXIT_SCALE);
        let mask = enter.simd_le(leave.fast_min(f32x8::splat(t_max))).to_bitmask();
        (enter.to_array(), mask)
    }
}

/// Widens the exit distance by the rounding of both distances.
const EXIT_SCALE: f32 = 1.0 + 2.0 * gamma(3);

/// A ray as the box test wants it, every number repeated in every lane.
pub(super) struct RaySlabs {
    /// The origin as the near and the far faces see it: equal but on axes without direction.
    origin_near: [f32x8; 3],
    origin_far: [f32x8; 3],
    inverse: [f32x8; 3],
    /// Whether the ray enters a slab through its upper face.
    reversed: [bool; 3],
}

impl RaySlabs {
    /// `None` if the ray can hit nothing: not finite, without direction, or with an empty interval.
    ///
    /// A zero direction component gets the largest finite inverse. A ray that runs within a face must not leave the box at 0 * inverse = 0,
    /// so on such an axis both faces are taken a little farther out: distances then come out as beyond all others, on the right side.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Option<Self> {
        let usable = ray.origin.is_finite() && ray.dir.is_finite() && ray.dir != Vec3::ZERO && ray.t_max > 0.0;
        if !usable {
            return None;
        }
        let margin = (ray.origin.abs() * f32::EPSILON).max(Vec3::splat(LEAST_MARGIN));
        let margin = Vec3::select(ray.dir.cmpeq(Vec3::ZERO), margin.copysign(ray.dir), Vec3::ZERO);
        Some(Self {
            origin_near: (ray.origin + margin).to_array().map(f32x8::splat),
            origin_far: (ray.origin - margin).to_array().map(f32x8::splat),
            inverse: ray.dir.recip().clamp(Vec3::MIN, Vec3::MAX).to_array().map(f32x8::splat),
            reversed: ray.dir.to_array().map(f32::is_sign_negative),
        })
    }
}

/// Times the largest inverse this is 3e20, farther than any hit that f32 could resolve.
const LEAST_MARGIN: f32 = 1e-18;
