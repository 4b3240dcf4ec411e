//! The type that says which paths of the picture are inspected.

use bevy::math::Vec2;

/// The paths that the user has asked to inspect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InspectedPaths {
    /// (0, 0) top left of the picture, (1, 1) bottom right.
    pub place: Vec2,
    /// The first so many samples of the pixel.
    pub count: u32,
    /// The one that is told of, from 0 on.
    pub chosen: u32,
}

impl InspectedPaths {
    /// More would cover the picture.
    pub(crate) const MOST: u32 = 64;

    /// The first eight paths of the pixel at `place`.
    pub fn at(place: Vec2) -> Self {
        Self {
            place,
            count: 8,
            chosen: 0,
        }
    }
}
