//! Types for arranging several things relative to each other: sides, references, and series of copies.

use super::traits::Traits;
use bevy::prelude::Entity;

use bevy::math::{Affine3A, Quat, Vec3};

declare_names! {
    /// The part of each thing's bounds that is brought in line.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Side {
        /// The lower end along the axis.
        Low = "low",
        /// The middle.
        Middle = "middle",
        /// The upper end along the axis.
        High = "high",
    }
}

/// The reference of an alignment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The common bounds of all of them.
    Bounds,
    /// The bounds of the thing that was selected last.
    Active,
}

declare_names! {
    /// What is equal between things that are distributed.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Spacing {
        /// The empty space between the bounds of neighbours.
        Gaps = "gaps",
        /// The distance between the middles of neighbours.
        Middles = "middles",
    }
}

/// A series of copies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    /// The number of things in the series, with the original: 2 or more.
    pub count: u32,
    /// The transform from one copy to the next.
    pub way: Way,
    /// Whether the copies are instances of one group of shapes, and not shapes of their own.
    pub instances: bool,
}

impl Series {
    /// The map of the world that takes the original to the thing with this number, 0 for the original itself.
    pub fn map(&self, number: u32) -> Affine3A {
        match self.way {
            Way::Along(step) => Affine3A::from_translation(step * number as f32),
            Way::Around { axis, degrees, center } => {
                // A whole ring does not end where it began.
                let steps = if degrees.abs() < 360.0 {
                    self.count - 1
                } else {
                    self.count
                };
                let angle = degrees * number as f32 / steps as f32;
                let turn = Quat::from_axis_angle(Vec3::AXES[axis.min(2)], angle.to_radians());
                Affine3A::from_translation(center) * Affine3A::from_quat(turn) * Affine3A::from_translation(-center)
            }
        }
    }
}

/// The transform from one thing of a series to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// A move in world units.
    Along(Vec3),
    /// A turn.
    Around {
        /// The axis of the world: 0, 1 or 2.
        axis: usize,
        /// The total angle of all steps in degrees, including the one from the last thing back to the first; 360 for a
        /// whole ring.
        degrees: f32,
        /// A point on the axis.
        center: Vec3,
    },
}

/// The largest number of things in a series.
pub const LONGEST_SERIES: u32 = 10_000;

/// An edit that moves the selection relative to other things, to the view or to the grid.
#[derive(Clone, Debug, PartialEq)]
pub enum ArrangeEdit {
    /// Aligns one side of each selected thing, along an axis of the world from 0 to 2.
    Align(usize, Side, Reference),
    /// Spaces the selected things evenly along an axis of the world from 0 to 2; the outermost stay.
    Distribute(usize, Spacing),
    /// Gives each selected thing this size, in world units, along an axis of the world from 0 to 2.
    Resize(usize, f32),
    /// Scales things to a third of the view, and puts them onto the surface in the middle of the picture.
    FitToView(Vec<Entity>),
    /// Moves the selection by a step along the axis of the world that is nearest to this direction in the picture.
    Nudge(Direction),
    /// Moves the selection by a step along the axis of the world that is nearest to this direction in world space.
    NudgeAlong(Vec3),
    /// Drops each selected thing onto the surface below it.
    Drop,
    /// Puts the origin of each selected thing onto the grid of the gizmo's step.
    SnapToGrid,
}

impl ArrangeEdit {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Align(..) => Traits::edit("Align").of_selection(),
            Self::Distribute(..) => Traits::edit("Distribute").of_selection(),
            Self::Resize(..) => Traits::drag("Resize").of_selection(),
            Self::FitToView(things) => Traits::edit("Fit to view").of(things),
            Self::Nudge(_) | Self::NudgeAlong(_) => Traits::edit("Move").of_selection(),
            Self::Drop => Traits::edit("Drop").of_selection(),
            Self::SnapToGrid => Traits::edit("Put onto the grid").of_selection(),
        }
    }
}

/// The directions on the ground, as the camera sees it, and up and down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// To the left in the picture.
    Left,
    /// To the right in the picture.
    Right,
    /// Away from the camera.
    Ahead,
    /// Towards the camera.
    Back,
    /// Along +y of the world.
    Up,
    /// Along -y of the world.
    Down,
}
