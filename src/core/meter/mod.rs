//! Measures illuminance in lux, at points and over grids of points.
//!
//! A point is a texel of a lightmap without a surface: the irradiance there is gathered as in [`crate::bake`], and one
//! watt of its Rec. 709 luminance is [`LUMENS_PER_WATT`](crate::photometry::LUMENS_PER_WATT) lumens. Grids have their
//! points in the middles of equal cells, as EN 12464-1 has them, and are judged by their least and
//! mean illuminance and by the uniformity, the ratio of both.
//!
//! [`sites`] places the points, [`job`] gathers light until it is as certain as asked for, and [`estimate`] has values
//! with their errors. [`daylight`] replaces the lights of a scene by an overcast sky, and [`glare`] rates the glare of
//! a view.

pub mod daylight;
pub mod estimate;
pub mod glare;
pub mod job;
pub mod sites;
