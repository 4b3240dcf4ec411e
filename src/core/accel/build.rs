//! Builds a hierarchy: first a binary tree from the top down, which `collapse` then makes wide.
//!
//! The surface area heuristic is binned over all three axes (see `binning`). Subtrees are built in parallel, and the
//! result does not depend on the threads.

use glam::Vec3;
use rayon::prelude::*;

use super::binning::{Bins, Boundary, Grid};
use super::build_prim::{PrimRef, PrimSet, SimdAabb};
use super::collapse::{BinaryTree, Branch, Costs, Tree, collapse};
use super::spatial::{Cut, SpatialBins, divide};
use crate::math::Aabb;

/// How sets of primitives are divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SplitMethod {
    /// No division: all primitives are one list within one box.
    Linear,
    /// Into halves of equal count, along the axis on which the centres spread most.
    Median,
    /// Where the surface area heuristic expects the least work.
    #[default]
    Sah,
}

/// From this depth of the binary tree on, sets are halved by count, so that no u32 number of primitives gets deeper
/// than [`MAX_DEPTH`].
const MEDIAN_DEPTH: usize = 64;
/// No wide node is deeper than the binary tree.
pub(super) const MAX_DEPTH: usize = MEDIAN_DEPTH + 33;

/// Sets at least this large are built on another thread.
const PARALLEL: usize = 4096;
const PARALLEL_BINNING: usize = 1 << 16;

/// A spatial split is only tried if cutting the overlap of the halves in the middle would save at least this share of a
/// set's cost. The search for planes is slow, and most sets gain little.
const WORTH_CUTTING: f32 = 0.07;
/// Smaller sets are not split by planes either, since their leaves would be filled less.
const LEAST_CUT: usize = 256;

struct Builder<'a> {
    method: SplitMethod,
    leaf_size: usize,
    /// Cuts primitives by planes; Some where leaves may hold parts of primitives.
    cut: Option<&'a Cut<'a>>,
    /// A factor that makes areas independent of the scene's unit, so that they stay within f32 in huge and tiny
    /// scenes.
    scale: f32,
}

/// Builds over `count` boxes, with leaves of up to `leaf_size` primitives; a linear list is one leaf of all. With `cut`
/// several leaves may hold the same primitive, each with a box around a part of it.
pub(super) fn build(
    count: usize,
    bounds: impl Fn(usize) -> Aabb + Sync,
    cut: Option<&Cut>,
    method: SplitMethod,
    leaf_size: usize,
) -> Tree {
    let prim = |index| PrimRef::new(&bounds(index), index as u32);
    let mut prims: Vec<PrimRef> = (0..count).into_par_iter().with_min_len(PARALLEL).map(prim).collect();
    let all = prims
        .par_chunks(PARALLEL)
        .map(PrimSet::of_hittable)
        .reduce(|| PrimSet::EMPTY, PrimSet::union);
    if all.len < count {
        prims.retain(PrimRef::is_hittable);
    }
    let [x, y, z, _] = all.bounds.extent().to_array();
    let extent = x.max(y).max(z);
    let scale = if extent > 0.0 {
        extent.recip().clamp(f32::MIN_POSITIVE, f32::MAX)
    } else {
        1.0
    };
    let builder = Builder {
        method,
        leaf_size,
        cut,
        scale,
    };
    let mut tree = BinaryTree::default();
    if !prims.is_empty() {
        let spare = all.len.min(u32::MAX as usize - all.len);
        builder.grow(&mut prims, &all, 0, spare, &mut tree);
    }
    drop(prims);
    collapse(&tree, leaf_size)
}

/// The two halves of a set. Their references replace the set's, the left half's first.
struct Halves {
    left: PrimSet,
    right: PrimSet,
    /// If not empty, it holds the left half's references, and only the right half's replace the set's.
    cut_off: Vec<PrimRef>,
}

impl Halves {
    fn in_place(left: PrimSet, right: PrimSet) -> Self {
        let cut_off = Vec::new();
        Self { left, right, cut_off }
    }
}

impl Builder<'_> {
    fn is_leaf(&self, set: &PrimSet) -> bool {
        set.len <= self.leaf_size || self.method == SplitMethod::Linear
    }

    /// Appends the tree over `set`, the summary of `prims`. Spatial splits below may add up to `spare` references.
    fn grow(&self, prims: &mut [PrimRef], set: &PrimSet, depth: usize, spare: usize, tree: &mut BinaryTree) -> Costs {
        let index = tree.branches.len();
        let (leaf, costs) = Branch::leaf(set, tree.order.len());
        tree.branches.push(leaf);
        if self.is_leaf(set) {
            tree.order.extend(prims.iter().map(|prim| prim.index));
            return costs;
        }
        let by_median = self.method == SplitMethod::Median || depth >= MEDIAN_DEPTH;
        let Halves {
            left,
            right,
            mut cut_off,
        } = if by_median {
            split_in_half(prims, set)
        } else {
            self.split_by_area(prims, set, spare)
        };
        let (of_left, of_right) = if cut_off.is_empty() {
            prims.split_at_mut(left.len)
        } else {
            (&mut cut_off[..], &mut prims[..right.len])
        };
        let spare = spare + set.len - left.len - right.len;
        let left_spare = (spare as u128 * left.len as u128 / (left.len + right.len) as u128) as usize;
        let right_spare = spare - left_spare;
        let right_index;
        let costs = if set.len < PARALLEL {
            let left_costs = self.grow(of_left, &left, depth + 1, left_spare, tree);
            right_index = tree.branches.len();
            [left_costs, self.grow(of_right, &right, depth + 1, right_spare, tree)]
        } else {
            let mut right_tree = BinaryTree::default();
            let (left_costs, right_costs) = rayon::join(
                || self.grow(of_left, &left, depth + 1, left_spare, tree),
                || self.grow(of_right, &right, depth + 1, right_spare, &mut right_tree),
            );
            right_index = tree.branches.len();
            tree.append(right_tree);
            [left_costs, right_costs]
        };
        tree.branches[index].set_children(costs, right_index, set.bounds.half_area(self.scale))
    }

    /// Partitions the set where the surface area heuristic is least.
    fn split_by_area(&self, prims: &mut [PrimRef], set: &PrimSet, spare: usize) -> Halves {
        let Some((boundary, halves)) = self.split_between_centers(prims, set) else {
            return split_in_half(prims, set);
        };
        match self.cut {
            Some(cut) if spare > 0 && set.len >= LEAST_CUT && self.is_worth_cutting(&boundary, &halves) => self
                .split_by_plane(prims, set, boundary.cost, cut, spare)
                .unwrap_or(halves),
            _ => halves,
        }
    }

    fn is_worth_cutting(&self, boundary: &Boundary, Halves { left, right, .. }: &Halves) -> bool {
        let axis = boundary.axis;
        let [mut before, mut behind] = [left, right].map(|set| set.bounds.to_aabb());
        let middle = 0.5 * (before.max[axis] + behind.min[axis]);
        before.max[axis] = before.max[axis].min(middle);
        behind.min[axis] = behind.min[axis].max(middle);
        let cost = |part: &Aabb, set: &PrimSet| {
            SimdAabb::of(part).half_area(self.scale) * set.len.div_ceil(self.leaf_size) as f32
        };
        cost(&before, left) + cost(&behind, right) < (1.0 - WORTH_CUTTING) * boundary.cost
    }

    /// Splits the set by a plane. None if the cost exceeds `most` or the split adds more than `spare` references.
    fn split_by_plane(
        &self,
        prims: &mut [PrimRef],
        set: &PrimSet,
        most: f32,
        cut: &Cut,
        spare: usize,
    ) -> Option<Halves> {
        let grid = SpatialBins::grid(set);
        let bins = in_chunks(prims, |chunk| SpatialBins::fill(&grid, chunk, cut), SpatialBins::merge);
        let (plane, cost) = bins.cheapest(&grid, self.leaf_size, self.scale)?;
        if cost >= most {
            return None;
        }
        let mut sides = divide(prims, plane, cut);
        sides.sort_by_key(Vec::len);
        let [smaller, larger] = sides;
        let is_possible =
            !smaller.is_empty() && larger.len() < prims.len() && smaller.len() + larger.len() <= prims.len() + spare;
        is_possible.then(|| {
            prims[..larger.len()].copy_from_slice(&larger);
            Halves {
                left: PrimSet::of(&smaller),
                right: PrimSet::of(&larger),
                cut_off: smaller,
            }
        })
    }

    /// Partitions at the cheapest boundary between bins, `None` if all centres fall into one bin or no cost is a
    /// number.
    fn split_between_centers(&self, prims: &mut [PrimRef], set: &PrimSet) -> Option<(Boundary, Halves)> {
        let grid = Grid::new(set);
        let bins = in_chunks(prims, |chunk| Bins::fill(&grid, chunk), Bins::merge);
        let boundary = Bins::cheapest([&bins, &bins], &grid, self.leaf_size, self.scale)?;
        let Boundary { axis, bin, .. } = boundary;

        // Every step exchanges two references, needed or not: a branch on the side would cost more, because processors
        // cannot predict it.
        let (mut left, mut right) = (PrimSet::EMPTY, PrimSet::EMPTY);
        for next in 0..prims.len() {
            let prim = prims[next];
            let center = prim.center();
            let is_left = grid.is_before(center, axis, bin);
            prims[next] = prims[left.len];
            prims[left.len] = prim;
            left.add_if(is_left, &prim, center);
            right.add_if(!is_left, &prim, center);
        }
        Some((boundary, Halves::in_place(left, right)))
    }
}

/// Computes `of_chunk` for all references. Large sets are handled in chunks by all threads, whose results are merged.
fn in_chunks<T: Send>(
    prims: &[PrimRef],
    of_chunk: impl Fn(&[PrimRef]) -> T + Sync + Send,
    merge: impl Fn(T, T) -> T + Sync + Send,
) -> T {
    if prims.len() < PARALLEL_BINNING {
        return of_chunk(prims);
    }
    let chunks = prims.par_chunks(PARALLEL_BINNING / 4);
    chunks.map(&of_chunk).reduce_with(merge).expect("there are chunks")
}

/// Splits into halves of equal count along the axis on which the centres spread most. The index decides between equal
/// centres.
fn split_in_half(prims: &mut [PrimRef], set: &PrimSet) -> Halves {
    let [x, y, z, _] = set.centers.extent().to_array();
    let axis = Vec3::new(x, y, z).max_position();
    let middle = prims.len() / 2;
    prims.select_nth_unstable_by(middle, |a, b| {
        let [a_center, b_center] = [a, b].map(|prim| prim.center().as_array()[axis]);
        a_center.total_cmp(&b_center).then(a.index.cmp(&b.index))
    });
    let (left, right) = prims.split_at(middle);
    Halves::in_place(PrimSet::of(left), PrimSet::of(right))
}
