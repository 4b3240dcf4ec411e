//! The hierarchy: its nodes, its statistics and its validation. It is built in `build` and traversed in `traverse`.

use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use super::build::{MAX_DEPTH, SplitMethod, build};
use super::collapse::{NO_PRIMITIVE, Tree};
use super::node::{Child, MAX_LEAF, Node, WIDTH};
use super::spatial::Cut;
use crate::math::Aabb;

/// A wide (8 children a node) bounding volume hierarchy over boxes.
///
/// Node 0 is the root and has no box of its own; an empty hierarchy is a root without children.
#[derive(Clone, Debug)]
pub struct Bvh {
    pub(super) nodes: Vec<Node>,
    /// Primitive indices in leaf order. Each leaf starts at a multiple of `leaf_size`; gaps hold [`NO_PRIMITIVE`].
    pub(super) order: Vec<u32>,
    pub(super) leaf_size: usize,
    /// The number of primitives in the only leaf of a linear list; None for other hierarchies.
    pub(super) linear: Option<usize>,
    /// Levels of nodes, at most [`MAX_DEPTH`].
    pub(super) depth: usize,
}

/// Statistics of a built hierarchy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BvhStats {
    /// Inner nodes, each of up to eight children.
    pub nodes: usize,
    /// Leaves with at least one primitive.
    pub leaves: usize,
    /// The greatest depth of a node; the root is at depth 1.
    pub max_depth: usize,
    /// Expected work of a random ray that meets the root's box: the sum over all children of (box area / root area),
    /// times the number of primitives for leaves.
    pub sah_cost: f32,
    /// The memory in bytes.
    pub bytes: usize,
}

/// One box of the hierarchy, for display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BvhBox {
    /// The box, in the space of the hierarchy.
    pub bounds: Aabb,
    /// 0 for the box around all primitives, 1 for the root's children, and so on.
    pub depth: usize,
    /// Whether it holds primitives rather than further boxes.
    pub is_leaf: bool,
    /// The number of primitives of a leaf; zero for other boxes.
    pub primitives: u32,
}

impl Bvh {
    /// Builds over `bounds`, with leaves of up to `leaf_size` primitives (1 to 16), whose tests are assumed to cost as
    /// much as one. Empty boxes and boxes with a NaN cannot be hit and are left out.
    pub fn build(bounds: &[Aabb], method: SplitMethod, leaf_size: usize) -> Self {
        Self::over(bounds.len(), |index| bounds[index], None, method, leaf_size)
    }

    /// [`Bvh::build`] over `count` boxes. `bounds` is called once for each.
    pub(super) fn over(
        count: usize,
        bounds: impl Fn(usize) -> Aabb + Sync,
        cut: Option<&Cut>,
        method: SplitMethod,
        leaf_size: usize,
    ) -> Self {
        let leaf_size = leaf_size.clamp(1, MAX_LEAF);
        let Tree { nodes, order, depth } = build(count, bounds, cut, method, leaf_size);
        let mut bvh = Self {
            nodes,
            order,
            leaf_size,
            linear: None,
            depth,
        };
        bvh.linear = (method == SplitMethod::Linear).then(|| bvh.listed());
        bvh
    }

    /// Whether all primitives are in one leaf of any size.
    pub(super) fn is_linear(&self) -> bool {
        self.linear.is_some()
    }

    /// The range of the leaf order that the leaf `child` holds.
    #[inline(always)]
    pub(super) fn leaf_range(&self, child: Child) -> Range<usize> {
        let start = child.index() * self.leaf_size;
        start..start + self.linear.unwrap_or(child.count())
    }

    /// Primitive indices in leaf order; `u32::MAX` fills a leaf up to its size.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The number of primitives in the leaf order; a primitive in several leaves counts once for each.
    pub(super) fn listed(&self) -> usize {
        self.order
            .par_iter()
            .filter(|&&primitive| primitive != NO_PRIMITIVE)
            .count()
    }

    /// The same tree around boxes that have moved (Wald, Boulos and Shirley, Ray tracing deformable scenes using
    /// dynamic bounding volume hierarchies, 2007). No box in the tree may be empty or have a NaN. The farther the boxes
    /// have moved apart, the slower the tree.
    pub(super) fn refit(&self, bounds: impl Fn(usize) -> Aabb + Sync) -> Self {
        let mut fitted = self.clone();
        fitted.nodes.par_iter_mut().for_each(|node| {
            for slot in 0..node.slots_used() {
                let child = node.children[slot];
                if child.is_leaf() {
                    let held = self.order[self.leaf_range(child)].iter();
                    let around = held.fold(Aabb::EMPTY, |around, &held| around.union(bounds(held as usize)));
                    node.set(slot, &around, child);
                }
            }
        });
        // Children come after their parents.
        for index in (0..fitted.nodes.len()).rev() {
            for slot in 0..fitted.nodes[index].slots_used() {
                let child = fitted.nodes[index].children[slot];
                if !child.is_leaf() {
                    let around = fitted.nodes[child.index()].all_bounds();
                    fitted.nodes[index].set(slot, &around, child);
                }
            }
        }
        fitted
    }

    /// The box around all primitives.
    pub fn bounds(&self) -> Aabb {
        self.nodes[0].all_bounds()
    }

    /// Calls `visit` for the box around all primitives and then for every child box, parents before children.
    pub fn visit_boxes(&self, mut visit: impl FnMut(BvhBox)) {
        let bounds = self.bounds();
        if bounds.is_empty() {
            return;
        }
        visit(BvhBox {
            bounds,
            depth: 0,
            is_leaf: false,
            primitives: 0,
        });
        let mut pending = vec![(0usize, 1usize)];
        while let Some((index, depth)) = pending.pop() {
            let node = &self.nodes[index];
            for slot in 0..node.slots_used() {
                let child = node.children[slot];
                visit(BvhBox {
                    bounds: node.bounds(slot),
                    depth,
                    is_leaf: child.is_leaf(),
                    primitives: if child.is_leaf() {
                        self.leaf_range(child).len() as u32
                    } else {
                        0
                    },
                });
                if !child.is_leaf() {
                    pending.push((child.index(), depth + 1));
                }
            }
        }
    }

    /// Whether `is_sought` is true for any primitive; boxes for which `touches` is false are skipped.
    pub(super) fn any_item(&self, touches: impl Fn(&Aabb) -> bool, mut is_sought: impl FnMut(u32) -> bool) -> bool {
        let mut pending = vec![0usize];
        while let Some(index) = pending.pop() {
            let node = &self.nodes[index];
            for slot in (0..node.slots_used()).filter(|&slot| touches(&node.bounds(slot))) {
                let child = node.children[slot];
                if !child.is_leaf() {
                    pending.push(child.index());
                    continue;
                }
                let held = self.order[self.leaf_range(child)].iter();
                if held.filter(|&&held| held != NO_PRIMITIVE).any(|&held| is_sought(held)) {
                    return true;
                }
            }
        }
        false
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.order.as_slice())
    }

    /// Computes the statistics in a walk over the whole hierarchy.
    pub fn stats(&self) -> BvhStats {
        let mut stats = BvhStats {
            nodes: self.nodes.len(),
            bytes: self.bytes(),
            ..BvhStats::default()
        };
        let mut pending = vec![(0usize, 1usize)];
        while let Some((index, depth)) = pending.pop() {
            let node = &self.nodes[index];
            stats.max_depth = stats.max_depth.max(depth);
            for child in &node.children[..node.slots_used()] {
                if child.is_leaf() {
                    stats.leaves += 1;
                } else {
                    pending.push((child.index(), depth + 1));
                }
            }
        }
        stats.sah_cost = self.expected_work(|_| 1.0) as f32;
        stats
    }

    /// The work that the surface area heuristic expects of a random ray that meets the root's box: the sum over all
    /// child boxes of (box area / root area), times 1 for a node, or times the sum of `of_primitive` for a leaf. Zero
    /// if the sum is not a number.
    pub fn expected_work(&self, of_primitive: impl Fn(u32) -> f64) -> f64 {
        let root_area = f64::from(self.bounds().half_area());
        let mut work = 0.0;
        for node in &self.nodes {
            for slot in 0..node.slots_used() {
                let share = f64::from(node.bounds(slot).half_area()) / root_area;
                let child = node.children[slot];
                let own = if child.is_leaf() {
                    self.order[self.leaf_range(child)]
                        .iter()
                        .copied()
                        .map(&of_primitive)
                        .sum()
                } else {
                    1.0
                };
                work += share * own;
            }
        }
        if work.is_finite() { work } else { 0.0 }
    }

    /// Checks the structure against the boxes it was built from: every box that can be hit is in exactly one leaf, each
    /// child is within its parent's box, there is no cycle, and the depth fits the traversal's stack.
    pub fn validate(&self, bounds: &[Aabb]) -> Result<(), String> {
        let mut seen = vec![false; bounds.len()];
        self.validate_structure(|primitive, leaf| {
            let seen = seen
                .get_mut(primitive as usize)
                .ok_or_else(|| format!("no primitive {primitive}"))?;
            if std::mem::replace(seen, true) {
                return Err(format!("primitive {primitive} is in two leaves"));
            }
            if !leaf.contains(&bounds[primitive as usize]) {
                return Err(format!("primitive {primitive} is not within its leaf's box"));
            }
            Ok(())
        })?;
        for (primitive, bounds) in bounds.iter().enumerate() {
            if seen[primitive] != is_hittable(bounds) {
                return Err(format!("primitive {primitive} is missing or should not be there"));
            }
        }
        Ok(())
    }

    /// [`Bvh::validate`] without the content of leaves, which `visit` checks: it gets each primitive with its leaf's
    /// box.
    pub(super) fn validate_structure(
        &self,
        mut visit: impl FnMut(u32, &Aabb) -> Result<(), String>,
    ) -> Result<(), String> {
        let everything = Aabb {
            min: glam::Vec3::NEG_INFINITY,
            max: glam::Vec3::INFINITY,
        };
        let mut held = 0;
        let mut reached = vec![false; self.nodes.len()];
        let mut pending = vec![(0usize, 1usize, everything)];
        while let Some((index, depth, parent)) = pending.pop() {
            let node = self.nodes.get(index).ok_or_else(|| format!("no node {index}"))?;
            if std::mem::replace(&mut reached[index], true) {
                return Err(format!("node {index} has two parents"));
            }
            if depth > self.depth || depth > MAX_DEPTH {
                return Err(format!("node {index} is too deep, at {depth}"));
            }
            let used = node.slots_used();
            for slot in used..WIDTH {
                let Aabb { min, max } = node.bounds(slot);
                if [min, max] != [Vec3::INFINITY; 2] || node.children[slot] != Child::NONE {
                    return Err(format!("node {index}: empty slot {slot} is not empty"));
                }
            }
            for slot in 0..used {
                let bounds_here = node.bounds(slot);
                if !parent.contains(&bounds_here) {
                    return Err(format!("node {index}: child {slot} is not within its parent's box"));
                }
                let child = node.children[slot];
                if !child.is_leaf() {
                    pending.push((child.index(), depth + 1, bounds_here));
                    continue;
                }
                let leaf = self.order.get(self.leaf_range(child));
                for &primitive in leaf.ok_or_else(|| format!("node {index}: leaf {slot} is out of range"))? {
                    visit(primitive, &bounds_here)?;
                    held += 1;
                }
            }
        }
        // Edits leave empty nodes behind.
        let is_lost = |index: &usize| !reached[*index] && self.nodes[*index].slots_used() > 0;
        if let Some(index) = (0..self.nodes.len()).find(is_lost) {
            return Err(format!("node {index} is not reached"));
        }
        if self.listed() != held {
            return Err("the order lists primitives that no leaf holds".into());
        }
        Ok(())
    }
}

/// Whether the box is neither empty nor NaN. This does not share the build's test, which it checks.
fn is_hittable(bounds: &Aabb) -> bool {
    bounds.min.cmple(bounds.max).all()
}
