//! Building a hierarchy from the top down, straight into wide nodes.
//!
//! A node starts with one set of primitives and splits, again and again, the set with the largest surface (with the most members, for
//! the median) until it has eight or none can be split. The surface area heuristic is binned over all three axes (Wald, On fast
//! construction of SAH-based bounding volume hierarchies, 2007). Subtrees are built in parallel; what is built depends on the input only.

use glam::Vec3A;
use rayon::prelude::*;

use super::bvh::can_be_hit;
use super::node::{Node, WIDTH};
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

/// What leaves look like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeafShape {
    /// Sets of more primitives are divided (except in a linear list). At least 1.
    pub max_primitives: usize,
    /// Primitives that are tested together: leaves start at multiples of it in the order, and cost as many tests as it takes. At least 1.
    pub align: usize,
}

pub(super) struct Tree {
    pub nodes: Vec<Node>,
    pub order: Vec<u32>,
}

/// Fills a leaf up to its alignment.
pub(super) const NO_PRIMITIVE: u32 = u32::MAX;

/// From this depth on sets are halved by count, largest first, which ends within [`MAX_DEPTH`] for any u32 number of primitives.
const MEDIAN_DEPTH: usize = 14;
pub(super) const MAX_DEPTH: usize = MEDIAN_DEPTH + 13;

/// Sets at least this large are worth another thread.
const PARALLEL: usize = 4096;
const PARALLEL_BINNING: usize = 1 << 16;

const MAX_BINS: usize = 16;

/// Coordinates are clamped to this when centres are taken, so that sums of two and differences of sums stay finite.
const LIMIT: f32 = f32::MAX / 8.0;

#[derive(Clone, Copy)]
struct Reference {
    min: Vec3A,
    max: Vec3A,
    index: u32,
}

impl Reference {
    /// Twice the centre.
    #[inline(always)]
    fn center(&self) -> Vec3A {
        self.min.max(Vec3A::splat(-LIMIT)) + self.max.min(Vec3A::splat(LIMIT))
    }
}

#[derive(Clone, Copy)]
struct Bounds {
    min: Vec3A,
    max: Vec3A,
}

impl Bounds {
    const EMPTY: Self = Self {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
    };

    #[inline(always)]
    fn grow(&mut self, min: Vec3A, max: Vec3A) {
        self.min = self.min.min(min);
        self.max = self.max.max(max);
    }

    fn half_area(&self, scale: f32) -> f32 {
        let e = (self.max - self.min) * scale;
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    fn to_aabb(self) -> Aabb {
        Aabb {
            min: self.min.into(),
            max: self.max.into(),
        }
    }
}

/// A run of references with the box around them and the box around their (doubled) centres.
#[derive(Clone, Copy)]
struct Set {
    start: usize,
    len: usize,
    bounds: Bounds,
    centers: Bounds,
}

impl Set {
    fn empty(start: usize) -> Self {
        Self {
            start,
            len: 0,
            bounds: Bounds::EMPTY,
            centers: Bounds::EMPTY,
        }
    }

    #[inline(always)]
    fn add(&mut self, reference: &Reference) {
        self.len += 1;
        self.bounds.grow(reference.min, reference.max);
        let center = reference.center();
        self.centers.grow(center, center);
    }

    fn of(start: usize, references: &[Reference]) -> Self {
        let mut set = Self::empty(start);
        references.iter().for_each(|reference| set.add(reference));
        set
    }
}

struct Builder {
    method: SplitMethod,
    leaf: LeafShape,
    /// Makes areas independent of the scene's unit, so that neither huge nor tiny scenes leave f32.
    scale: f32,
}

pub(super) fn build(bounds: &[Aabb], method: SplitMethod, leaf: LeafShape) -> Tree {
    let leaf = LeafShape {
        max_primitives: leaf.max_primitives.max(1),
        align: leaf.align.max(1),
    };
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
        leaf,
        scale: if extent > 0.0 {
            extent.recip().clamp(f32::MIN_POSITIVE, f32::MAX)
        } else {
            1.0
        },
    };
    let mut tree = Tree {
        nodes: Vec::with_capacity(references.len() / leaf.max_primitives / 2 + 1),
        order: Vec::with_capacity(references.len() + references.len() / 2),
    };
    if references.is_empty() {
        tree.nodes.push(Node::EMPTY);
    } else {
        builder.build_node(&mut references, all, 0, &mut tree);
    }
    tree
}

impl Builder {
    fn is_leaf(&self, set: &Set) -> bool {
        set.len <= self.leaf.max_primitives || self.method == SplitMethod::Linear
    }

    /// Appends the node over `set`, which is all of `references`, and everything below it; returns its index.
    fn build_node(&self, references: &mut [Reference], set: Set, depth: usize, tree: &mut Tree) -> u32 {
        let index = tree.nodes.len();
        tree.nodes.push(Node::EMPTY);
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
                let (target, count) = self.build_child(part, child, depth, tree);
                tree.nodes[index].set(slot, &child.bounds.to_aabb(), target, count);
            }
        } else {
            let subtrees: Vec<_> = parts
                .into_par_iter()
                .map(|(slot, child, part)| {
                    let mut subtree = Tree {
                        nodes: Vec::new(),
                        order: Vec::new(),
                    };
                    let (target, count) = self.build_child(part, child, depth, &mut subtree);
                    (slot, child, target, count, subtree)
                })
                .collect();
            for (slot, child, target, count, subtree) in subtrees {
                let base = if count == 0 { tree.nodes.len() } else { tree.order.len() };
                tree.nodes[index].set(slot, &child.bounds.to_aabb(), base as u32 + target, count);
                tree.append(subtree);
            }
        }
        index as u32
    }

    /// Appends a leaf or an inner node for `set`; returns what the parent's slot holds: `child` and `count`.
    fn build_child(&self, references: &mut [Reference], set: &Set, depth: usize, tree: &mut Tree) -> (u32, u32) {
        if !self.is_leaf(set) {
            return (self.build_node(references, *set, depth + 1, tree), 0);
        }
        let first = tree.order.len();
        tree.order.extend(references.iter().map(|reference| reference.index));
        tree.order
            .resize(tree.order.len().next_multiple_of(self.leaf.align), NO_PRIMITIVE);
        (first as u32, set.len as u32)
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
        let (axis, boundary) = bins.cheapest(&grid, self.leaf.align, self.scale)?;

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

/// Where bins lie: equal slices of the centres' box on each axis.
struct Grid {
    origin: Vec3A,
    scale: Vec3A,
    bins: usize,
}

impl Grid {
    fn new(set: &Set) -> Self {
        let bins = (4 + set.len / 8).min(MAX_BINS);
        let spread = set.centers.max - set.centers.min;
        let scale = Vec3A::splat(bins as f32 * (1.0 - 1e-6)) / spread;
        Self {
            origin: set.centers.min,
            // An axis without spread has one bin.
            scale: Vec3A::select(scale.is_finite_mask(), scale, Vec3A::ZERO),
            bins,
        }
    }

    #[inline(always)]
    fn bin(&self, center: Vec3A) -> [usize; 3] {
        let position = (center - self.origin) * self.scale;
        let last = MAX_BINS as i32 - 1;
        position.to_array().map(|x| (x as i32).clamp(0, last) as usize)
    }
}

struct Bins {
    bounds: [[Bounds; MAX_BINS]; 3],
    counts: [[u32; MAX_BINS]; 3],
}

impl Bins {
    fn fill(grid: &Grid, references: &[Reference]) -> Self {
        let mut bins = Self {
            bounds: [[Bounds::EMPTY; MAX_BINS]; 3],
            counts: [[0; MAX_BINS]; 3],
        };
        for reference in references {
            let at = grid.bin(reference.center());
            for axis in 0..3 {
                bins.bounds[axis][at[axis]].grow(reference.min, reference.max);
                bins.counts[axis][at[axis]] += 1;
            }
        }
        bins
    }

    fn merge(mut self, other: Self) -> Self {
        for axis in 0..3 {
            for bin in 0..MAX_BINS {
                let Bounds { min, max } = other.bounds[axis][bin];
                self.bounds[axis][bin].grow(min, max);
                self.counts[axis][bin] += other.counts[axis][bin];
            }
        }
        self
    }

    /// Axis and first bin of the right side.
    fn cheapest(&self, grid: &Grid, align: usize, scale: f32) -> Option<(usize, usize)> {
        let cost = |bounds: &Bounds, count: u32| bounds.half_area(scale) * (count as usize).div_ceil(align) as f32;
        let mut best = None;
        let mut best_cost = f32::INFINITY;
        for axis in 0..3 {
            if grid.scale[axis] == 0.0 {
                continue;
            }
            let mut right_costs = [0.0; MAX_BINS];
            let (mut bounds, mut count) = (Bounds::EMPTY, 0);
            for bin in (1..grid.bins).rev() {
                let Bounds { min, max } = self.bounds[axis][bin];
                bounds.grow(min, max);
                count += self.counts[axis][bin];
                right_costs[bin] = if count > 0 { cost(&bounds, count) } else { f32::INFINITY };
            }
            (bounds, count) = (Bounds::EMPTY, 0);
            for bin in 1..grid.bins {
                let Bounds { min, max } = self.bounds[axis][bin - 1];
                bounds.grow(min, max);
                count += self.counts[axis][bin - 1];
                if count == 0 {
                    continue;
                }
                let total = cost(&bounds, count) + right_costs[bin];
                if total < best_cost {
                    best_cost = total;
                    best = Some((axis, bin));
                }
            }
        }
        best
    }
}

impl Tree {
    /// Appends a subtree, whose indices count from its own start.
    fn append(&mut self, mut subtree: Self) {
        let (nodes, order) = (self.nodes.len() as u32, self.order.len() as u32);
        for node in &mut subtree.nodes {
            for slot in 0..node.slots_used() {
                node.child[slot] += if node.count[slot] == 0 { nodes } else { order };
            }
        }
        self.nodes.append(&mut subtree.nodes);
        self.order.append(&mut subtree.order);
    }
}
