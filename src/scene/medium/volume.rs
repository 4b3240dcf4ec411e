//! Values that vary in space, as the user knows them.

use std::path::PathBuf;

use bevy::math::Affine3A;
use bevy::prelude::*;

use crate::color::Rgb;

/// The name in the file of [`GridFile::use_grid_bbox`].
pub(crate) const USE_GRID_BBOX: &str = "use_grid_bbox";

/// A parameter of a medium that is the same everywhere, or varies in space.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum VolumeParameter<T> {
    /// The same value everywhere.
    Constant(T),
    /// The same value in a box; as the density of a medium, nothing outside of it.
    Box {
        /// The value in the box.
        value: T,
        /// World from the unit cube, [0, 1]^3, which becomes the box. Invertible.
        to_world: Affine3A,
    },
    /// A grid of values in a file.
    Grid(GridFile),
}

impl<T> VolumeParameter<T> {
    /// The grid, if it is one.
    pub fn grid(&self) -> Option<&GridFile> {
        match self {
            Self::Grid(grid) => Some(grid),
            _ => None,
        }
    }
}

impl<T: Copy> VolumeParameter<T> {
    /// The value, if it is the same everywhere.
    pub fn constant(&self) -> Option<T> {
        match self {
            Self::Constant(value) => Some(*value),
            _ => None,
        }
    }
}

impl From<Rgb> for VolumeParameter<Rgb> {
    fn from(color: Rgb) -> Self {
        Self::Constant(color)
    }
}

impl From<f32> for VolumeParameter<f32> {
    fn from(number: f32) -> Self {
        Self::Constant(number)
    }
}

/// A file with a grid of values, and how it is looked at.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq)]
pub struct GridFile {
    /// The absolute path.
    pub path: PathBuf,
    /// World from the grid's own space, in which it fills the unit cube, [0, 1]^3. Invertible.
    pub to_world: Affine3A,
    /// How values between the centres of voxels come about.
    pub filter: VolumeFilter,
    /// What lies outside of the grid.
    pub wrap: VolumeWrap,
    /// Whether the grid fills the box that its file names, in place of the unit cube.
    pub use_grid_bbox: bool,
}

/// How values between the centres of voxels come about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VolumeFilter {
    /// The voxel that the point lies in.
    Nearest,
    /// A mean of the eight voxels around the point.
    #[default]
    Trilinear,
}

impl VolumeFilter {
    /// All filters.
    pub const ALL: [Self; 2] = [Self::Nearest, Self::Trilinear];

    /// The name in the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Trilinear => "trilinear",
        }
    }
}

/// The continuation of a grid outside of its box. The density of a medium ends there all the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VolumeWrap {
    /// The voxels of the border.
    #[default]
    Clamp,
    /// The grid again.
    Repeat,
    /// The grid again, every other time turned around.
    Mirror,
}

impl VolumeWrap {
    /// All continuations.
    pub const ALL: [Self; 3] = [Self::Clamp, Self::Repeat, Self::Mirror];

    /// The name in the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clamp => "clamp",
            Self::Repeat => "repeat",
            Self::Mirror => "mirror",
        }
    }
}
