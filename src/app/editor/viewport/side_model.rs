//! The data that a side view shows, and the view that has the mouse.

use bevy::math::Affine3A;

use crate::app::editor::picture::outline::SelectionOutline;
pub use crate::app::editor::picture::side_pictures::COUNT;
use crate::app::editor::picture::side_pictures::SidePicture;
use crate::engine::PackedScene;

/// The data that a side view shows.
#[derive(Clone, Copy, Debug)]
pub struct SideModel<'a> {
    /// The packed scene with the view of this side, for picking.
    pub packed: &'a PackedScene,
    /// World from camera, with half the width of the picture as its scale.
    pub pose: Affine3A,
    /// The last picture.
    pub picture: Option<&'a SidePicture>,
    /// The outlines of selected things and of the hovered one.
    pub outline: &'a SelectionOutline,
}

/// The view that has the mouse.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PaneState {
    /// The side view that has the mouse; None for the main view.
    pub active: Option<usize>,
    /// Whether a button was down at the end of the last frame: it belongs to the active view.
    pub(super) is_held: bool,
}
