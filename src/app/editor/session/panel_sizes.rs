//! The sizes of the docked panels: beside the viewport they keep their width (or height) in points when the window is
//! resized, and the viewport takes the rest. Their places are in `layout`.

use std::collections::HashMap;

use bevy_egui::egui::{Rect, Vec2};
use egui_dock::{Node, NodeIndex, Tree};

use crate::app::editor::command::panel::Panel;

/// The largest share of a split that the side without the viewport keeps when there is little room.
const LARGEST_SHARE: f32 = 0.45;
/// The largest change in points that counts as rounding to pixels, and not as resizing.
const TOLERANCE: f32 = 1.5;

/// The sizes in points that the panels beside the viewport would have if there were room. The key is the node of the
/// split that divides a panel from the viewport.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WantedSizes(HashMap<NodeIndex, f32>);

impl WantedSizes {
    /// Fits the sizes to the room for all panels, in points. To be called before they are shown.
    pub fn fit(&mut self, tree: &mut Tree<Panel>, room: Vec2) {
        let Some(before) = size_of(tree, NodeIndex::root()) else {
            return;
        };
        self.note(tree);
        if (before - room).abs().max_elem() > TOLERANCE {
            resize(tree, NodeIndex::root(), room, self);
        }
    }

    /// Stores sizes that differ from the ones set here: the user has changed them.
    fn note(&mut self, tree: &Tree<Panel>) {
        let mut sizes = HashMap::new();
        for node in (0..tree.len()).map(NodeIndex) {
            let Some(side) = Side::of(tree, node) else {
                continue;
            };
            let known = self.0.get(&node).copied();
            let is_as_made = |wanted: f32| (wanted.min(side.most()) - side.size).abs() <= TOLERANCE;
            sizes.insert(node, known.filter(|wanted| is_as_made(*wanted)).unwrap_or(side.size));
        }
        self.0 = sizes;
    }
}

/// The side of a split without the viewport.
struct Side {
    is_first: bool,
    size: f32,
    /// The size of both sides together.
    whole: f32,
}

impl Side {
    /// The sides of a split; None if there is no such split, or the viewport is in neither side.
    fn of(tree: &Tree<Panel>, node: NodeIndex) -> Option<Self> {
        let whole = size_of(tree, node)?[axis_of(tree, node)];
        let (Node::Horizontal(split) | Node::Vertical(split)) = &tree[node] else {
            return None;
        };
        let is_first = match [node.left(), node.right()].map(|side| holds_viewport(tree, side)) {
            [false, true] => true,
            [true, false] => false,
            _ => return None,
        };
        let share = if is_first { split.fraction } else { 1.0 - split.fraction };
        Some(Self {
            is_first,
            size: share * whole,
            whole,
        })
    }

    fn most(&self) -> f32 {
        LARGEST_SHARE * self.whole
    }
}

/// The size of a node; None for a leaf, and before it has been shown.
fn size_of(tree: &Tree<Panel>, node: NodeIndex) -> Option<Vec2> {
    let size = match &tree[node] {
        Node::Horizontal(split) | Node::Vertical(split) => split.rect.size(),
        Node::Leaf(_) | Node::Empty => return None,
    };
    (size.is_finite() && size.min_elem() >= 1.0).then_some(size)
}

/// The axis of a split: x for one into left and right, y for one into top and bottom.
fn axis_of(tree: &Tree<Panel>, node: NodeIndex) -> usize {
    usize::from(matches!(tree[node], Node::Vertical(_)))
}

fn resize(tree: &mut Tree<Panel>, node: NodeIndex, to: Vec2, wanted: &WantedSizes) {
    let Some(before) = size_of(tree, node) else {
        return;
    };
    let axis = axis_of(tree, node);
    let side = Side::of(tree, node);
    let (Node::Horizontal(split) | Node::Vertical(split)) = &mut tree[node] else {
        return;
    };
    let (share_before, room) = (split.fraction, to[axis].max(1.0));
    if let Some(side) = side {
        let size = wanted.0.get(&node).copied().unwrap_or(side.size);
        let share = (size / room).min(LARGEST_SHARE);
        split.fraction = if side.is_first { share } else { 1.0 - share };
    }
    split.rect = Rect::from_min_size(split.rect.min, to);
    for (side, was, is) in [
        (node.left(), share_before, split.fraction),
        (node.right(), 1.0 - share_before, 1.0 - split.fraction),
    ] {
        if let Some(mut size) = size_of(tree, side) {
            // The space between the two stays.
            size[axis] += is * to[axis] - was * before[axis];
            size[1 - axis] += to[1 - axis] - before[1 - axis];
            resize(tree, side, size.max(Vec2::splat(1.0)), wanted);
        }
    }
}

fn assume(tree: &mut Tree<Panel>, node: NodeIndex, size: Vec2) {
    let axis = axis_of(tree, node);
    let (Node::Horizontal(split) | Node::Vertical(split)) = &mut tree[node] else {
        return;
    };
    split.rect = Rect::from_min_size(Default::default(), size);
    for (side, share) in [(node.left(), split.fraction), (node.right(), 1.0 - split.fraction)] {
        let mut part = size;
        part[axis] *= share;
        assume(tree, side, part);
    }
}

fn holds_viewport(tree: &Tree<Panel>, node: NodeIndex) -> bool {
    match &tree[node] {
        Node::Leaf(leaf) => leaf.tabs.contains(&Panel::Viewport),
        Node::Empty => false,
        Node::Horizontal(_) | Node::Vertical(_) => [node.left(), node.right()]
            .into_iter()
            .any(|side| holds_viewport(tree, side)),
    }
}

/// Notes the sizes as if the tree had been shown in this room.
pub(crate) fn assume_shown(tree: &mut Tree<Panel>, room: Vec2) {
    assume(tree, NodeIndex::root(), room);
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui::vec2;

    use super::super::layout::Layout;
    use super::*;

    /// The widths of the outliner, the viewport and the inspector, in points.
    fn widths(layout: &Layout, room: f32) -> [f32; 3] {
        let tree = layout.0.main_surface();
        let share = |node| match &tree[node] {
            Node::Horizontal(split) => split.fraction,
            other => panic!("{other:?}"),
        };
        // The outliner was docked left of everything else, later.
        let root = NodeIndex::root();
        let outliner = share(root) * room;
        let rest = room - outliner;
        let viewport = share(root.right()) * rest;
        [outliner, viewport, rest - viewport]
    }

    #[test]
    fn what_is_beside_the_viewport_keeps_its_width() {
        let mut layout = Layout::default().shown_in(vec2(1280.0, 680.0));
        let [left, viewport, right] = widths(&layout, 1280.0);
        for (width, height) in [(1900.0, 900.0), (1000.0, 400.0), (1280.0, 680.0)] {
            layout.fit(vec2(width, height));
            let [now_left, now_viewport, now_right] = widths(&layout, width);
            assert!(
                (now_left - left).abs() < 0.1 && (now_right - right).abs() < 0.1,
                "{width}"
            );
            assert!((now_viewport - viewport - (width - 1280.0)).abs() < 0.1);
        }
    }

    #[test]
    fn in_a_small_window_all_is_there_and_in_a_large_one_again_as_it_was() {
        let mut layout = Layout::default().shown_in(vec2(1280.0, 680.0));
        let before = widths(&layout, 1280.0);
        for width in [640.0, 400.0] {
            layout.fit(vec2(width, 300.0));
            let all = widths(&layout, width);
            assert!(all.into_iter().all(|width| width > 90.0), "{all:?}");
        }
        layout.fit(vec2(1280.0, 680.0));
        let after = widths(&layout, 1280.0);
        let is_close = |(before, after): (f32, f32)| (before - after).abs() < 0.1;
        assert!(before.into_iter().zip(after).all(is_close), "{before:?} {after:?}");
    }

    #[test]
    fn what_the_user_makes_of_a_split_is_kept() {
        let mut layout = Layout::default().shown_in(vec2(1280.0, 680.0));
        layout.fit(vec2(1000.0, 680.0));
        if let Node::Horizontal(split) = &mut layout.0.main_surface_mut()[NodeIndex::root()] {
            split.fraction = 0.1;
        }
        layout.fit(vec2(1000.0, 680.0));
        layout.fit(vec2(2000.0, 680.0));
        let [left, ..] = widths(&layout, 2000.0);
        assert!((left - 100.0).abs() < 0.1, "{left}");
    }

    #[test]
    fn one_that_was_never_shown_keeps_its_shares() {
        let mut layout = Layout::default();
        for (_, node) in layout.0.iter_all_nodes_mut() {
            node.set_rect(Rect::ZERO);
        }
        let before = widths(&layout, 1.0);
        layout.fit(vec2(3000.0, 900.0));
        assert_eq!(widths(&layout, 1.0), before);
    }
}
