//! The choice of inspected paths of the picture.

use bevy::math::{UVec2, Vec2};

use crate::engine::reasons::{Group, Grouping};
use crate::render::breakdown::Area;
use crate::render::view::View;

/// The paths that the user has asked to inspect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InspectedPaths {
    /// The place in the film: (0, 0) top left, (1, 1) bottom right; a view that shows more may have places outside.
    pub place: Vec2,
    /// The size of the rectangle below and right of the place, in parts of the film; zero for one pixel.
    pub extent: Vec2,
    /// The number of samples of the pixel, from the first on; of a rectangle the number of its paths.
    pub count: u32,
    /// The path that is described, from 0.
    pub chosen: u32,
    /// The grouping in which the light is told.
    pub grouping: Grouping,
    /// The group whose paths alone are shown; None for all.
    pub of: Option<Group>,
}

impl InspectedPaths {
    /// The most paths; more would cover the picture.
    pub(crate) const MOST: u32 = 64;

    /// The first eight paths of the pixel at `place`.
    pub fn at(place: Vec2) -> Self {
        Self {
            place,
            extent: Vec2::ZERO,
            count: 8,
            chosen: 0,
            grouping: Grouping::default(),
            of: None,
        }
    }

    /// The first eight paths of the rectangle between two corners of the film.
    pub fn between(corners: [Vec2; 2]) -> Self {
        let [one, other] = corners;
        Self {
            extent: (other - one).abs(),
            ..Self::at(one.min(other))
        }
    }

    /// The same place with the number of paths and the grouping of the paths inspected before.
    pub fn shown_as(self, before: Option<Self>) -> Self {
        let before = before.unwrap_or(self);
        Self {
            count: before.count,
            grouping: before.grouping,
            ..self
        }
    }

    /// The pixels of the picture, at least one.
    pub fn area(&self, view: &View) -> Area {
        let size = UVec2::new(view.width, view.height).max(UVec2::ONE);
        let pixel = |place: Vec2| view.picture_of_film(place).clamp(Vec2::ZERO, Vec2::ONE) * size.as_vec2();
        let first = pixel(self.place).as_uvec2().min(size - UVec2::ONE);
        // Rounding of the corner adds no row or column.
        let end = pixel(self.place + self.extent) - 1e-6 * size.as_vec2();
        let end = end.ceil().as_uvec2();
        let extent = match self.extent == Vec2::ZERO {
            true => UVec2::ONE,
            false => end.min(size).saturating_sub(first).max(UVec2::ONE),
        };
        Area {
            x: first.x,
            y: first.y,
            width: extent.x,
            height: extent.y,
        }
    }
}
