//! The wide node and its box test.
//!
//! The node has eight child boxes in structure-of-arrays form, one per vector lane. The test is the slab method, made
//! conservative by widening the exit distance (PBR 4th ed. section 6.8.2). Directions are inverted so that no component
//! is infinite, hence no product is NaN.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use wide::f32x8;

use super::memory::prefetch;
use super::ray_lanes::RayLanes;
use super::rounding::{EXIT_SCALE, LEAST_MARGIN};
use super::shape_lanes::inverse_within;
use crate::math::lanes::{Lanes, Vec3Lanes};
use crate::math::{Aabb, Ray, Vector};

pub(super) const WIDTH: usize = 8;

/// Up to eight children, which fill the slots from the first on. Empty slots have boxes infinitely far away, which no
/// ray meets.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(32))]
pub(super) struct Node {
    /// `planes[axis][0]` are the lower, `planes[axis][1]` the upper faces.
    planes: [[f32x8; 2]; 3],
    pub children: [Child; WIDTH],
}

/// The content of a node's slot, in 32 bits: an inner node or a leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub(super) struct Child(pub u32);

/// The most primitives of a leaf.
pub(super) const MAX_LEAF: usize = 16;

impl Child {
    pub const NONE: Self = Self(u32::MAX);
    pub const ROOT: Self = Self(0);
    const LEAF: u32 = 1 << 31;
    /// The number of a leaf's primitives, less one, is in the bits from this one on.
    const COUNT_SHIFT: u32 = 27;

    pub fn node(index: usize) -> Self {
        Self(index as u32)
    }

    /// A leaf of 1 to [`MAX_LEAF`] primitives in the `block`-th place of the leaf order.
    pub fn leaf(block: usize, count: usize) -> Self {
        Self(Self::LEAF | (count as u32 - 1) << Self::COUNT_SHIFT | block as u32)
    }

    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// The index of the node or of the leaf's block.
    #[inline(always)]
    pub fn index(self) -> usize {
        let mask = if self.is_leaf() {
            (1 << Self::COUNT_SHIFT) - 1
        } else {
            !Self::LEAF
        };
        (self.0 & mask) as usize
    }

    /// The number of a leaf's primitives.
    #[inline(always)]
    pub fn count(self) -> usize {
        (self.0 >> Self::COUNT_SHIFT & (MAX_LEAF as u32 - 1)) as usize + 1
    }
}

impl Node {
    pub const EMPTY: Self = Self {
        planes: [[f32x8::splat(f32::INFINITY); 2]; 3],
        children: [Child::NONE; WIDTH],
    };

    pub fn set(&mut self, slot: usize, bounds: &Aabb, child: Child) {
        for axis in 0..3 {
            self.planes[axis][0].as_mut_array()[slot] = bounds.min[axis];
            self.planes[axis][1].as_mut_array()[slot] = bounds.max[axis];
        }
        self.children[slot] = child;
    }

    /// Empties a slot, after which no slot in use may follow.
    pub fn clear(&mut self, slot: usize) {
        let [min, max] = [Vec3::INFINITY; 2];
        self.set(slot, &Aabb { min, max }, Child::NONE);
    }

    /// Shifts the indices of children: of nodes by `nodes`, of leaves by `blocks`.
    pub fn advance(&mut self, nodes: usize, blocks: usize) {
        let used = self.slots_used();
        for child in &mut self.children[..used] {
            child.0 += if child.is_leaf() { blocks } else { nodes } as u32;
        }
    }

    pub fn slots_used(&self) -> usize {
        self.children.iter().take_while(|&&child| child != Child::NONE).count()
    }

    pub fn bounds(&self, slot: usize) -> Aabb {
        let corner = |side: usize| Vec3::from_array(self.planes.each_ref().map(|axis| axis[side].as_array()[slot]));
        Aabb {
            min: corner(0),
            max: corner(1),
        }
    }

    /// The box around all children.
    pub fn all_bounds(&self) -> Aabb {
        (0..self.slots_used()).fold(Aabb::EMPTY, |bounds, slot| bounds.union(self.bounds(slot)))
    }

    /// The upper or the lower face of a child's box on each axis, in every lane.
    #[inline(always)]
    pub fn faces_in_lanes(&self, slot: usize, upper: [bool; 3]) -> Vec3Lanes {
        let plane = |axis: usize| Lanes::splat(self.planes[axis][usize::from(upper[axis])].as_array()[slot]);
        Vec3Lanes::of(plane(0), plane(1), plane(2))
    }

    /// Prefetches the node, which takes four cache lines from any start.
    #[inline(always)]
    pub fn prefetch(&self) {
        self.planes.iter().for_each(prefetch);
        prefetch(&self.children);
    }

    /// The distances at which `ray` enters each box, and a mask of the lanes whose box it meets before `t_max`.
    #[inline(always)]
    pub fn entries(&self, ray: &RaySlabs, t_max: f32) -> (f32x8, f32x8) {
        let slab = |axis: usize| {
            let inverse = f32x8::splat(ray.inverse[axis]);
            let [lower, upper] = self.planes[axis];
            let lower = (lower - f32x8::splat(ray.origin_lower[axis])) * inverse;
            let upper = (upper - f32x8::splat(ray.origin_upper[axis])) * inverse;
            (lower.fast_min(upper), lower.fast_max(upper))
        };
        let (x, y, z) = (slab(0), slab(1), slab(2));
        let enter = x.0.fast_max(y.0).fast_max(z.0.fast_max(f32x8::ZERO));
        let leave = x.1.fast_min(y.1).fast_min(z.1);
        let leave = leave.mul_add(f32x8::splat(EXIT_SCALE), f32x8::splat(f32::MIN_POSITIVE));
        (enter, enter.simd_lt(leave.fast_min(f32x8::splat(t_max))))
    }
}

/// The farthest entry distance of a box that can hold a hit at `t_max`, whatever the rounding of both. Without the
/// padding the order of the traversal would decide which of two touching triangles is found.
#[inline(always)]
pub(super) fn padded(t_max: f32) -> f32 {
    t_max * T_MAX_PADDING
}

pub(super) const T_MAX_PADDING: f32 = 1.0 + 64.0 * f32::EPSILON;

/// A ray prepared for box tests.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RaySlabs {
    /// The origins for the lower and the upper faces. They differ only on axes along which the direction is zero.
    origin_lower: [f32; 3],
    origin_upper: [f32; 3],
    inverse: [f32; 3],
}

impl RaySlabs {
    /// None if the ray can hit nothing: it is not finite, has no direction, or its interval is empty.
    ///
    /// A zero direction component gets the largest finite inverse. A ray that runs within a face must not leave the box
    /// at 0 * inverse = 0, so on such an axis both faces are moved outwards a little. The distances to them are then
    /// beyond all others, with the right signs.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Option<Self> {
        let is_valid = ray.origin.is_finite() && ray.dir.is_finite() && ray.dir != Vec3::ZERO && ray.t_max > 0.0;
        if !is_valid {
            return None;
        }
        let margin = (ray.origin.abs() * f32::EPSILON).max(Vec3::splat(LEAST_MARGIN));
        let margin = Vec3::select(ray.dir.cmpeq(Vec3::ZERO), margin, Vec3::ZERO);
        Some(Self {
            origin_lower: (ray.origin + margin).to_array(),
            origin_upper: (ray.origin - margin).to_array(),
            inverse: ray.dir.recip().clamp(Vec3::MIN, Vec3::MAX).to_array(),
        })
    }
}

/// [`RaySlabs`] of sixteen rays that can hit something.
pub(super) struct RaySlabLanes {
    lower: Vec3Lanes,
    upper: Vec3Lanes,
    inverse: Vec3Lanes,
}

impl RaySlabLanes {
    #[inline(always)]
    pub fn new(rays: &RayLanes) -> Self {
        let (largest, least) = (Lanes::splat(f32::MAX), Lanes::splat(LEAST_MARGIN));
        let margin = |o: Lanes, d: Lanes| {
            let margin = (o.abs() * Lanes::splat(f32::EPSILON)).fast_max(least);
            margin & d.simd_eq(Lanes::ZERO)
        };
        let (o, d) = (rays.origin, rays.dir);
        let margin = Vec3Lanes::of(margin(o.x, d.x), margin(o.y, d.y), margin(o.z, d.z));
        Self {
            lower: o + margin,
            upper: o - margin,
            inverse: d.map(|d| inverse_within(d, largest)),
        }
    }

    #[inline(always)]
    pub fn get(&self, lane: usize) -> RaySlabs {
        RaySlabs {
            origin_lower: self.lower.get(lane).to_array(),
            origin_upper: self.upper.get(lane).to_array(),
            inverse: self.inverse.get(lane).to_array(),
        }
    }
}
