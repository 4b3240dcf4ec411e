//! Turns a binary tree into one of wide nodes.
//!
//! A binary tree's inner nodes can be merged into nodes of eight children in many ways. This picks the one with the
//! least total surface of nodes, found from the leaves up by dynamic programming (Ylitie, Karras and Laine, Efficient
//! incoherent ray traversal on GPUs through compressed wide BVHs, 2017, section 3.3). Leaves stay as they are.

use std::ops::Range;

use arrayvec::ArrayVec;
use rayon::prelude::*;

use super::build_prim::PrimSet;
use super::node::{Child, Node, WIDTH};
use crate::math::Aabb;

/// The wide tree: nodes, the first of which is the root, and the primitives in the order of the leaves.
pub(super) struct Tree {
    pub nodes: Vec<Node>,
    pub order: Vec<u32>,
    /// The number of levels of nodes.
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

/// The index in the unused places of a leaf.
pub(super) const NO_PRIMITIVE: u32 = u32::MAX;

/// The binary tree before it is made wide.
#[derive(Default)]
pub(super) struct BinaryTree {
    /// The nodes. Each inner node is followed by its left child.
    pub branches: Vec<Branch>,
    /// The primitives in leaf order.
    pub order: Vec<u32>,
}

impl BinaryTree {
    /// Appends a tree whose indices count from its own start.
    pub fn append(&mut self, tree: Self) {
        let (branches, order) = (self.branches.len(), self.order.len());
        self.branches.extend(tree.branches.into_iter().map(|mut branch| {
            branch.advance(branches, order);
            branch
        }));
        self.order.extend(tree.order);
    }
}

/// A node of the binary tree.
pub(super) struct Branch {
    bounds: Aabb,
    kind: BranchKind,
}

#[derive(Clone, Copy)]
enum BranchKind {
    /// A run of [`BinaryTree::order`].
    Leaf { start: u32, len: u32 },
    Inner {
        /// The index of the right child.
        right: u32,
        /// The number of slots that go to the left child if this branch gets two, three, ... slots of a wide node
        /// above. Zero if a wide node of its own is better, which takes one slot. Such a node has all slots to
        /// give, so the last number is never zero.
        left_slots: [u8; WIDTH - 1],
    },
}

/// The surface of the wide nodes that a branch takes if it gets up to 1, 2, ... slots of a wide node above.
pub(super) type Costs = [f32; WIDTH];

impl Branch {
    /// A leaf that starts at `start` in the order. [`Self::set_children`] may make it an inner node later.
    pub fn leaf(set: &PrimSet, start: usize) -> (Self, Costs) {
        let kind = BranchKind::Leaf {
            start: start as u32,
            len: set.len as u32,
        };
        let bounds = set.bounds.to_aabb();
        (Self { bounds, kind }, [0.0; WIDTH])
    }

    /// Makes this the inner node over two children with known costs. `own_area` is the half area of its box.
    pub fn set_children(&mut self, [left, right]: [Costs; 2], right_index: usize, own_area: f32) -> Costs {
        let mut costs = [f32::INFINITY; WIDTH];
        let mut left_slots = [1; WIDTH];
        for slots in 2..=WIDTH {
            for of_left in 1..slots {
                let cost = left[of_left - 1] + right[slots - of_left - 1];
                if cost < costs[slots - 1] {
                    costs[slots - 1] = cost;
                    left_slots[slots - 1] = of_left as u8;
                }
            }
        }
        let own = own_area + costs[WIDTH - 1];
        for (cost, left) in costs.iter_mut().zip(&mut left_slots).take(WIDTH - 1).skip(1) {
            if *cost > own {
                (*cost, *left) = (own, 0);
            }
        }
        costs[0] = own;
        let [_, left_slots @ ..] = left_slots;
        let right = right_index as u32;
        self.kind = BranchKind::Inner { right, left_slots };
        costs
    }

    /// Adds to the indices the lengths of the lists that this branch is appended to.
    fn advance(&mut self, branches: usize, order: usize) {
        match &mut self.kind {
            BranchKind::Inner { right, .. } => *right += branches as u32,
            BranchKind::Leaf { start, .. } => *start += order as u32,
        }
    }
}

/// The wide tree made from `binary`. The children of a node are adjacent, and so are its leaves.
pub(super) fn collapse(binary: &BinaryTree, leaf_size: usize) -> Tree {
    let collapse = Collapse { binary, leaf_size };
    let mut tree = Tree::childless();
    if !binary.branches.is_empty() {
        collapse.fill(&mut tree, 0, 0..binary.branches.len(), 1);
    }
    tree
}

/// Ranges of at least this many branches are split among threads.
const PARALLEL: usize = 2048;

struct Collapse<'a> {
    binary: &'a BinaryTree,
    leaf_size: usize,
}

impl Collapse<'_> {
    /// Fills the wide node `node` at `depth` with the children below the first of `branches`, and appends all nodes
    /// below them. `branches` is the range of the whole subtree.
    fn fill(&self, tree: &mut Tree, node: usize, branches: Range<usize>, depth: usize) {
        tree.depth = tree.depth.max(depth);
        let mut children = ArrayVec::<usize, WIDTH>::new();
        self.gather(branches.start, WIDTH, &mut children);
        let first = tree.nodes.len();
        let mut inner = ArrayVec::<Range<usize>, WIDTH>::new();
        for (slot, &child) in children.iter().enumerate() {
            let branch = &self.binary.branches[child];
            let content = match branch.kind {
                BranchKind::Leaf { start, len } => self.push_leaf(tree, start as usize, len as usize),
                BranchKind::Inner { .. } => {
                    inner.push(child..children.get(slot + 1).copied().unwrap_or(branches.end));
                    Child::node(first + inner.len() - 1)
                }
            };
            tree.nodes[node].set(slot, &branch.bounds, content);
        }
        tree.nodes.resize(first + inner.len(), Node::EMPTY);
        if branches.len() < PARALLEL {
            for (node, branches) in (first..).zip(inner) {
                self.fill(tree, node, branches, depth + 1);
            }
        } else {
            let subtree = |branches: &Range<usize>| {
                let mut tree = Tree::childless();
                self.fill(&mut tree, 0, branches.clone(), depth + 1);
                tree
            };
            let subtrees: Vec<Tree> = inner.par_iter().map(subtree).collect();
            let total = |of: fn(&Tree) -> usize| subtrees.iter().map(of).sum();
            tree.nodes.reserve_exact(total(|subtree| subtree.nodes.len()));
            tree.order.reserve_exact(total(|subtree| subtree.order.len()));
            for (node, subtree) in (first..).zip(subtrees) {
                self.graft(tree, node, &subtree);
            }
        }
    }

    /// Puts the root of `subtree` at `node` and appends the rest.
    fn graft(&self, tree: &mut Tree, node: usize, subtree: &Tree) {
        let (nodes, blocks) = (tree.nodes.len() - 1, tree.order.len() / self.leaf_size);
        tree.nodes.extend_from_slice(&subtree.nodes[1..]);
        tree.nodes[node] = subtree.nodes[0];
        tree.nodes[node].advance(nodes, blocks);
        tree.nodes[nodes + 1..]
            .iter_mut()
            .for_each(|node| node.advance(nodes, blocks));
        tree.order.extend_from_slice(&subtree.order);
        tree.depth = tree.depth.max(subtree.depth);
    }

    /// Collects the branches that take up to `slots` slots of a wide node in place of branch `index`.
    fn gather(&self, index: usize, slots: usize, children: &mut ArrayVec<usize, WIDTH>) {
        match self.binary.branches[index].kind {
            BranchKind::Inner { right, left_slots } if slots > 1 && left_slots[slots - 2] > 0 => {
                let of_left = left_slots[slots - 2] as usize;
                self.gather(index + 1, of_left, children);
                self.gather(right as usize, slots - of_left, children);
            }
            _ => children.push(index),
        }
    }

    fn push_leaf(&self, tree: &mut Tree, start: usize, len: usize) -> Child {
        let order = &mut tree.order;
        let block = order.len() / self.leaf_size;
        order.extend_from_slice(&self.binary.order[start..start + len]);
        order.resize(order.len().next_multiple_of(self.leaf_size), NO_PRIMITIVE);
        // A linear list has its length in `Bvh::linear`.
        Child::leaf(block, len.min(self.leaf_size))
    }
}
