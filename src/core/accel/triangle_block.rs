//! Triangles that are tested together: the arithmetic of [`crate::geometry::triangle`], a triangle per lane.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use wide::f32x8;

use super::hit::MeshHit;
use super::memory::prefetch;
use crate::geometry::triangle::TriangleRay;

pub(super) const LANES: usize = 8;
type Lanes = f32x8;

/// Up to eight triangles in structure-of-arrays form. Unused lanes hold NaN, which no ray hits.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct TriangleBlock {
    /// `corners[axis][corner]`, a triangle per lane.
    corners: [[Lanes; 3]; 3],
    /// The mesh's triangle in each lane.
    pub triangle: [u32; LANES],
}

impl TriangleBlock {
    pub const EMPTY: Self = Self {
        corners: [[Lanes::splat(f32::NAN); 3]; 3],
        triangle: [u32::MAX; LANES],
    };

    pub fn set(&mut self, lane: usize, corners: [Vec3; 3], triangle: u32) {
        for (corner, point) in corners.into_iter().enumerate() {
            for axis in 0..3 {
                self.corners[axis][corner].as_mut_array()[lane] = point[axis];
            }
        }
        self.triangle[lane] = triangle;
    }

    #[inline(always)]
    pub fn corners(&self, lane: usize) -> [Vec3; 3] {
        let place = |axis: usize, corner: usize| self.corners[axis][corner].as_array()[lane];
        let corner = |corner: usize| Vec3::new(place(0, corner), place(1, corner), place(2, corner));
        [corner(0), corner(1), corner(2)]
    }

    /// Computes ray parameters, weights, and a bit for each lane whose triangle is met within t_min < t <= t_max.
    #[inline(always)]
    fn test(&self, ray: &TriangleRay, t_max: f32) -> (Lanes, [Lanes; 3], u32) {
        let [x, y, z] = ray.axes.map(|axis| &self.corners[axis]);
        let corners = [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]];
        let corners = ray.relative(corners, Lanes::splat);
        let weights = ray.weights(corners, Lanes::splat);
        let [u, v, w] = weights;
        let zero = Lanes::ZERO;
        let lowest = u.fast_min(v).fast_min(w);
        let highest = u.fast_max(v).fast_max(w);
        let inside = lowest.simd_ge(zero) | highest.simd_le(zero);
        let [t_numerator, determinant] = ray.plane(corners, Lanes::splat);
        let t = t_numerator / determinant;
        // A degenerate triangle gives t = 0 / 0, for which every comparison fails; one seen edge-on may have weights
        // that sum to zero.
        let hits =
            inside & (u + v + w).simd_ne(zero) & t.simd_gt(Lanes::splat(ray.t_min)) & t.simd_le(Lanes::splat(t_max));
        (t, weights, hits.to_bitmask())
    }

    /// The nearest hit in this block, which is the `number`-th. `t_max` is the distance of the hit of the slot `found`,
    /// or the limit if there is none. Of two hits at the same distance the lower slot wins, so that the order of tests
    /// does not matter.
    #[inline(always)]
    pub fn closest(&self, number: usize, ray: &TriangleRay, t_max: f32, found: Option<u32>) -> Option<MeshHit> {
        let (distance, weights, mut hits) = self.test(ray, t_max);
        if hits == 0 {
            return None;
        }
        let distance = distance.to_array();
        let weights = weights.map(Lanes::to_array);
        let mut nearest = hits.trailing_zeros() as usize % LANES;
        hits &= hits - 1;
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize % LANES;
            hits &= hits - 1;
            if distance[lane] < distance[nearest] {
                nearest = lane;
            }
        }
        let slot = (number * LANES + nearest) as u32;
        if distance[nearest] == t_max && found.is_none_or(|found| found <= slot) {
            return None;
        }
        let sum = weights[0][nearest] + weights[1][nearest] + weights[2][nearest];
        Some(MeshHit {
            t: distance[nearest],
            triangle: self.triangle[nearest],
            u: weights[1][nearest] / sum,
            v: weights[2][nearest] / sum,
            slot,
        })
    }

    /// Prefetches the corners.
    #[inline(always)]
    pub fn prefetch(&self) {
        // Every second vector begins a cache line.
        self.corners.as_flattened().iter().step_by(2).for_each(prefetch);
    }

    #[inline(always)]
    pub fn any(&self, ray: &TriangleRay, t_max: f32) -> bool {
        let (t, _, hits) = self.test(ray, t_max);
        hits & t.simd_lt(Lanes::splat(t_max)).to_bitmask() != 0
    }
}
