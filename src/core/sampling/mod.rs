//! Random and low-discrepancy numbers, and the maps from them to directions, points and choices.
//!
//! All functions are pure and without global state, so that a picture does not depend on the order in which samples are
//! drawn.

mod bilinear;
mod distribution;
pub mod hash;
pub mod lanes;
mod mis;
mod sampler;
mod spherical_rectangle;
mod spherical_triangle;
mod stream;
pub mod warp;

pub use bilinear::{PiecewiseBilinear2d, SquareSample};
pub use distribution::{ContinuousSample, DiscreteDistribution, DiscreteSample, PiecewiseConstant1d};
pub use mis::power_heuristic;
pub(crate) use sampler::SPREAD_DIMENSIONS;
#[cfg(test)]
pub(crate) use sampler::{COLOUR, place_in_block};
pub use sampler::{Sampler, SequenceKind};
pub use spherical_rectangle::{Rectangle, SphericalRectangle};
pub(crate) use spherical_triangle::SphericalTriangle;
pub use stream::RandomStream;

/// The largest `f32` below one; uniform numbers never exceed it.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// The upper 24 bits of `bits` as a number in [0, 1): every value is exact and the largest is [`ONE_MINUS_EPSILON`].
pub fn unit_float(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / (1 << 24) as f32)
}
