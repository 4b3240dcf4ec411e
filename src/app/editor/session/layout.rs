//! The arrangement of the docked panels. The window paints them.

use bevy::prelude::Resource;
use bevy_egui::egui::{Pos2, Rect, Vec2, vec2};
use egui_dock::{DockState, Node, NodeIndex, NodePath, Split, Surface, SurfaceIndex, Tree};
use serde::Deserialize as _;

use super::panel_sizes::{WantedSizes, assume_shown};
use crate::app::editor::command::panel::{Panel, Side};
use crate::app::editor::command::preferences::Preferences;

/// The size in points that the shares below refer to.
const USUAL_ROOM: Vec2 = vec2(1280.0, 674.0);
/// The share of the window's width, and below that of the rest of it.
const LEFT_SHARE: f32 = 0.17;
const RIGHT_SHARE: f32 = 0.32;

/// The docked panels: a tree of splits with groups of panels at its leaves.
#[derive(Resource, Clone)]
pub struct Layout(pub DockState<Panel>, WantedSizes);

impl Default for Layout {
    fn default() -> Self {
        let mut layout = Self(DockState::new(vec![Panel::Viewport]), WantedSizes::default());
        let usual = Panel::on(Side::Right).chain(Panel::on(Side::Left));
        for panel in usual.filter(|panel| panel.is_open()) {
            layout.show(panel);
        }
        layout.show(Panel::Outliner);
        layout.show(Panel::Inspector);
        layout.shown_in(USUAL_ROOM)
    }
}

impl Layout {
    /// The layout stored in the preferences.
    pub fn remembered(preferences: &Preferences) -> Self {
        Self::from_json(&preferences.layout).unwrap_or_default()
    }

    /// Fits the panels to the room for all panels, in points. To be called before they are shown.
    pub fn fit(&mut self, room: Vec2) {
        self.1.fit(self.0.main_surface_mut(), room);
    }

    /// The layout as if it had been shown in this room.
    pub(super) fn shown_in(mut self, room: Vec2) -> Self {
        assume_shown(self.0.main_surface_mut(), room);
        self
    }

    /// Whether the panel is open, in front or not.
    pub fn has(&self, panel: Panel) -> bool {
        self.0.find_tab(&panel).is_some()
    }

    /// The panels in front of their groups.
    pub fn fronts(&self) -> Vec<Panel> {
        let leaves = self.0.iter_leaves();
        leaves
            .filter_map(|(_, leaf)| leaf.tabs.get(leaf.active.0).copied())
            .collect()
    }

    /// Shows a panel in front of its group, or in its usual place if it was closed.
    pub fn show(&mut self, panel: Panel) {
        if !self.bring_to_front(panel) {
            let mut neighbours = Panel::on(panel.side());
            let group = neighbours.find_map(|neighbour| self.0.find_tab(&neighbour));
            match group.and_then(|place| self.0.leaf_mut(place.node_path()).ok()) {
                Some(leaf) => leaf.tabs.push(panel),
                None => {
                    // The share is that of what is left of the split.
                    let (side, share) = match panel.side() {
                        Side::Right => (Split::Right, 1.0 - RIGHT_SHARE),
                        Side::Left => (Split::Left, LEFT_SHARE),
                    };
                    let root = NodeIndex::root();
                    let tree = self.0.main_surface_mut();
                    tree.split(root, side, share, Node::leaf(panel));
                }
            }
            self.bring_to_front(panel);
        }
    }

    /// Brings a panel to the front of its group; returns false if it is closed.
    pub(crate) fn bring_to_front(&mut self, panel: Panel) -> bool {
        let place = self.0.find_tab(&panel);
        place.is_some_and(|place| self.0.set_active_tab(place).is_ok())
    }

    /// Closes the panel, except the viewport.
    pub fn close(&mut self, panel: Panel) {
        if let Some(place) = self.0.find_tab(&panel).filter(|_| panel != Panel::Viewport) {
            self.0.remove_tab(place);
        }
    }

    /// The layout for the preferences: the places of panels and their shares, without coordinates in points.
    pub fn to_json(&self) -> serde_json::Value {
        let mut state = self.0.clone();
        for (_, node) in state.iter_all_nodes_mut() {
            let shown = node.rect().filter(|rect| node.is_parent() && rect.is_finite());
            let size = shown.map_or(Vec2::ZERO, |rect| rect.size().round());
            node.set_rect(Rect::from_min_size(Pos2::ZERO, size));
            if let Some(leaf) = node.get_leaf_mut() {
                leaf.viewport = Rect::ZERO;
                leaf.scroll = 0.0;
            }
        }
        // Plain data always is JSON. Otherwise nothing is stored.
        serde_json::to_value(&state).unwrap_or_default()
    }

    /// Parses a layout. None if it is none, or one that cannot be shown.
    pub fn from_json(value: &serde_json::Value) -> Option<Self> {
        let mut layout = Self(DockState::deserialize(value).ok()?, WantedSizes::default());
        layout.drop_unsound_focus();
        // Numbers beyond single precision become infinite, which cannot be written again.
        let can_be_kept = || DockState::<Panel>::deserialize(layout.to_json()).is_ok();
        (layout.is_sound() && can_be_kept()).then_some(layout)
    }

    /// Removes a focus on a node that does not exist, and the focus of the window, which does not apply to another run.
    fn drop_unsound_focus(&mut self) {
        const NOWHERE: NodeIndex = NodeIndex(usize::MAX);
        for tree in self.0.iter_surfaces_mut().filter_map(Surface::node_tree_mut) {
            tree.set_focused_node(tree.focused_leaf().unwrap_or(NOWHERE));
        }
        let surface = SurfaceIndex(usize::MAX);
        self.0.set_focused_node_and_surface(NodePath { surface, node: NOWHERE });
    }

    /// Whether each panel is there at most once, the viewport is docked, every split has two sides, all other nodes are
    /// below a split, and every surface has panels.
    fn is_sound(&self) -> bool {
        let mut surfaces = self.0.iter_surfaces();
        let is_main = matches!(surfaces.next(), Some(Surface::Main(_)));
        let others_float = surfaces.all(|surface| !matches!(surface, Surface::Main(_)));
        let panels: Vec<Panel> = self.0.iter_all_tabs().map(|(_, panel)| *panel).collect();
        let is_once = |panel: &Panel| panels.iter().filter(|other| *other == panel).count() == 1;
        let trees = self.0.iter_surfaces().filter_map(Surface::node_tree);
        let has_panels = |tree: &Tree<Panel>| tree.iter().any(Node::is_leaf);
        let splits = |nodes: &[&Node<Panel>]| {
            let is_child = |place: usize| place == 0 || nodes[(place - 1) / 2].is_parent();
            nodes.iter().enumerate().all(|(place, node)| match node {
                Node::Empty => true,
                _ if !is_child(place) => false,
                Node::Horizontal(split) | Node::Vertical(split) => {
                    let sides = [2 * place + 1, 2 * place + 2];
                    let has_both = sides
                        .iter()
                        .all(|side| nodes.get(*side).is_some_and(|node| !node.is_empty()));
                    has_both && (0.0..=1.0).contains(&split.fraction)
                }
                Node::Leaf(leaf) => leaf.active.0 < leaf.tabs.len(),
            })
        };
        is_main
            && others_float
            && panels.iter().all(is_once)
            && self.0.find_main_surface_tab(&Panel::Viewport).is_some()
            && trees
                .into_iter()
                .all(|tree| has_panels(tree) && splits(&tree.iter().collect::<Vec<_>>()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn titles(layout: &Layout) -> Vec<&'static str> {
        layout.0.iter_all_tabs().map(|(_, panel)| panel.title()).collect()
    }

    #[test]
    fn what_is_closed_comes_back_and_the_viewport_stays() {
        let mut layout = Layout::default();
        for &panel in Panel::CLOSEABLE {
            layout.close(panel);
            assert!(!layout.has(panel), "{panel:?}");
        }
        layout.close(Panel::Viewport);
        assert_eq!(titles(&layout), ["Viewport"]);
        for &panel in Panel::CLOSEABLE {
            layout.show(panel);
            layout.show(panel);
        }
        assert_eq!(
            titles(&layout).len(),
            1 + Panel::CLOSEABLE.len(),
            "{:?}",
            titles(&layout)
        );
    }

    #[test]
    fn a_layout_is_remembered() {
        let mut layout = Layout::default();
        layout.close(Panel::Render);
        let back = Layout::from_json(&layout.to_json()).expect("it was just written");
        assert_eq!(titles(&back), titles(&layout));
        assert_eq!(back.to_json(), layout.to_json());
    }

    #[test]
    fn what_could_not_be_shown_is_refused() {
        let good = Layout::default().to_json().to_string();
        let with = |from: &str, to: &str| {
            let changed = good.replacen(from, to, 1);
            assert_ne!(changed, good, "{from} is not in {good}");
            Layout::from_json(&serde_json::from_str(&changed).expect("still JSON"))
        };
        assert!(with("\"render\"", "\"inspector\"").is_none());
        assert!(with("\"render\"", "\"of another version\"").is_none());
        assert!(with("\"viewport\"]", "\"render\"]").is_none());
        assert!(with("\"fraction\":0.", "\"fraction\":7.").is_none());
        assert!(with("\"Horizontal\"", "\"Vertical\"").is_some());
        let focus_on_nothing = with("\"focused_surface\":null", "\"focused_surface\":9");
        assert_eq!(focus_on_nothing.and_then(|layout| layout.0.focused_leaf()), None);
        assert!(Layout::from_json(&serde_json::Value::Null).is_none());
    }
}
