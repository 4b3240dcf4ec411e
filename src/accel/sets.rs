//! What a hierarchy is built from: references to primitives, and sets of them with their boxes.

use glam::Vec3A;

use crate::math::Aabb;

/// Coordinates are clamped to this when centres are taken, so that sums of two and differences of sums stay finite.
const LIMIT: f32 = f32::MAX / 8.0;

#[derive(Clone, Copy)]
pub(super) struct Reference {
    pub min: Vec3A,
    pub max: Vec3A,
    pub index: u32,
}

impl Reference {
    /// Twice the centre.
    #[inline(always)]
    pub fn center(&self) -> Vec3A {
        self.min.max(Vec3A::splat(-LIMIT)) + self.max.min(Vec3A::splat(LIMIT))
    }
}

#[derive(Clone, Copy)]
pub(super) struct Bounds {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl Bounds {
    pub const EMPTY: Self = Self {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
    };

    #[inline(always)]
    pub fn grow(&mut self, min: Vec3A, max: Vec3A) {
        self.min = self.min.min(min);
        self.max = self.max.max(max);
    }

    pub fn half_area(&self, scale: f32) -> f32 {
        let e = (self.max - self.min) * scale;
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    pub fn to_aabb(self) -> Aabb {
        Aabb {
            min: self.min.into(),
            max: self.max.into(),
        }
    }
}

/// A run of references with the box around them and the box around their (doubled) centres.
#[derive(Clone, Copy)]
pub(super) struct Set {
    pub start: usize,
    pub len: usize,
    pub bounds: Bounds,
    pub centers: Bounds,
}

impl Set {
    pub fn empty(start: usize) -> Self {
        Self {
            start,
            len: 0,
            bounds: Bounds::EMPTY,
            centers: Bounds::EMPTY,
        }
    }

    #[inline(always)]
    pub fn add(&mut self, reference: &Reference) {
        self.len += 1;
        self.bounds.grow(reference.min, reference.max);
        let center = reference.center();
        self.centers.grow(center, center);
    }

    pub fn of(start: usize, references: &[Reference]) -> Self {
        let mut set = Self::empty(start);
        references.iter().for_each(|reference| set.add(reference));
        set
    }
}
