//! Binned evaluation of the surface area heuristic over all three axes (Wald, On fast construction of SAH-based bounding volume
//! hierarchies, 2007).

use wide::f32x4;

use super::sets::{Bounds, Reference, Set};

const MAX_BINS: usize = 16;

/// Where bins lie: equal slices of the centres' box on each axis.
pub(super) struct Grid {
    origin: f32x4,
    scale: f32x4,
    bins: usize,
}

impl Grid {
    pub fn new(set: &Set) -> Self {
        let bins = (4 + set.len / 8).min(MAX_BINS);
        let scale = f32x4::splat(bins as f32 * (1.0 - 1e-6)) / set.centers.extent();
        Self {
            origin: set.centers.min(),
            // An axis without spread has one bin.
            scale: scale & scale.is_finite(),
            bins,
        }
    }

    /// On each axis the number of a bin and what is left.
    #[inline(always)]
    pub fn position(&self, center: f32x4) -> f32x4 {
        (center - self.origin) * self.scale
    }

    #[inline(always)]
    pub fn bin(&self, center: f32x4) -> [usize; 3] {
        let [x, y, z, _] = self.position(center).fast_trunc_int().to_array();
        [x, y, z].map(|bin| bin as usize % MAX_BINS)
    }
}

pub(super) struct Bins {
    bounds: [[Bounds; MAX_BINS]; 3],
    counts: [[u32; MAX_BINS]; 3],
}

impl Bins {
    pub fn fill(grid: &Grid, references: &[Reference]) -> Self {
        let mut bins = Self {
            bounds: [[Bounds::EMPTY; MAX_BINS]; 3],
            counts: [[0; MAX_BINS]; 3],
        };
        for reference in references {
            let at = grid.bin(reference.center());
            for (axis, &bin) in at.iter().enumerate() {
                let bounds = &mut bins.bounds[axis][bin];
                *bounds = bounds.union(reference.bounds());
                bins.counts[axis][bin] += 1;
            }
        }
        bins
    }

    pub fn merge(mut self, other: Self) -> Self {
        for axis in 0..3 {
            for bin in 0..MAX_BINS {
                let bounds = &mut self.bounds[axis][bin];
                *bounds = bounds.union(other.bounds[axis][bin]);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }

    /// Axis and first bin of the right side.
    pub fn cheapest(&self, grid: &Grid, align: usize, scale: f32) -> Option<(usize, usize)> {
        let cost = |bounds: &Bounds, count: u32| bounds.half_area(scale) * (count as usize).div_ceil(align) as f32;
        let mut best = None;
        let mut best_cost = f32::INFINITY;
        for axis in 0..3 {
            if grid.scale.as_array()[axis] == 0.0 {
                continue;
            }
            let mut right_costs = [0.0; MAX_BINS];
            let (mut bounds, mut count) = (Bounds::EMPTY, 0);
            for bin in (1..grid.bins).rev() {
                bounds = bounds.union(self.bounds[axis][bin]);
                count += self.counts[axis][bin];
                right_costs[bin] = if count > 0 { cost(&bounds, count) } else { f32::INFINITY };
            }
            (bounds, count) = (Bounds::EMPTY, 0);
            for (bin, right_cost) in right_costs.iter().enumerate().take(grid.bins).skip(1) {
                bounds = bounds.union(self.bounds[axis][bin - 1]);
                count += self.counts[axis][bin - 1];
                if count == 0 {
                    continue;
                }
                let total = cost(&bounds, count) + right_cost;
                if total < best_cost {
                    best_cost = total;
                    best = Some((axis, bin));
                }
            }
        }
        best
    }
}
