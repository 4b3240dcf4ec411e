//! The wide node and its box test.
//!
//! Eight child boxes in structure-of-arrays form: plain loops over the lanes become vector code. The test is the slab method, made
//! conservative by widening the exit distance (PBR 4th ed. section 6.8.2). Comparisons are written so that a NaN (a zero direction
//! component within a slab's plane) leaves the interval as it is instead of losing the box.

use glam::Vec3;

use crate::math::{Aabb, Ray, gamma};

pub(super) const WIDTH: usize = 8;

/// Up to eight children, which fill the slots from the first on. Empty slots have empty boxes, which no ray hits.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// `planes[axis][0]` are the lower, `planes[axis][1]` the upper faces.
    pub planes: [[[f32; WIDTH]; 2]; 3],
    /// A node's index if `count` is zero, else where the leaf's primitives start in the order.
    pub child: [u32; WIDTH],
    /// Primitives of a leaf; zero for inner children and empty slots.
    pub count: [u32; WIDTH],
}

pub(super) const NO_CHILD: u32 = u32::MAX;

impl Node {
    pub const EMPTY: Self = Self {
        planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        child: [NO_CHILD; WIDTH],
        count: [0; WIDTH],
    };

    pub fn set(&mut self, slot: usize, bounds: &Aabb, child: u32, count: u32) {
        for axis in 0..3 {
            self.planes[axis][0][slot] = bounds.min[axis];
            self.planes[axis][1][slot] = bounds.max[axis];
        }
        self.child[slot] = child;
        self.count[slot] = count;
    }

    pub fn slots_used(&self) -> usize {
        self.child.iter().take_while(|&&child| child != NO_CHILD).count()
    }

    pub fn bounds(&self, slot: usize) -> Aabb {
        let corner = |side: usize| Vec3::from_array(self.planes.each_ref().map(|axis| axis[side][slot]));
        Aabb {
            min: corner(0),
            max: corner(1),
        }
    }

    /// Where `ray` enters each box, and a bit per box for those that it meets before `t_max`.
    #[inline(always)]
    pub fn entries(&self, ray: &RaySlabs, t_max: f32) -> ([f32; WIDTH], u32) {
        let mut enter = [0.0f32; WIDTH];
        let mut leave = [f32::INFINITY; WIDTH];
        for axis in 0..3 {
            let (origin, inverse) = (ray.origin[axis], ray.inverse[axis]);
            let near = &self.planes[axis][ray.near_side[axis] & 1];
            let far = &self.planes[axis][(ray.near_side[axis] & 1) ^ 1];
            for lane in 0..WIDTH {
                let t_near = (near[lane] - origin) * inverse;
                let t_far = (far[lane] - origin) * inverse;
                enter[lane] = if t_near > enter[lane] { t_near } else { enter[lane] };
                leave[lane] = if t_far < leave[lane] { t_far } else { leave[lane] };
            }
        }
        let mut mask = 0;
        for lane in 0..WIDTH {
            let hit = (enter[lane] <= leave[lane] * EXIT_SCALE) & (enter[lane] <= t_max);
            mask |= u32::from(hit) << lane;
        }
        (enter, mask)
    }
}

/// Widens the exit distance by the rounding of both distances.
const EXIT_SCALE: f32 = 1.0 + 2.0 * gamma(3);

/// A ray as the box test wants it.
pub(super) struct RaySlabs {
    origin: [f32; 3],
    inverse: [f32; 3],
    /// 1 where the ray enters a slab through its upper face.
    near_side: [usize; 3],
}

impl RaySlabs {
    /// `None` if the ray can hit nothing: not finite, without direction, or with an empty interval.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Option<Self> {
        let usable = ray.origin.is_finite() && ray.dir.is_finite() && ray.dir != Vec3::ZERO && ray.t_max > 0.0;
        usable.then(|| Self {
            origin: ray.origin.to_array(),
            inverse: ray.dir.recip().to_array(),
            near_side: ray.dir.to_array().map(|d| usize::from(d.is_sign_negative())),
        })
    }
}
