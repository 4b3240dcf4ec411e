//! Building a hierarchy from the top down, straight into wide nodes.
//!
//! A node starts with one set of primitives and splits, again and again, the set with the largest surface (with the most members, for
//! the median) until it has eight or none can be split. The surface area heuristic is binned over all three axes (see `binning`). Subtrees are built in parallel; what is built depends on the input only.

use rayon::prelude::*;

use super::binning::{Bins, Grid};
use super::bvh::can_be_hit;
use super::node::{Child, Node, WIDTH};
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
    fn with_capacity(nodes: usize, order: usize) -> Self {
        Self {
            nodes: Vec::with_capacity(nodes),
            order: Vec::with_capacity(order),
            depth: 0,
        }
    }

    /// Appends a subtree, whose indices count from its own start.
    fn append(&mut self, mut subtree: Self, leaf_size: usize) {
        let (nodes, blocks) = (self.nodes.len(), self.order.len() / leaf_size);
        for node in &mut subtree.nodes {
            let used = node.slots_used();
            for child in &mut node.children[..used] {
                *child = child.moved(nodes, blocks);
            }
        }
        self.nodes.append(&mut subtree.nodes);
        self.order.append(&mut subtree.order);
        self.depth = self.depth.max(subtree.depth);
    }
}

/// Fills a leaf up to its size.
pub(super) const NO_PRIMITIVE: u32 = u32::MAX;

/// From this depth on sets are halved by count, largest first, which ends within [`MAX_DEPTH`] for any u32 number of primitives.
const MEDIAN_DEPTH: usize = 14;
pub(super) const MAX_DEPTH: usize = MEDIAN_DEPTH + 13;

/// Sets at least this large are worth another thread.
const PARALLEL: usize = 4096;
const PARALLEL_BINNING: usize = 1 << 16;

struct Builder {
    method: SplitMethod,
    leaf_size: usize,
    /// Makes areas independent of the scene's unit, so that neither huge nor tiny scenes leave f32.
    scale: f32,
}

/// With leaves of up to `leaf_size` primitives; a linear list is one leaf of all.
pub(super) fn build(bounds: &[Aabb], method: SplitMethod, leaf_size: usize) -> Tree {
    let mut references: Vec<Reference> = bounds
        .iter()
        .zip(0..)
        .filter(|(bounds, _)| can_be_hit(bounds))
        .map(|(bounds, index)| Reference {
            min: bounds.min.into(),
            max: bounds.max.into(),
            index,
        })
        .collect();
    let all = Set::of(0, &references);
    let extent = (all.bounds.max - all.bounds.min).max_element();
    let builder = Builder {
        method,
        leaf_size,
        scale: if extent > 0.0 {
            extent.recip().clamp(f32::MIN_POSITIVE, f32::MAX)
        } else {
            1.0
        },
    };
    let expected_leaves = references.len() / leaf_size;
    let mut tree = Tree::with_capacity(expected_leaves / 2, 2 * references.len());
    if references.is_empty() {
        tree.nodes.push(Node::EMPTY);
        tree.depth = 1;
    } else {
        builder.build_node(&mut references, all, 0, &mut tree);
    }
    tree
}

impl Builder {
    fn is_leaf(&self, set: &Set) -> bool {
        set.len <= self.leaf_size || self.method == SplitMethod::Linear
    }

    /// Appends the node over `set`, which is all of `references`, and everything below it; returns its index.
    fn build_node(&self, references: &mut [Reference], set: Set, depth: usize, tree: &mut Tree) -> usize {
        let index = tree.nodes.len();
        tree.nodes.push(Node::EMPTY);
        tree.depth = tree.depth.max(depth + 1);
        let children = self.divide(references, Set { start: 0, ..set }, depth);

        let mut rest = references;
        let mut parts = Vec::with_capacity(WIDTH);
        for (slot, child) in children.iter().enumerate() {
            let (part, after) = rest.split_at_mut(child.len);
            rest = after;
            parts.push((slot, child, part));
        }
        if set.len < PARALLEL {
            for (slot, child, part) in parts {
                let target = self.build_child(part, child, depth, tree);
                tree.nodes[index].set(slot, &child.bounds.to_aabb(), target);
            }
        } else {
            let subtrees: Vec<_> = parts
                .into_par_iter()
                .map(|(slot, child, part)| {
                    let mut subtree = Tree::with_capacity(0, 0);
                    let target = self.build_child(part, child, depth, &mut subtree);
                    (slot, child, target, subtree)
                })
                .collect();
            for (slot, child, target, subtree) in subtrees {
                let target = target.moved(tree.nodes.len(), tree.order.len() / self.leaf_size);
                tree.nodes[index].set(slot, &child.bounds.to_aabb(), target);
                tree.append(subtree, self.leaf_size);
            }
        }
        index
    }

    /// Appends a leaf or an inner node for `set`; returns what the parent's slot holds.
    fn build_child(&self, references: &mut [Reference], set: &Set, depth: usize, tree: &mut Tree) -> Child {
        if !self.is_leaf(set) {
            return Child::node(self.build_node(references, *set, depth + 1, tree));
        }
        let block = tree.order.len() / self.leaf_size;
        tree.order.extend(references.iter().map(|reference| reference.index));
        tree.order
            .resize(tree.order.len().next_multiple_of(self.leaf_size), NO_PRIMITIVE);
        // A linear list says how long it is itself.
        Child::leaf(block, set.len.min(self.leaf_size))
    }

    /// The sets that become a node's children, in the order of their references.
    fn divide(&self, references: &mut [Reference], set: Set, depth: usize) -> Vec<Set> {
        let by_median = self.method == SplitMethod::Median || depth >= MEDIAN_DEPTH;
        let mut sets = Vec::with_capacity(WIDTH);
        sets.push(set);
        while sets.len() < WIDTH {
            let weight = |set: &Set| {
                if by_median {
                    set.len as f32
                } else {
                    set.bounds.half_area(self.scale)
                }
            };
            let largest = (0..sets.len())
                .filter(|&i| !self.is_leaf(&sets[i]))
                .max_by(|&i, &j| weight(&sets[i]).total_cmp(&weight(&sets[j])));
            let Some(largest) = largest else { break };
            let set = sets[largest];
            let part = &mut references[set.start..set.start + set.len];
            let split = if by_median {
                None
            } else {
                self.split_by_area(part, &set)
            };
            let (left, right) = split.unwrap_or_else(|| split_in_half(part, &set));
            sets[largest] = left;
            sets.insert(largest + 1, right);
        }
        sets
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

        let (mut left, mut right) = (Set::empty(set.start), Set::empty(0));
        let mut end = references.len();
        while left.len < end {
            let reference = references[left.len];
            if grid.bin(reference.center())[axis] < boundary {
                left.add(&reference);
            } else {
                right.add(&reference);
                end -= 1;
                references.swap(left.len, end);
            }
        }
        right.start = set.start + left.len;
        Some((left, right))
    }
}

/// Halves by count along the axis on which the centres spread most; equal centres are told apart by index.
fn split_in_half(references: &mut [Reference], set: &Set) -> (Set, Set) {
    let spread = set.centers.max - set.centers.min;
    let axis = spread.max_position();
    let middle = references.len() / 2;
    references.select_nth_unstable_by(middle, |a, b| {
        a.center()[axis]
            .total_cmp(&b.center()[axis])
            .then(a.index.cmp(&b.index))
    });
    let (left, right) = references.split_at(middle);
    (Set::of(set.start, left), Set::of(set.start + middle, right))
}
