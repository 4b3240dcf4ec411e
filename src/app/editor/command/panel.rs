//! The list of all panels.

use serde::{Deserialize, Serialize};

/// A part of the window that can be moved to another place, and closed, except the viewport.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Panel {
    /// The picture.
    Viewport,
    /// The list of all things of the scene.
    Outliner,
    /// The library of materials.
    Library,
    /// Folders of pictures, meshes and scenes.
    Assets,
    /// The parameters of the selection.
    Inspector,
    /// Samples, limits, integrator, light mixing and comparison.
    Render,
    /// The steps that can be undone and redone.
    History,
    /// The problems with the scene and its files.
    Messages,
    /// The paths of an inspected pixel, vertex by vertex.
    Paths,
    /// The bake of lightmaps that is under way.
    Bake,
}

impl Panel {
    /// The panels that can be closed and shown again, in the order of the menu.
    pub const CLOSEABLE: [Self; 9] = [
        Self::Outliner,
        Self::Library,
        Self::Assets,
        Self::Inspector,
        Self::Render,
        Self::History,
        Self::Messages,
        Self::Paths,
        Self::Bake,
    ];
    /// The panels at the right, one behind the other, until the user moves them.
    pub(crate) const RIGHT: [Self; 6] = [
        Self::Inspector,
        Self::Render,
        Self::History,
        Self::Messages,
        Self::Paths,
        Self::Bake,
    ];
    /// The panels at the left.
    pub(crate) const LEFT: [Self; 3] = [Self::Outliner, Self::Library, Self::Assets];
    /// The panels that are shown only on demand.
    pub(crate) const CLOSED: [Self; 2] = [Self::Paths, Self::Bake];

    /// The word on a tab that has little room.
    pub fn short_title(self) -> &'static str {
        match self {
            Self::Viewport => "View",
            Self::Outliner => "Outl.",
            Self::Library => "Lib.",
            Self::Assets => "Assets",
            Self::Inspector => "Insp.",
            Self::Render => "Rend.",
            Self::History => "Hist.",
            Self::Messages => "Mess.",
            Self::Paths => "Paths",
            Self::Bake => "Bake",
        }
    }

    /// The word on the tab and in the menu.
    pub fn title(self) -> &'static str {
        match self {
            Self::Viewport => "Viewport",
            Self::Outliner => "Outliner",
            Self::Library => "Library",
            Self::Assets => "Assets",
            Self::Inspector => "Inspector",
            Self::Render => "Render",
            Self::History => "History",
            Self::Messages => "Messages",
            Self::Paths => "Paths",
            Self::Bake => "Bake",
        }
    }
}
