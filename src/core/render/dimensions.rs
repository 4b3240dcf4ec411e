//! The random dimensions of a path: which of a sample's numbers is used for which decision.
//!
//! The first dimensions are the camera's. After them every bounce has as many as [`BounceDraw`] has names, whether it
//! needs them or not, so that one bounce cannot shift the numbers of another. A draw is one number or a pair, see
//! [`crate::sampling::Sampler`].
//!
//! Surfaces that let light pass straight need no extra numbers: passing is chosen as a lobe, by [`BounceDraw::Lobe`],
//! at its own depth. Every name that is added to [`BounceDraw`] changes the numbers of all later bounces, and so the
//! noise of every picture. The draws of media therefore have dimensions after those of the longest path.

use crate::math::Word;
use crate::sampling::SPREAD_DIMENSIONS;

/// The point within the pixel's filter through which the camera ray passes the film; a pair.
pub(super) const FILTER: u32 = 0;
/// The point of the lens where the ray starts; a pair.
pub(super) const LENS: u32 = 1;
/// The first dimension of the first bounce.
const CAMERA_DIMENSIONS: u32 = 2;

/// The draws at a surface.
#[derive(Clone, Copy, Debug)]
pub(super) enum BounceDraw {
    /// The choice of a light.
    LightChoice,
    /// The point on it; a pair.
    LightPoint,
    /// The lobe of the surface that the path follows.
    Lobe,
    /// The direction that the path takes; a pair.
    Direction,
    /// Whether Russian roulette ends the path.
    Roulette,
}

const BOUNCE_DIMENSIONS: u32 = BounceDraw::Roulette as u32 + 1;

// The noise visible in the first samples is that of the camera and of the first surface.
const _: () = assert!(SPREAD_DIMENSIONS == CAMERA_DIMENSIONS + BOUNCE_DIMENSIONS);

impl BounceDraw {
    /// The dimension of the draw at the surface number `depth` of the path, counted from 1.
    #[inline(always)]
    pub fn at<W: Word>(self, depth: W) -> W {
        let first = (depth - W::splat(1)) * W::splat(BOUNCE_DIMENSIONS) + W::splat(CAMERA_DIMENSIONS);
        first + W::splat(self as u32)
    }
}

/// The draws of a path in media. The direction and the light of a scattering in a medium are in [`BounceDraw`], as at a
/// surface.
#[derive(Clone, Copy, Debug)]
pub(super) enum MediumDraw {
    /// The length of the segment that leads to the vertex of this depth; a pair, and a stream.
    Distance,
    /// The transmittance of the shadow ray from the vertex of this depth; a stream.
    Shadow,
    /// The choice of a lamp, near which the segment that leads to the vertex of this depth gets more scattering.
    Lamp,
    /// The point on it; a pair.
    LampPoint,
}

/// Above the dimensions of all bounces of the longest path.
const MEDIUM_DIMENSIONS: u32 = 1 << 20;

impl MediumDraw {
    /// The dimension of the draw for the vertex number `depth` of the path, counted from 1.
    #[inline(always)]
    pub fn at<W: Word>(self, depth: W) -> W {
        W::splat(MEDIUM_DIMENSIONS + self as u32) + depth * W::splat(4)
    }
}

/// The draws of a light path.
#[derive(Clone, Copy, Debug)]
pub(super) enum LightDraw {
    /// The lobe of the surface that the path follows; at depth 0 the choice of the light.
    Lobe,
    /// The direction that the path takes; a pair. At depth 0 the direction of emission.
    Direction,
    /// Whether Russian roulette ends the path.
    Roulette,
    /// The point on the light, at depth 0 only; a pair.
    Place,
    /// The point of the lens to which the vertex sends its light; a pair.
    Lens,
    /// The pixel near that point of the film.
    Pixel,
    /// The vertex of this path with which the camera path's vertex of that depth is joined.
    Partner,
}

/// Above the dimensions of media.
const LIGHT_DIMENSIONS: u32 = 1 << 21;

impl LightDraw {
    /// The dimension of the draw at the vertex number `depth` of the path, counted from 0 at the light.
    #[inline(always)]
    pub fn at(self, depth: u32) -> u32 {
        LIGHT_DIMENSIONS + depth * (Self::Partner as u32 + 1) + self as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::WordLanes;
    use crate::render::view::LONGEST_PATH;

    #[test]
    fn media_have_dimensions_of_their_own() {
        assert!(BounceDraw::Roulette.at(LONGEST_PATH) < MediumDraw::Distance.at(1u32));
        assert!(MediumDraw::LampPoint.at(1u32) < MediumDraw::Distance.at(2));
        assert!(MediumDraw::LampPoint.at(LONGEST_PATH) < LightDraw::Lobe.at(0));
    }

    #[test]
    fn no_two_draws_share_a_dimension() {
        use BounceDraw::*;
        let mut dimensions = vec![FILTER, LENS];
        for depth in 1..=3 {
            dimensions.extend([LightChoice, LightPoint, Lobe, Direction, Roulette].map(|draw| draw.at(depth)));
        }
        assert_eq!(dimensions, (0..dimensions.len() as u32).collect::<Vec<_>>());
        let depths = WordLanes::new(std::array::from_fn(|lane| 1 + 7 * lane as u32));
        for (lane, &dimension) in Direction.at(depths).as_array().iter().enumerate() {
            assert_eq!(dimension, Direction.at(1 + 7 * lane as u32));
        }
    }
}
