//! The snapping of moves.

use serde::{Deserialize, Serialize};

use super::lenient::or_default;

declare_names! {
    /// The places to which a move goes while it snaps.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum SnapTo {
        /// Steps from where the thing was.
        #[default]
        Increments = "increments" => "Steps from where the thing was",
        /// Multiples of the step, counted from the origin of the world.
        Grid = "grid" => "Multiples of the step, from the origin of the world",
        /// Corners of what is under the pointer.
        Vertices = "vertices" => "Corners of what is under the pointer",
        /// Edges of what is under the pointer.
        Edges = "edges" => "Edges of what is under the pointer",
        /// The surface under the pointer.
        Faces = "faces" => "The surface under the pointer",
    }
}

impl SnapTo {
    /// Whether it needs something under the pointer.
    pub(crate) fn is_of_geometry(self) -> bool {
        matches!(self, Self::Vertices | Self::Edges | Self::Faces)
    }
}

/// The condition and the target of snapping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Snapping {
    /// The target.
    #[serde(deserialize_with = "or_default")]
    pub to: SnapTo,
    /// Whether moves snap without Control, and do not with it.
    pub always: bool,
    /// Whether a thing that is moved along a surface is turned, so that its upper side faces along the surface's
    /// normal.
    pub aligns: bool,
}
