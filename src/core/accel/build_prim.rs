//! The input of a hierarchy's build: references to primitives, and sets of them with their boxes.

use bytemuck::{Pod, Zeroable, cast};
use glam::Vec3;
use wide::{f32x4, f32x8};

use crate::math::Aabb;

/// Coordinates are clamped to this for centres, so that sums of two and differences of sums stay finite.
const LIMIT: f32x4 = f32x4::splat(f32::MAX / 8.0);

/// A reference to a primitive: its box and its index.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(32))]
pub(super) struct PrimRef {
    negated_min: [f32; 3],
    pub index: u32,
    max: [f32; 3],
    /// The index once more, so that the fourth lane of a centre, a difference, is zero.
    index_again: u32,
}

impl PrimRef {
    pub fn new(bounds: &Aabb, index: u32) -> Self {
        Self {
            negated_min: (-bounds.min).to_array(),
            index,
            max: bounds.max.to_array(),
            index_again: index,
        }
    }

    /// Whether the box is neither empty nor NaN.
    #[inline(always)]
    pub fn is_hittable(&self) -> bool {
        self.bounds().holds_points()
    }

    #[inline(always)]
    pub fn bounds(&self) -> SimdAabb {
        SimdAabb(cast(*self))
    }

    /// Twice the centre.
    #[inline(always)]
    pub fn center(&self) -> f32x4 {
        let [negated_min, max] = self.bounds().corners();
        max.fast_min(LIMIT) - negated_min.fast_min(LIMIT)
    }
}

/// A box in one vector: the negated lower corner and the upper corner, each followed by an unused lane. A union is then
/// a single maximum.
#[derive(Clone, Copy)]
pub(super) struct SimdAabb(f32x8);

impl SimdAabb {
    pub const EMPTY: Self = Self(f32x8::splat(f32::NEG_INFINITY));

    pub fn of(bounds: &Aabb) -> Self {
        PrimRef::new(bounds, 0).bounds()
    }

    /// [`SimdAabb::of`], but [`SimdAabb::EMPTY`] for a box that is empty on any axis.
    pub fn of_part(part: &Aabb) -> Self {
        match part.is_empty() {
            true => Self::EMPTY,
            false => Self::of(part),
        }
    }

    #[inline(always)]
    pub fn of_point(point: f32x4) -> Self {
        Self(cast([-point, point]))
    }

    #[inline(always)]
    pub fn union(self, other: Self) -> Self {
        Self(other.0.fast_max(self.0))
    }

    /// The box itself where `mask` is set, the empty box where it is clear.
    #[inline(always)]
    pub fn masked(self, mask: f32x8) -> Self {
        Self(mask.select(self.0, Self::EMPTY.0))
    }

    #[inline(always)]
    fn corners(self) -> [f32x4; 2] {
        cast(self.0)
    }

    #[inline(always)]
    pub fn min(self) -> f32x4 {
        -self.corners()[0]
    }

    #[inline(always)]
    pub fn max(self) -> f32x4 {
        self.corners()[1]
    }

    /// Whether the box is neither empty nor NaN.
    #[inline(always)]
    pub fn holds_points(self) -> bool {
        let [negated_min, max] = self.corners();
        (-negated_min).simd_le(max).to_bitmask() & 7 == 7
    }

    #[inline(always)]
    pub fn extent(self) -> f32x4 {
        let [negated_min, max] = self.corners();
        max + negated_min
    }

    #[inline(always)]
    pub fn half_area(self, scale: f32) -> f32 {
        let [x, y, z, _] = (self.extent() * scale).to_array();
        x * y + y * z + z * x
    }

    pub fn to_aabb(self) -> Aabb {
        let [negated_min, max] = self.corners().map(|corner| Vec3::from_slice(corner.as_array()));
        Aabb { min: -negated_min, max }
    }
}

/// The summary of some references: their number, the box around them and the box around their doubled centres.
#[derive(Clone, Copy)]
pub(super) struct PrimSet {
    pub len: usize,
    pub bounds: SimdAabb,
    pub centers: SimdAabb,
}

impl PrimSet {
    pub const EMPTY: Self = Self {
        len: 0,
        bounds: SimdAabb::EMPTY,
        centers: SimdAabb::EMPTY,
    };

    /// Adds a reference if `condition` holds, without a branch on it.
    #[inline(always)]
    pub fn add_if(&mut self, condition: bool, prim: &PrimRef, center: f32x4) {
        let mask = cast([-i32::from(condition); 8]);
        self.len += usize::from(condition);
        self.bounds = self.bounds.union(prim.bounds().masked(mask));
        self.centers = self.centers.union(SimdAabb::of_point(center).masked(mask));
    }

    pub fn union(self, other: Self) -> Self {
        Self {
            len: self.len + other.len,
            bounds: self.bounds.union(other.bounds),
            centers: self.centers.union(other.centers),
        }
    }

    pub fn of_hittable(prims: &[PrimRef]) -> Self {
        let mut set = Self::EMPTY;
        for prim in prims {
            set.add_if(prim.is_hittable(), prim, prim.center());
        }
        set
    }

    pub fn of(prims: &[PrimRef]) -> Self {
        let mut set = Self::EMPTY;
        for prim in prims {
            set.add_if(true, prim, prim.center());
        }
        set
    }
}

/// A plane across an axis.
#[derive(Clone, Copy)]
pub(super) struct Plane {
    pub axis: usize,
    pub at: f32,
}
