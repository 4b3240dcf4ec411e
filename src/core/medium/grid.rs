//! The voxels of a volume.

use glam::UVec3;
use half::f16;
use thiserror::Error;

use crate::color::{BRIGHTEST, Rgb};
use crate::memory::{Held, Reservation};

/// The most voxels along an axis, so that voxel coordinates fit well into 32 bits.
const MOST_ALONG_AXIS: u32 = 1 << 14;

/// A box of voxels with one or three values each, from 0 to [`BRIGHTEST`].
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeGrid {
    resolution: UVec3,
    channels: u32,
    voxels: Voxels,
    mended: Mended,
    memory: Held,
}

/// The numbers of values that were replaced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mended {
    /// Values that were negative, infinite or NaN, and are zero now.
    pub zeros: usize,
    /// Values above [`BRIGHTEST`], which are clamped to it.
    pub limited: usize,
}

/// The values of voxels in the precision of their file: x varies fastest, then y, then z; the channels of a voxel are
/// adjacent.
#[derive(Clone, Debug, PartialEq)]
pub enum Voxels {
    /// Four bytes per value.
    F32(Vec<f32>),
    /// Two bytes per value.
    F16(Vec<f16>),
    /// One byte per value; 255 means 1.
    U8(Vec<u8>),
}

/// The reason why a grid is invalid.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum GridError {
    /// An axis has too few or too many voxels.
    #[error("a grid of {0} x {1} x {2} voxels: each axis must have 1 to {MOST_ALONG_AXIS}")]
    Resolution(u32, u32, u32),
    /// Voxels have neither one nor three values.
    #[error("{0} values per voxel: 1 or 3 are expected")]
    Channels(u32),
    /// The number of values does not match the grid.
    #[error("{found} values where the grid has {expected}")]
    Count {
        /// The number of values given.
        found: usize,
        /// Voxels times channels.
        expected: usize,
    },
}

impl Voxels {
    fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::F16(values) => values.len(),
            Self::U8(values) => values.len(),
        }
    }

    #[inline(always)]
    fn get(&self, index: usize) -> f32 {
        match self {
            Self::F32(values) => values[index],
            Self::F16(values) => values[index].to_f32(),
            Self::U8(values) => f32::from(values[index]) * (1.0 / 255.0),
        }
    }

    /// Sets negative and not finite values to zero, clamps values above the limit, and counts both.
    fn mend(&mut self) -> Mended {
        let mut mended = Mended::default();
        match self {
            Self::F32(values) => {
                for value in values {
                    if !(*value >= 0.0 && value.is_finite()) {
                        *value = 0.0;
                        mended.zeros += 1;
                    } else if *value > BRIGHTEST {
                        *value = BRIGHTEST;
                        mended.limited += 1;
                    }
                }
            }
            // Half precision has no values above the limit.
            Self::F16(values) => {
                for value in values {
                    if !(*value >= f16::ZERO && value.is_finite()) {
                        *value = f16::ZERO;
                        mended.zeros += 1;
                    }
                }
            }
            Self::U8(_) => {}
        }
        mended
    }
}

impl VolumeGrid {
    /// A grid of `resolution` voxels with `channels` values each, 1 or 3. Negative and not finite values become zero,
    /// and values above [`BRIGHTEST`] are clamped to it.
    pub fn new(resolution: UVec3, channels: u32, mut voxels: Voxels) -> Result<Self, GridError> {
        if resolution.min_element() < 1 || resolution.max_element() > MOST_ALONG_AXIS {
            return Err(GridError::Resolution(resolution.x, resolution.y, resolution.z));
        }
        if channels != 1 && channels != 3 {
            return Err(GridError::Channels(channels));
        }
        let expected = resolution
            .to_array()
            .map(|size| size as usize)
            .iter()
            .product::<usize>()
            * channels as usize;
        if voxels.len() != expected {
            let found = voxels.len();
            return Err(GridError::Count { found, expected });
        }
        let mended = voxels.mend();
        Ok(Self {
            resolution,
            channels,
            voxels,
            mended,
            memory: Held::default(),
        })
    }

    /// The grid, which keeps `memory` reserved in the memory budget.
    pub(super) fn holding(mut self, memory: Reservation) -> Self {
        self.memory = memory.into();
        self
    }

    /// The number of voxels along each axis.
    #[inline(always)]
    pub fn resolution(&self) -> UVec3 {
        self.resolution
    }

    /// The number of values of a voxel, 1 or 3.
    pub fn channels(&self) -> u32 {
        self.channels
    }

    /// The values of all voxels.
    pub fn voxels(&self) -> &Voxels {
        &self.voxels
    }

    /// The numbers of values that differ from the given ones.
    pub fn mended(&self) -> Mended {
        self.mended
    }

    /// The memory of the values in bytes.
    pub fn size(&self) -> usize {
        match &self.voxels {
            Voxels::F32(values) => size_of_val(values.as_slice()),
            Voxels::F16(values) => size_of_val(values.as_slice()),
            Voxels::U8(values) => values.len(),
        }
    }

    /// The values of the voxel at `place`, which is within the grid; a single value is repeated three times.
    #[inline(always)]
    pub fn voxel(&self, place: UVec3) -> Rgb {
        let [x, y, z] = place.to_array().map(|at| at as usize);
        let [width, height, _] = self.resolution.to_array().map(|size| size as usize);
        let index = (z * height + y) * width + x;
        match self.channels {
            1 => Rgb::splat(self.voxels.get(index)),
            _ => Rgb::from_array([0, 1, 2].map(|channel| self.voxels.get(3 * index + channel))),
        }
    }

    /// The largest value of the voxels from `first` to `last`, both included.
    pub(super) fn largest(&self, first: UVec3, last: UVec3) -> f32 {
        self.fold(first, last, 0.0, f32::max)
    }

    /// The least value of the voxels from `first` to `last`, both included.
    pub(super) fn smallest(&self, first: UVec3, last: UVec3) -> f32 {
        self.fold(first, last, f32::INFINITY, f32::min)
    }

    fn fold(&self, first: UVec3, last: UVec3, start: f32, choose: impl Fn(f32, f32) -> f32 + Copy) -> f32 {
        let [width, height, _] = self.resolution.to_array().map(|size| size as usize);
        let channels = self.channels as usize;
        let mut chosen = start;
        for z in first.z..=last.z {
            for y in first.y..=last.y {
                let row = (z as usize * height + y as usize) * width;
                let values = (row + first.x as usize) * channels..(row + last.x as usize + 1) * channels;
                chosen = match &self.voxels {
                    Voxels::F32(all) => all[values].iter().copied().fold(chosen, choose),
                    Voxels::F16(all) => all[values].iter().map(|value| value.to_f32()).fold(chosen, choose),
                    Voxels::U8(all) => {
                        let numbers = all[values].iter().map(|&value| f32::from(value) * (1.0 / 255.0));
                        numbers.fold(chosen, choose)
                    }
                };
            }
        }
        chosen
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_grids_are_refused() {
        let grid = |resolution: [u32; 3], channels, count| {
            VolumeGrid::new(resolution.into(), channels, Voxels::U8(vec![1; count])).map(|grid| grid.size())
        };
        assert_eq!(grid([2, 3, 4], 3, 72), Ok(72));
        assert_eq!(grid([2, 0, 4], 1, 0), Err(GridError::Resolution(2, 0, 4)));
        assert_eq!(
            grid([1, 1, 20_000], 1, 20_000),
            Err(GridError::Resolution(1, 1, 20_000))
        );
        assert_eq!(grid([1, 1, 1], 2, 2), Err(GridError::Channels(2)));
        let expected = Err(GridError::Count { found: 5, expected: 6 });
        assert_eq!(grid([1, 2, 3], 1, 5), expected);
    }

    #[test]
    fn bad_values_become_zero_and_are_counted() {
        let grid = VolumeGrid::new(
            UVec3::new(2, 2, 1),
            1,
            Voxels::F32(vec![-1.0, f32::NAN, 3.0, f32::INFINITY]),
        )
        .unwrap();
        let last = UVec3::new(1, 1, 0);
        assert_eq!((grid.mended().zeros, grid.largest(UVec3::ZERO, last)), (3, 3.0));
        assert_eq!(grid.smallest(UVec3::ZERO, last), 0.0);
        let halves = [-2.0, 0.5].map(f16::from_f32).to_vec();
        let grid = VolumeGrid::new(UVec3::new(1, 2, 1), 1, Voxels::F16(halves)).unwrap();
        assert_eq!((grid.mended().zeros, grid.voxel(UVec3::Y).x), (1, 0.5));
        let huge = Voxels::F32(vec![3e38, 1e12]);
        let grid = VolumeGrid::new(UVec3::new(1, 2, 1), 1, huge).unwrap();
        assert_eq!(grid.mended(), Mended { zeros: 0, limited: 1 });
        assert_eq!(grid.voxel(UVec3::ZERO).x, BRIGHTEST);
    }
}
