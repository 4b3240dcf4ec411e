//! Cameras and their film.

use bevy::prelude::*;

use super::{DocumentOrder, ToWorld};

/// A camera; its pose is [`ToWorld`] (+z forward, +x left, +y up; any scale in it is dropped).
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, PartialEq)]
#[require(ToWorld, Film, DocumentOrder)]
pub struct Sensor {
    pub lens: Lens,
    /// Field of view in degrees, 0 to 180 exclusive, along `fov_axis`.
    pub fov: f32,
    pub fov_axis: FovAxis,
    /// Distances along the view axis between which things are seen.
    pub near_clip: f32,
    pub far_clip: f32,
}

impl Default for Sensor {
    fn default() -> Self {
        Self {
            lens: Lens::Pinhole,
            fov: 39.3077,
            fov_axis: FovAxis::X,
            near_clip: 1e-2,
            far_clip: 1e4,
        }
    }
}

#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
pub enum Lens {
    /// `perspective`
    #[default]
    Pinhole,
    /// `thinlens`: a round aperture, sharp in the plane at `focus_distance` along the view axis.
    Thin { aperture_radius: f32, focus_distance: f32 },
}

#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FovAxis {
    #[default]
    X,
    Y,
    Diagonal,
    Smaller,
    Larger,
}

/// What a sensor records on, and how many samples the file asks for.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, PartialEq)]
pub struct Film {
    /// Pixels.
    pub width: u32,
    pub height: u32,
    pub filter: ReconstructionFilter,
    /// Samples per pixel to stop at.
    pub sample_count: u32,
}

impl Film {
    /// Pixels along one side.
    pub const LARGEST_SIDE: u32 = 65_536;
    /// Pixels in all: sums and finished pictures of that size take 5 GB.
    pub const MOST_PIXELS: u64 = 1 << 26;

    /// Whether there can be a film of this size in pixels.
    pub fn is_possible(width: u32, height: u32) -> bool {
        let sides = 1..=Self::LARGEST_SIDE;
        sides.contains(&width) && sides.contains(&height) && u64::from(width) * u64::from(height) <= Self::MOST_PIXELS
    }
}

impl Default for Film {
    fn default() -> Self {
        Self {
            width: 768,
            height: 576,
            filter: ReconstructionFilter::default(),
            sample_count: 16,
        }
    }
}

/// Weighs samples around a pixel's centre.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum ReconstructionFilter {
    Box,
    /// Truncated at four standard deviations; `stddev` in pixels.
    Gaussian {
        stddev: f32,
    },
}

impl Default for ReconstructionFilter {
    fn default() -> Self {
        Self::Gaussian { stddev: 0.5 }
    }
}
