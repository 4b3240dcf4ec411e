//! Edits of single primitives in a hierarchy: leaves are removed or refitted, and a second hierarchy is put beside the
//! first.

use super::build::MAX_DEPTH;
use super::bvh::Bvh;
use super::collapse::NO_PRIMITIVE;
use super::node::{Child, Node};
use crate::math::Aabb;

/// The edit of a leaf's primitive.
pub(super) enum LeafEdit {
    /// It gets this number and keeps its bounds.
    Keep(u32),
    /// It gets this number and these bounds.
    Fit(u32, Aabb),
    Remove,
}

impl Bvh {
    /// This hierarchy below a new root, which has a slot for a second one; see [`Self::put_beside`].
    pub(super) fn under_root(&self) -> Self {
        let mut nodes = Vec::with_capacity(self.nodes.len() + 1);
        nodes.push(Node::EMPTY);
        nodes.extend(self.nodes.iter().map(|node| {
            let mut moved = *node;
            moved.advance(1, 0);
            moved
        }));
        Self {
            nodes,
            order: self.order.clone(),
            depth: self.depth + 1,
            ..*self
        }
    }

    /// The hierarchy without the one that [`Self::put_beside`] added. `nodes` and `leaves` are the numbers of nodes and
    /// of entries of the leaf order before that.
    pub(super) fn without_beside(&self, nodes: usize, leaves: usize) -> Self {
        Self {
            nodes: self.nodes[..nodes].to_vec(),
            order: self.order[..leaves].to_vec(),
            ..*self
        }
    }

    /// Calls `edit` for the primitive of each leaf of a hierarchy made by [`Self::under_root`] and refits the boxes.
    /// Leaves must be of one primitive.
    pub(super) fn edit_leaves(&mut self, edit: impl Fn(u32) -> LeafEdit) {
        let mut is_changed = vec![false; self.nodes.len()];
        // Children come after their parents.
        for index in (1..self.nodes.len()).rev() {
            let mut node = self.nodes[index];
            let used = node.slots_used();
            let mut kept = 0;
            for slot in 0..used {
                let child = node.children[slot];
                let fitted = if child.is_leaf() {
                    let held = &mut self.order[child.index() * self.leaf_size];
                    match edit(*held) {
                        LeafEdit::Keep(number) => {
                            *held = number;
                            None
                        }
                        LeafEdit::Fit(number, bounds) => {
                            *held = number;
                            Some(bounds)
                        }
                        LeafEdit::Remove => {
                            *held = NO_PRIMITIVE;
                            Some(Aabb::EMPTY)
                        }
                    }
                } else {
                    is_changed[child.index()].then(|| self.nodes[child.index()].all_bounds())
                };
                is_changed[index] |= fitted.is_some();
                if fitted.is_some_and(|bounds| bounds.is_empty()) {
                    continue;
                }
                if fitted.is_some() || kept < slot {
                    let bounds = fitted.unwrap_or_else(|| node.bounds(slot));
                    node.set(kept, &bounds, child);
                }
                kept += 1;
            }
            if is_changed[index] {
                (kept..used).for_each(|slot| node.clear(slot));
                self.nodes[index] = node;
            }
        }
    }

    /// Puts `other` beside a hierarchy made by [`Self::under_root`]. False, without a change, if it would be too deep.
    pub(super) fn put_beside(&mut self, other: &Self) -> bool {
        let depth = self.depth.max(other.depth + 1);
        if depth > MAX_DEPTH {
            return false;
        }
        let (nodes, leaves) = (self.nodes.len(), self.order.len() / self.leaf_size);
        let mut root = Node::EMPTY;
        let mut slot = 0;
        for (bounds, child) in [(self.nodes[1].all_bounds(), 1), (other.bounds(), nodes)] {
            if !bounds.is_empty() {
                root.set(slot, &bounds, Child::node(child));
                slot += 1;
            }
        }
        self.nodes[0] = root;
        self.depth = depth;
        if other.bounds().is_empty() {
            return true;
        }
        self.nodes.extend(other.nodes.iter().map(|node| {
            let mut moved = *node;
            moved.advance(nodes, leaves);
            moved
        }));
        self.order.extend_from_slice(&other.order);
        true
    }
}
