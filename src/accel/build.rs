//! Building a hierarchy: a binary tree from the top down, which `collapse` makes wide.
//!
//! The surface area heuristic is binned over all three axes (see `binning`). Subtrees are built in parallel; what is built depends on the
//! input only.

use glam::Vec3;
use rayon::prelude::*;

use super::binning::{Bins, Grid};
use super::collapse::{Branch, Costs, collapse};
use super::node::Node;
use super::sets::{Reference, Set};
use crate::math::Aabb;

/// How sets of primitives are divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SplitMethod {
    /// Not at all: one flat list, within one box.
    Linear,
    /// Into halves of equal count along the axis on which the centres spread most.
    Median,
    /// Where the surface area heuristic expects the least work.
    #[default]
    Sah,
}

pub(super) struct Tree {
    pub nodes: Vec<Node>,
    pub order: Vec<u32>,
    /// Levels of nodes.
    pub depth: usize,
}

impl Tree {
    /// A root without children.
    pub fn childless() -> Self {
        Self {
            nodes: vec![Node::EMPTY],
            order: Vec::new(),
            depth: 1,
        }
    }
}

/// Fills a leaf up to its size.
pub(super) const NO_PRIMITIVE: u32 = u32::MAX;

/// From this depth of the binary tree on sets are halved by count, which ends within [`MAX_DEPTH`] for any u32 number of primitives.
const MEDIAN_DEPTH: usize = 64;
/// No wide node is deeper than the binary tree.
pub(super) const MAX_DEPTH: usize = MEDIAN_DEPTH + 33;

/// Sets at least this large are worth another thread.
const PARALLEL: usize = 4096;
const PARALLEL_BINNING: usize = 1 << 16;

struct Builder {
    method: SplitMethod,
    leaf_size: usize,
    /// Makes areas independent of the scene's unit, so that neither huge nor tiny scenes leave f32.
    scale: f32,
}

/// Over `count` boxes, with leaves of up to `leaf_size` primitives; a linear list is one leaf of all.
pub(super) fn build(
    count: usize,
    bounds: impl Fn(usize) -> Aabb + Sync,
    method: SplitMethod,
    leaf_size: usize,
) -> Tree {
    let reference = |index| Reference::new(&bounds(index), index as u32);
    let mut references: Vec<Reference> = (0..count)
        .into_par_iter()
        .with_min_len(PARALLEL)
        .map(reference)
        .collect();
    let all = references
        .par_chunks(PARALLEL)
        .map(Set::of_what_can_be_hit)
        .reduce(|| Set::empty(0), Set::union);
    if all.len < count {
        references.retain(Reference::can_be_hit);
    }
    let [x, y, z, _] = all.bounds.extent().to_array();
    let extent = x.max(y).max(z);
    let builder = Builder {
        method,
        leaf_size,
        scale: if extent > 0.0 {
            extent.recip().clamp(f32::MIN_POSITIVE, f32::MAX)
        } else {
            1.0
        },
    };
    let mut branches = Vec::new();
    if !references.is_empty() {
        builder.grow(&mut references, &all, 0, &mut branches);
    }
    collapse(&branches, &references, leaf_size)
}

impl Builder {
    fn is_leaf(&self, set: &Set) -> bool {
        set.len <= self.leaf_size || self.method == SplitMethod::Linear
    }

    /// Appends the tree over `set`, which is all of `references`.
    fn grow(&self, references: &mut [Reference], set: &Set, depth: usize, branches: &mut Vec<Branch>) -> Costs {
        let index = branches.len();
        let (leaf, costs) = Branch::leaf(set);
        branches.push(leaf);
        if self.is_leaf(set) {
            return costs;
        }
        let by_median = self.method == SplitMethod::Median || depth >= MEDIAN_DEPTH;
        let split = if by_median {
            None
        } else {
            self.split_by_area(references, set)
        };
        let (left, right) = split.unwrap_or_else(|| split_in_half(references, set));
        let (of_left, of_right) = references.split_at_mut(left.len);
        let right_index;
        let costs = if set.len < PARALLEL {
            let left_costs = self.grow(of_left, &left, depth + 1, branches);
            right_index = branches.len();
            [left_costs, self.grow(of_right, &right, depth + 1, branches)]
        } else {
            let mut right_branches = Vec::new();
            let (left_costs, right_costs) = rayon::join(
                || self.grow(of_left, &left, depth + 1, branches),
                || self.grow(of_right, &right, depth + 1, &mut right_branches),
            );
            right_index = branches.len();
            append(branches, right_branches);
            [left_costs, right_costs]
        };
        branches[index].set_children(costs, right_index, set.bounds.half_area(self.scale))
    }

    /// Partitions at the cheapest boundary between bins, `None` if all centres fall into one bin or no cost is a number.
    fn split_by_area(&self, references: &mut [Reference], set: &Set) -> Option<(Set, Set)> {
        let grid = Grid::new(set);
        let bins = if references.len() >= PARALLEL_BINNING {
            references
                .par_chunks(PARALLEL_BINNING / 4)
                .map(|chunk| Bins::fill(&grid, chunk))
                .reduce_with(Bins::merge)?
        } else {
            Bins::fill(&grid, references)
        };
        let (axis, boundary) = bins.cheapest(&grid, self.leaf_size, self.scale)?;

        // Every step exchanges two references, needed or not: which side one is on cannot be foreseen, so a branch would cost more.
        let (mut left, mut right) = (Set::empty(set.start), Set::empty(0));
        for next in 0..references.len() {
            let reference = references[next];
            let center = reference.center();
            let is_left = grid.is_before(center, axis, boundary);
            references[next] = references[left.len];
            references[left.len] = reference;
            left.add_if(is_left, &reference, center);
            right.add_if(!is_left, &reference, center);
        }
        right.start = set.start + left.len;
        Some((left, right))
    }
}

/// Appends a tree, whose indices count from its own start.
fn append(branches: &mut Vec<Branch>, tree: Vec<Branch>) {
    let base = branches.len();
    branches.extend(tree.into_iter().map(|mut branch| {
        branch.advance(base);
        branch
    }));
}

/// Halves by count along the axis on which the centres spread most; equal centres are told apart by index.
fn split_in_half(references: &mut [Reference], set: &Set) -> (Set, Set) {
    let [x, y, z, _] = set.centers.extent().to_array();
    let axis = Vec3::new(x, y, z).max_position();
    let middle = references.len() / 2;
    references.select_nth_unstable_by(middle, |a, b| {
        let [a_center, b_center] = [a, b].map(|reference| reference.center().as_array()[axis]);
        a_center.total_cmp(&b_center).then(a.index.cmp(&b.index))
    });
    let (left, right) = references.split_at(middle);
    (Set::of(set.start, left), Set::of(set.start + middle, right))
}
