//! Words for placing several things relative to each other: sides, references, and series of copies.

use bevy::math::Vec3;

/// The part of each thing's bounds that is brought in line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The lower end along the axis.
    Low,
    /// The middle.
    Middle,
    /// The upper end along the axis.
    High,
}

impl Side {
    /// The sides with their names in scripts.
    pub const ALL: [(Self, &'static str); 3] = [(Self::Low, "low"), (Self::Middle, "middle"), (Self::High, "high")];
}

/// What things are aligned to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The common bounds of all of them.
    Bounds,
    /// The bounds of the thing that was selected last.
    Active,
}

/// What is equal between things that are distributed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// The empty space between the bounds of neighbours.
    Gaps,
    /// The distance between the middles of neighbours.
    Middles,
}

impl Spacing {
    /// The spacings with their names in scripts.
    pub const ALL: [(Self, &'static str); 2] = [(Self::Gaps, "gaps"), (Self::Middles, "middles")];
}

/// A series of copies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    /// The number of things in the series, with the original: 2 or more.
    pub count: u32,
    /// The way from one to the next.
    pub way: Way,
    /// Whether the copies are instances of one group of shapes, and not shapes of their own.
    pub instances: bool,
}

/// The way from one thing of a series to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// A move in world units.
    Along(Vec3),
    /// A turn.
    Around {
        /// The axis of the world: 0, 1 or 2.
        axis: usize,
        /// Degrees that all steps take together, including the one from the last thing back to the first; 360 for a
        /// whole ring.
        degrees: f32,
        /// A point on the axis.
        center: Vec3,
    },
}

/// The largest number of things in a series.
pub const LONGEST_SERIES: u32 = 10_000;
