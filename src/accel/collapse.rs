//! From a binary tree to wide nodes.
//!
//! Of all ways to merge a binary tree's inner nodes into nodes of eight children this takes the one whose nodes have the least surface in
//! all, found from the leaves up by dynamic programming (Ylitie, Karras and Laine, Efficient incoherent ray traversal on GPUs through
//! compressed wide BVHs, 2017, section 3.3). Leaves stay as they are.

use arrayvec::ArrayVec;

use super::build::{NO_PRIMITIVE, Tree};
use super::node::{Child, Node, WIDTH};
use super::sets::{Bounds, Reference, Set};

/// A node of the binary tree. The tree is a list in which a node's left child follows it.
pub(super) struct Branch {
    bounds: Bounds,
    /// The index of the right child; zero for a leaf.
    pub right: u32,
    /// The references of a leaf.
    start: u32,
    len: u32,
    /// The surface of the wide nodes that this takes if it gets up to 1, 2, ... slots of a wide node above.
    cost: [f32; WIDTH],
    /// How many of as many slots go to the left child then; zero where it is best to take one slot for a wide node here.
    left_slots: [u8; WIDTH],
    /// Of that wide node's slots, how many go to the left child.
    left_inside: u8,
}

impl Branch {
    /// Also a place for what will be an inner node.
    pub fn leaf(set: &Set) -> Self {
        Self {
            bounds: set.bounds,
            right: 0,
            start: set.start as u32,
            len: set.len as u32,
            cost: [0.0; WIDTH],
            left_slots: [0; WIDTH],
            left_inside: 0,
        }
    }

    /// The node over two that are finished; `scale` makes areas independent of the scene's unit.
    pub fn inner(set: &Set, left: &Self, right: &Self, right_index: usize, scale: f32) -> Self {
        let mut divided = [f32::INFINITY; WIDTH];
        let mut left_slots = [0; WIDTH];
        for slots in 2..=WIDTH {
            left_slots[slots - 1] = 1;
            for of_left in 1..slots {
                let cost = left.cost[of_left - 1] + right.cost[slots - of_left - 1];
                if cost < divided[slots - 1] {
                    divided[slots - 1] = cost;
                    left_slots[slots - 1] = of_left as u8;
                }
            }
        }
        let left_inside = left_slots[WIDTH - 1];
        let own = set.bounds.half_area(scale) + divided[WIDTH - 1];
        for (cost, left) in divided.iter_mut().zip(&mut left_slots) {
            if *cost > own {
                (*cost, *left) = (own, 0);
            }
        }
        // One slot holds one node.
        (divided[0], left_slots[0]) = (own, 0);
        Self {
            right: right_index as u32,
            cost: divided,
            left_slots,
            left_inside,
            ..Self::leaf(set)
        }
    }
}

/// Wide nodes over `branches`, whose leaves hold runs of `references`. The children of a node lie side by side, its leaves too.
pub(super) fn collapse(branches: &[Branch], references: &[Reference], leaf_size: usize) -> Tree {
    let mut collapse = Collapse {
        branches,
        references,
        leaf_size,
        tree: Tree {
            nodes: vec![Node::EMPTY],
            order: Vec::with_capacity(references.len() + references.len() / 4),
            depth: 1,
        },
    };
    if !branches.is_empty() {
        collapse.fill(0, 0, 1);
    }
    collapse.tree
}

struct Collapse<'a> {
    branches: &'a [Branch],
    references: &'a [Reference],
    leaf_size: usize,
    tree: Tree,
}

impl Collapse<'_> {
    /// Gives the wide node `node`, which is at `depth`, the children that branch `index` has for it.
    fn fill(&mut self, node: usize, index: usize, depth: usize) {
        self.tree.depth = self.tree.depth.max(depth);
        let branch = &self.branches[index];
        let mut children = ArrayVec::<usize, WIDTH>::new();
        if branch.right == 0 {
            children.push(index);
        } else {
            let of_left = branch.left_inside as usize;
            self.gather(index + 1, of_left, &mut children);
            self.gather(branch.right as usize, WIDTH - of_left, &mut children);
        }
        let first = self.tree.nodes.len();
        let mut next = first;
        for (slot, &child) in children.iter().enumerate() {
            let branch = &self.branches[child];
            let content = if branch.right == 0 {
                self.push_leaf(branch)
            } else {
                next += 1;
                Child::node(next - 1)
            };
            self.tree.nodes[node].set(slot, &branch.bounds.to_aabb(), content);
        }
        self.tree.nodes.resize(next, Node::EMPTY);
        let inner = children.iter().filter(|&&child| self.branches[child].right != 0);
        for (node, &child) in (first..).zip(inner) {
            self.fill(node, child, depth + 1);
        }
    }

    /// The branches that fill up to `slots` slots for branch `index`.
    fn gather(&self, index: usize, slots: usize, children: &mut ArrayVec<usize, WIDTH>) {
        let branch = &self.branches[index];
        match branch.left_slots[slots - 1] as usize {
            0 => children.push(index),
            of_left => {
                self.gather(index + 1, of_left, children);
                self.gather(branch.right as usize, slots - of_left, children);
            }
        }
    }

    fn push_leaf(&mut self, leaf: &Branch) -> Child {
        let order = &mut self.tree.order;
        let block = order.len() / self.leaf_size;
        let references = &self.references[leaf.start as usize..(leaf.start + leaf.len) as usize];
        order.extend(references.iter().map(|reference| reference.index));
        order.resize(order.len().next_multiple_of(self.leaf_size), NO_PRIMITIVE);
        // A linear list says how long it is itself.
        Child::leaf(block, references.len().min(self.leaf_size))
    }
}
