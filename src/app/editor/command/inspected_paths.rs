//! The choice of inspected paths of the picture.

use bevy::math::Vec2;

/// The paths that the user has asked to inspect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InspectedPaths {
    /// The place in the film: (0, 0) top left, (1, 1) bottom right; a view that shows more may have places outside.
    pub place: Vec2,
    /// The number of samples of the pixel, from the first on.
    pub count: u32,
    /// The path that is described, from 0.
    pub chosen: u32,
}

impl InspectedPaths {
    /// The most paths; more would cover the picture.
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
