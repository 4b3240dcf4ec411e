//! Binned evaluation of the surface area heuristic over all three axes (Wald, On fast construction of SAH-based
//! bounding volume hierarchies, 2007).

use wide::{f32x4, i32x4};

use super::build_prim::{Plane, PrimRef, PrimSet, SimdAabb};

const MAX_BINS: usize = 16;

/// The layout of bins: equal slices along each axis of a box, around the centres or, for spatial splits, around the
/// primitives.
pub(super) struct Grid {
    origin: f32x4,
    scale: f32x4,
    bins: usize,
}

impl Grid {
    pub fn new(set: &PrimSet) -> Self {
        Self::over(set.centers, (4 + set.len).min(MAX_BINS))
    }

    /// A grid of `bins` slabs along each axis between the sides of `bounds`.
    pub fn over(bounds: SimdAabb, bins: usize) -> Self {
        let scale = f32x4::splat(bins as f32 * (1.0 - 1e-6)) / bounds.extent();
        Self {
            origin: bounds.min(),
            // An axis without spread has one bin.
            scale: scale & scale.is_finite(),
            bins,
        }
    }

    /// The plane between a bin and the one before it, for bins over the primitives' own coordinates.
    pub fn plane(&self, axis: usize, bin: usize) -> Plane {
        let [origin, scale] = [self.origin, self.scale].map(|numbers| numbers.as_array()[axis]);
        let at = origin + bin as f32 / scale;
        Plane { axis, at }
    }

    /// Whether the bin on one axis comes before `boundary`.
    #[inline(always)]
    pub fn is_before(&self, center: f32x4, axis: usize, boundary: usize) -> bool {
        let axes = self
            .position(center)
            .simd_lt(f32x4::splat(boundary as f32))
            .to_bitmask();
        axes >> axis & 1 != 0
    }

    /// The position on each axis in units of bins.
    #[inline(always)]
    fn position(&self, center: f32x4) -> f32x4 {
        (center - self.origin) * self.scale
    }

    #[inline(always)]
    pub fn bin(&self, center: f32x4) -> [usize; 3] {
        let [x, y, z, _] = self.position(center).fast_trunc_int().to_array();
        [x, y, z].map(|bin| bin as usize % MAX_BINS)
    }
}

/// The boxes and counts of the primitives in each bin of each axis.
pub(super) struct Bins {
    pub bounds: [[SimdAabb; 3]; MAX_BINS],
    /// The number of primitives by bin and axis; the fourth axis is not used.
    pub counts: [[i32; 4]; MAX_BINS],
}

/// A plane to split at, between a bin and the one before it.
pub(super) struct Boundary {
    pub axis: usize,
    pub bin: usize,
    /// The sum over both sides of area times number of leaves.
    pub cost: f32,
}

impl Bins {
    pub const EMPTY: Self = Self {
        bounds: [[SimdAabb::EMPTY; 3]; MAX_BINS],
        counts: [[0; 4]; MAX_BINS],
    };

    pub fn fill(grid: &Grid, prims: &[PrimRef]) -> Self {
        let mut bins = Self::EMPTY;
        for prim in prims {
            let at = grid.bin(prim.center());
            bins.count(at);
            bins.add(at, prim.bounds());
        }
        bins
    }

    /// Adds one primitive to the count of the bin `at` on each axis.
    #[inline(always)]
    pub fn count(&mut self, at: [usize; 3]) {
        for (axis, &bin) in at.iter().enumerate() {
            self.counts[bin][axis] += 1;
        }
    }

    #[inline(always)]
    pub fn add(&mut self, at: [usize; 3], part: SimdAabb) {
        for (axis, &bin) in at.iter().enumerate() {
            self.add_on(axis, bin, part);
        }
    }

    #[inline(always)]
    pub fn add_on(&mut self, axis: usize, bin: usize, part: SimdAabb) {
        let bounds = &mut self.bounds[bin][axis];
        *bounds = bounds.union(part);
    }

    pub fn merge(mut self, other: Self) -> Self {
        for bin in 0..MAX_BINS {
            for axis in 0..3 {
                let bounds = &mut self.bounds[bin][axis];
                *bounds = bounds.union(other.bounds[bin][axis]);
                self.counts[bin][axis] += other.counts[bin][axis];
            }
        }
        self
    }

    /// Finds the cheapest boundary. `of_left` are the bins to sum up on its left side, `of_right` those on its right.
    /// None if no cost is a number.
    pub fn cheapest([of_left, of_right]: [&Self; 2], grid: &Grid, align: usize, scale: f32) -> Option<Boundary> {
        let mut right_costs = [f32x4::ZERO; MAX_BINS];
        let mut side = Side::EMPTY;
        for bin in (1..grid.bins).rev() {
            side.grow(of_right, bin);
            right_costs[bin] = side.costs(align, scale);
        }
        let (mut best_costs, mut boundaries) = (f32x4::splat(f32::INFINITY), f32x4::ZERO);
        side = Side::EMPTY;
        for (bin, &right_costs) in right_costs.iter().enumerate().take(grid.bins).skip(1) {
            side.grow(of_left, bin - 1);
            let costs = side.costs(align, scale) + right_costs;
            let is_better = costs.simd_lt(best_costs);
            best_costs = is_better.select(costs, best_costs);
            boundaries = is_better.select(f32x4::splat(bin as f32), boundaries);
        }
        let [x, y, z, _] = best_costs.to_array();
        let axis = if x <= y && x <= z {
            0
        } else if y <= z {
            1
        } else {
            2
        };
        let bin = boundaries.as_array()[axis] as usize;
        let cost = best_costs.as_array()[axis];
        (bin > 0).then_some(Boundary { axis, bin, cost })
    }
}

/// The primitives on one side of a boundary, on each axis.
struct Side {
    bounds: [SimdAabb; 3],
    counts: i32x4,
}

impl Side {
    const EMPTY: Self = Self {
        bounds: [SimdAabb::EMPTY; 3],
        counts: i32x4::ZERO,
    };

    #[inline(always)]
    fn grow(&mut self, bins: &Bins, bin: usize) {
        for (side, &bin) in self.bounds.iter_mut().zip(&bins.bounds[bin]) {
            *side = side.union(bin);
        }
        self.counts += i32x4::new(bins.counts[bin]);
    }

    /// The cost of the side on each axis: NaN if it has no references.
    #[inline(always)]
    fn costs(&self, align: usize, scale: f32) -> f32x4 {
        let [x, y, z] = self.bounds.map(SimdAabb::extent);
        let [x, y, z, _] = f32x4::transpose([x, y, z, f32x4::ZERO]).map(|side| side * scale);
        let leaves = (f32x4::from_i32x4(self.counts) / align as f32).ceil();
        (x * y + y * z + z * x) * leaves
    }
}
