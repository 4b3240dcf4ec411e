//! A tool that replaces selection for clicks and drags in the picture.

use bevy::prelude::Entity;

use super::gizmo_settings::GizmoSettings;
use super::inspected_paths::InspectedPaths;
use super::ruler::Ruler;
use super::traits::Traits;

use super::blocking::{BlockKind, OpeningKind};

/// A tool. Escape ends it, and so does its use, except for tools that are used repeatedly: for paths, distances and
/// textures, and all that block out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// Selects, as without any tool.
    #[default]
    Select,
    /// Focuses a thin lens on the clicked thing.
    Focus,
    /// Draws the region of the picture that is rendered.
    Region,
    /// Shows the paths of the clicked pixel or of a rectangle, and where their light comes from.
    Paths,
    /// Measures the distance between two clicked points.
    Ruler,
    /// Draws things on the ground and on surfaces.
    Draw(BlockKind),
    /// Pushes and pulls the faces of boxes and building parts.
    Push,
    /// Cuts doors and windows into walls.
    Cut(OpeningKind),
    /// Places the textures of the selected shape by handles on its surface.
    PlaceTexture,
    /// Paints the light you want over the picture.
    PaintLight,
}

impl Tool {
    /// Whether the handles of the selection are hidden, because they would take clicks from the tool.
    pub fn hides_handles(self) -> bool {
        matches!(self, Self::Ruler | Self::PlaceTexture | Self::PaintLight)
    }

    /// The instruction that is shown over the picture.
    pub fn hint(self) -> Option<&'static str> {
        match self {
            Self::Select => None,
            Self::Focus => Some("Click what is to be sharp (Esc: never mind)"),
            Self::Region => Some("Drag a box around what is to be rendered (Esc: never mind)"),
            Self::Ruler => Some("Click two points to measure between them (Esc: done)"),
            Self::PlaceTexture => {
                Some("Drag the tile: its inside, its squares, its arm. Click another surface to go there (Esc: done)")
            }
            Self::PaintLight => Some("Paint where light is wanted; the panel Render says which (Esc: done)"),
            Self::Paths => Some("Click a pixel, or drag a rectangle, to see where its light comes from (Esc: done)"),
            Self::Draw(BlockKind::Box) => Some(
                "Drag the foot of a box, or click a corner: on the ground or on a surface (Ctrl: off the grid, Esc: done)",
            ),
            Self::Draw(BlockKind::Floor) => {
                Some("Drag a floor, or click a corner: on the ground or on a surface (Ctrl: off the grid, Esc: done)")
            }
            Self::Draw(BlockKind::Wall) => Some(
                "Drag a wall, or click where it begins: on the ground or on a surface (Ctrl: off the grid, Esc: done)",
            ),
            Self::Push => Some("Drag a face of a box, a wall, stairs or a prism (Ctrl: off the grid, Esc: done)"),
            Self::Cut(OpeningKind::Door) => {
                Some("Click a wall or a box to cut a door, or drag one as large as you like (Esc: done)")
            }
            Self::Cut(OpeningKind::Window) => Some(
                "Click a wall or a box to cut a window, at its foot a French window, from above or below a hole, or drag one as large as you like (Esc: done)",
            ),
        }
    }

    /// Whether the tool draws, pushes or cuts: it uses the pointer and the number keys then, and the handles of the
    /// gizmo are hidden.
    pub fn blocks_out(self) -> bool {
        matches!(self, Self::Draw(_) | Self::Push | Self::Cut(_))
    }
}

/// A command about the tools for clicks and drags in the picture.
#[derive(Clone, Debug, PartialEq)]
pub enum ToolCommand {
    /// Sets the tool for the next click in the picture.
    SetTool(Tool),
    /// Keeps a measured distance in the picture.
    AddRuler(Ruler),
    /// Removes all measured distances.
    ClearRulers,
    /// Shows the paths of a pixel, or none.
    InspectPaths(Option<InspectedPaths>),
    /// Follows the light of a lamp, or of none.
    FollowLamp(Option<Entity>),
    /// Sets the settings of the gizmo.
    SetGizmo(GizmoSettings),
}

impl ToolCommand {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::SetTool(_)
            | Self::AddRuler(_)
            | Self::ClearRulers
            | Self::InspectPaths(_)
            | Self::FollowLamp(_)
            | Self::SetGizmo(_) => Traits::NONE,
        }
    }
}
