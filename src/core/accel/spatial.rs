//! Spatial splits: a plane divides a set of references, and both sides hold the primitives that it cuts (Stich,
//! Friedrich and Dietrich, Spatial splits in bounding volume hierarchies, 2009). They pay off where primitives are
//! long, or large compared with their neighbours.

use glam::Vec3;

use super::binning::{Bins, Grid};
use super::build_prim::{Plane, PrimRef, PrimSet, SimdAabb};
use crate::math::Aabb;

/// A function that cuts the part of a primitive within a box by a plane across an axis, and returns the boxes around
/// the parts before and behind the plane. The box of an empty side is empty.
pub(super) type Cut<'a> = dyn Fn(u32, &Aabb, Plane) -> [Aabb; 2] + Sync + 'a;

/// The number of slabs along each axis; the planes between them are tried.
const BINS: usize = 16;

/// Two sets of bins: one counts the primitives that begin in a bin, the other those that end there. The boxes of both
/// surround all parts of primitives in the bin.
pub(super) struct SpatialBins {
    begins: Bins,
    ends: Bins,
}

impl SpatialBins {
    pub fn grid(set: &PrimSet) -> Grid {
        Grid::over(set.bounds, BINS)
    }

    pub fn fill(grid: &Grid, prims: &[PrimRef], cut: &Cut) -> Self {
        let [mut begins, mut ends] = [Bins::EMPTY; 2];
        for prim in prims {
            let bounds = prim.bounds();
            let (first, last) = (grid.bin(bounds.min()), grid.bin(bounds.max()));
            begins.count(first);
            ends.count(last);
            if first == last {
                begins.add(first, bounds);
                continue;
            }
            for axis in 0..3 {
                let mut rest = bounds.to_aabb();
                for bin in first[axis]..last[axis] {
                    let [here, beyond] = cut(prim.index, &rest, grid.plane(axis, bin + 1));
                    begins.add_on(axis, bin, SimdAabb::of_part(&here));
                    rest = beyond;
                }
                begins.add_on(axis, last[axis], SimdAabb::of_part(&rest));
            }
        }
        ends.bounds = begins.bounds;
        Self { begins, ends }
    }

    pub fn merge(self, other: Self) -> Self {
        Self {
            begins: self.begins.merge(other.begins),
            ends: self.ends.merge(other.ends),
        }
    }

    /// Finds the cheapest plane, with its cost.
    pub fn cheapest(&self, grid: &Grid, align: usize, scale: f32) -> Option<(Plane, f32)> {
        let boundary = Bins::cheapest([&self.begins, &self.ends], grid, align, scale)?;
        Some((grid.plane(boundary.axis, boundary.bin), boundary.cost))
    }
}

/// Returns the references before and behind the plane.
pub(super) fn divide(prims: &[PrimRef], plane: Plane, cut: &Cut) -> [Vec<PrimRef>; 2] {
    let mut sides = [Vec::new(), Vec::new()];
    for prim in prims {
        let bounds = prim.bounds().to_aabb();
        if bounds.max[plane.axis] <= plane.at {
            sides[0].push(*prim);
        } else if bounds.min[plane.axis] >= plane.at {
            sides[1].push(*prim);
        } else {
            for (side, part) in sides.iter_mut().zip(cut(prim.index, &bounds, plane)) {
                let part = PrimRef::new(&part, prim.index);
                if part.is_hittable() {
                    side.push(part);
                }
            }
        }
    }
    sides
}

/// Cuts a triangle, as a [`Cut`].
pub(super) fn cut_triangle(corners: [Vec3; 3], part: &Aabb, plane: Plane) -> [Aabb; 2] {
    let Plane { axis, at } = plane;
    let mut sides = [Aabb::EMPTY; 2];
    for (k, &corner) in corners.iter().enumerate() {
        if corner[axis] <= at {
            sides[0] = sides[0].grown(corner);
        }
        if corner[axis] >= at {
            sides[1] = sides[1].grown(corner);
        }
        let next = corners[(k + 1) % 3];
        if (corner[axis] < at) != (next[axis] < at) && corner[axis] != at && next[axis] != at {
            let (from, to) = (corner.as_dvec3(), next.as_dvec3());
            let mut crossing = from.lerp(to, (f64::from(at) - from[axis]) / (to[axis] - from[axis]));
            crossing[axis] = f64::from(at);
            // This box holds the exact point whatever the rounding.
            let error = 4.0 * f64::EPSILON * from.abs().max(to.abs());
            let [min, max] = [crossing - error, crossing + error].map(|corner| corner.as_vec3().to_array());
            let around = Aabb {
                min: Vec3::from_array(min.map(f32::next_down)),
                max: Vec3::from_array(max.map(f32::next_up)),
            };
            sides = sides.map(|side| side.union(around));
        }
    }
    sides[0].max[axis] = sides[0].max[axis].min(at);
    sides[1].min[axis] = sides[1].min[axis].max(at);
    sides.map(|side| side.intersection(*part))
}
