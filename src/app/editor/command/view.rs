//! Commands that move the view, and edits of the camera in use.

use bevy::math::{Affine3A, Vec2, Vec3};
use bevy::prelude::Entity;

use super::axis_view::AxisView;
use super::seeing::Seeing;
use super::side_views::SidePlace;
use super::traits::Traits;

/// An edit of the camera in use.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraEdit {
    /// Moves the sensor in use to the pose of the view.
    MoveCameraToView,
    /// Focuses the camera in use on the surface at a point of the picture: (0, 0) is top left, (1, 1) bottom right. A
    /// pinhole camera becomes a thin lens.
    FocusAt(Vec2),
    /// Writes the samples, the limit of noise and the adaptive sampling of the window into the film of the camera.
    KeepLimits,
}

impl CameraEdit {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::MoveCameraToView => Traits::edit("Move camera to view"),
            Self::FocusAt(_) => Traits::edit("Focus"),
            Self::KeepLimits => Traits::edit("Keep limits"),
        }
    }
}

/// A command that moves the view or filters the visible things. None of them edits the scene.
#[derive(Clone, Debug, PartialEq)]
pub enum ViewCommand {
    /// Moves back or forth until the selection fills the view.
    FrameSelection,
    /// Moves back or forth until the scene fills the view.
    FrameAll,
    /// Flies to a pose of the camera, given as world from camera.
    MoveView(Affine3A),
    /// Uses this sensor, at its own pose.
    LookThrough(Entity),
    /// Stores the centre of orbits; views along an axis keep it in the middle.
    TurnAbout(Vec3),
    /// Looks along an axis of the world, at the selection, the centre of orbits, or the surface ahead.
    LookAlong(AxisView),
    /// Switches between perspective and orthographic; things in the middle keep their size.
    SwitchProjection,
    /// Stores the view under a number from 1 to 9.
    StoreView(usize),
    /// Restores a stored view.
    RecallView(usize),
    /// Puts the view at the eyes of a person on the floor below it, who walks; or lets it fly again.
    Walk(bool),
    /// Sets the flying speed as a multiple of the one that suits the scene's size.
    SetSpeed(f32),
    /// Sets the filters of the view.
    SetSeeing(Seeing),
    /// Puts a cut plane through the middle of the selection, or of the scene, facing the camera.
    CutOpen,
    /// Isolates these shapes; without any, shows all again.
    Isolate(Vec<Entity>),
    /// Shows or hides the side views.
    ShowSideViews(bool),
    /// Shows the surfaces in side views in one grey, or in their own colours.
    ShowSidesInClay(bool),
    /// Shows the outer walls and roofs in the side view with this number, or the rooms behind them.
    CloseSideView(usize, bool),
    /// Sets the place of the side view with this number.
    PlaceSideView(usize, SidePlace),
}

impl ViewCommand {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::MoveView(_) => Traits::VIEW.moving_picture(),
            Self::FrameSelection
            | Self::FrameAll
            | Self::LookThrough(_)
            | Self::LookAlong(_)
            | Self::SwitchProjection
            | Self::RecallView(_)
            | Self::Walk(_)
            | Self::SetSeeing(_)
            | Self::CutOpen
            | Self::Isolate(_) => Traits::VIEW,
            Self::TurnAbout(_) | Self::StoreView(_) | Self::SetSpeed(_) => Traits::NONE,
            Self::ShowSideViews(_) | Self::ShowSidesInClay(_) | Self::CloseSideView(..) | Self::PlaceSideView(..) => {
                Traits::NONE
            }
        }
    }
}
