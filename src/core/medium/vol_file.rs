//! Mitsuba's `.vol` files: a box of voxels with one or three values each.
//!
//! All numbers are little-endian: `VOL` and the version 3, then as 32-bit integers the type of the values, the numbers
//! of voxels along x, y and z and of values per voxel, then two corners of a box as six floats, and the values. x
//! varies fastest, and the values of a voxel are adjacent.

use glam::{UVec3, Vec3};
use half::f16;
use thiserror::Error;

use super::{GridError, VolumeGrid, Voxels};
use crate::math::Aabb;
use crate::memory::{self, Shortage};

const MAGIC: &[u8] = b"VOL";
const VERSION: u8 = 3;
/// The bytes before the values.
const HEADER: usize = 48;

// The types of values.
const FLOATS: i32 = 1;
const HALVES: i32 = 2;
const BYTES: i32 = 3;
const DIRECTIONS: i32 = 4;

/// The content of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct VolFile {
    /// The voxels.
    pub grid: VolumeGrid,
    /// The box of the voxels in the space of the file; None if the file's box is invalid or flat.
    pub bounds: Option<Aabb>,
}

/// The reason why bytes cannot be read as a `.vol` file. Callers add the file's name.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum VolError {
    #[error("no .vol file: it does not begin with `VOL`")]
    Magic,
    #[error("version {0} of the format .vol is not known, only {VERSION}")]
    Version(u8),
    #[error(
        "the values are quantised directions, which no volume here has a use for: 32-bit or 16-bit floats, or bytes are expected"
    )]
    Directions,
    #[error("type {0} of values is not known: 1 (32-bit floats), 2 (16-bit floats) or 3 (bytes) are expected")]
    Type(i32),
    #[error("a grid of {0} x {1} x {2} voxels is no grid")]
    Resolution(i32, i32, i32),
    #[error("{0} values per voxel: 1 or 3 are expected")]
    Channels(i32),
    #[error("the file ends early: it has {found} bytes, and its header of {header} says {promised}")]
    Truncated {
        found: usize,
        header: String,
        promised: u64,
    },
    #[error("{0}")]
    Grid(#[from] GridError),
    #[error("{what} need {shortage}")]
    Memory { what: String, shortage: Shortage },
}

/// Reads a whole file. Negative and NaN values become zero, see [`VolumeGrid::mended`].
pub fn read_vol(bytes: &[u8]) -> Result<VolFile, VolError> {
    if !bytes.starts_with(MAGIC) {
        return Err(VolError::Magic);
    }
    let Some((header, values)) = bytes.split_at_checked(HEADER) else {
        return Err(VolError::Truncated {
            found: bytes.len(),
            header: "nothing more".to_owned(),
            promised: HEADER as u64,
        });
    };
    if header[3] != VERSION {
        return Err(VolError::Version(header[3]));
    }
    let word = |index: usize| std::array::from_fn(|byte| header[4 + 4 * index + byte]);
    let integer = |index| i32::from_le_bytes(word(index));
    let float = |index| f32::from_le_bytes(word(index));
    let width: u64 = match integer(0) {
        FLOATS => 4,
        HALVES => 2,
        BYTES => 1,
        DIRECTIONS => return Err(VolError::Directions),
        other => return Err(VolError::Type(other)),
    };
    let size = [1, 2, 3].map(integer);
    let channels = match integer(4) {
        1 => 1,
        3 => 3,
        other => return Err(VolError::Channels(other)),
    };
    let [x, y, z] = size;
    let count = size.iter().try_fold(u64::from(channels), |count, &along| {
        let along = u64::try_from(along).ok().filter(|along| *along > 0)?;
        count.checked_mul(along)
    });
    let promised = count.and_then(|count| count.checked_mul(width));
    let Some(promised) = promised else {
        return Err(VolError::Resolution(x, y, z));
    };
    let what = || format!("{x} x {y} x {z} voxels");
    let values = usize::try_from(promised).ok().and_then(|length| values.get(..length));
    let Some(values) = values else {
        return Err(VolError::Truncated {
            found: bytes.len(),
            header: what(),
            promised: promised.saturating_add(HEADER as u64),
        });
    };
    let memory = memory::reserve(promised).map_err(|shortage| VolError::Memory { what: what(), shortage })?;
    let voxels = match integer(0) {
        FLOATS => Voxels::F32(
            values
                .as_chunks()
                .0
                .iter()
                .map(|four| f32::from_le_bytes(*four))
                .collect(),
        ),
        HALVES => Voxels::F16(
            values
                .as_chunks()
                .0
                .iter()
                .map(|two| f16::from_le_bytes(*two))
                .collect(),
        ),
        _ => Voxels::U8(values.to_vec()),
    };
    let bounds = Aabb {
        min: Vec3::from_array([5, 6, 7].map(float)),
        max: Vec3::from_array([8, 9, 10].map(float)),
    };
    let is_box = bounds.min.is_finite() && bounds.max.is_finite() && bounds.min.cmplt(bounds.max).all();
    // Each size is above 0.
    let resolution = UVec3::from_array(size.map(|along| along as u32));
    Ok(VolFile {
        grid: VolumeGrid::new(resolution, channels, voxels)?.holding(memory),
        bounds: is_box.then_some(bounds),
    })
}

/// Writes a grid that fills a box of the file's space.
pub fn write_vol(grid: &VolumeGrid, bounds: &Aabb) -> Vec<u8> {
    let (kind, values): (i32, Vec<u8>) = match grid.voxels() {
        Voxels::F32(values) => (FLOATS, values.iter().flat_map(|value| value.to_le_bytes()).collect()),
        Voxels::F16(values) => (HALVES, values.iter().flat_map(|value| value.to_le_bytes()).collect()),
        Voxels::U8(values) => (BYTES, values.clone()),
    };
    let mut bytes = Vec::with_capacity(HEADER + values.len());
    bytes.extend(MAGIC);
    bytes.push(VERSION);
    let [x, y, z] = grid.resolution().to_array().map(|along| along as i32);
    for number in [kind, x, y, z, grid.channels() as i32] {
        bytes.extend(number.to_le_bytes());
    }
    for number in bounds.min.to_array().into_iter().chain(bounds.max.to_array()) {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend(values);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Aabb = Aabb {
        min: Vec3::ZERO,
        max: Vec3::ONE,
    };

    fn grid(voxels: Voxels) -> VolumeGrid {
        VolumeGrid::new(UVec3::new(2, 1, 2), 1, voxels).expect("four values")
    }

    #[test]
    fn every_type_of_values_comes_back() {
        let numbers = [0.0, 0.25, 3.0, 1000.0];
        let halves = numbers.map(f16::from_f32).to_vec();
        for voxels in [
            Voxels::F32(numbers.to_vec()),
            Voxels::F16(halves),
            Voxels::U8(vec![0, 1, 128, 255]),
        ] {
            let grid = grid(voxels);
            let bounds = Aabb {
                min: Vec3::new(-1.0, 0.0, 2.0),
                max: Vec3::new(1.0, 0.5, 4.0),
            };
            let file = read_vol(&write_vol(&grid, &bounds)).expect("it was written");
            assert_eq!(
                file,
                VolFile {
                    grid,
                    bounds: Some(bounds)
                }
            );
        }
        let colors = VolumeGrid::new(UVec3::new(1, 2, 1), 3, Voxels::U8(vec![1, 2, 3, 4, 5, 6])).expect("six values");
        let file = read_vol(&write_vol(&colors, &UNIT)).expect("it was written");
        assert_eq!(file.grid, colors);
    }

    /// The file that Mitsuba writes for `VolumeGrid(numpy.array([[[0.5, 1]]], float32))`: x grows fastest.
    #[test]
    fn a_file_of_mitsuba_is_read() {
        let mut bytes = b"VOL\x03".to_vec();
        for number in [1, 2, 1, 1, 1] {
            bytes.extend(i32::to_le_bytes(number));
        }
        for number in [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.5, 1.0f32] {
            bytes.extend(number.to_le_bytes());
        }
        let file = read_vol(&bytes).expect("a file");
        assert_eq!((file.grid.resolution(), file.bounds), (UVec3::new(2, 1, 1), Some(UNIT)));
        assert_eq!(file.grid.voxel(UVec3::X).x, 1.0);
    }

    #[test]
    fn broken_files_say_what_is_wrong() {
        let good = write_vol(&grid(Voxels::F32(vec![1.0; 4])), &UNIT);
        let with = |place: usize, number: i32| {
            let mut bytes = good.clone();
            bytes[place..place + 4].copy_from_slice(&number.to_le_bytes());
            read_vol(&bytes).expect_err("it is broken").to_string()
        };
        assert!(with(4, 4).contains("quantised directions"));
        assert!(with(4, 7).contains("type 7"));
        assert!(with(8, 0).contains("0 x 1 x 2"));
        assert!(with(8, -5).contains("-5 x 1 x 2"));
        assert!(with(12, i32::MAX).contains("ends early"), "{}", with(12, i32::MAX));
        assert!(with(20, 2).contains("2 values per voxel"));
        let mut version = good.clone();
        version[3] = 2;
        assert!(
            read_vol(&version)
                .expect_err("too old")
                .to_string()
                .contains("version 2")
        );
        for length in 0..good.len() {
            assert!(read_vol(&good[..length]).is_err(), "{length}");
        }
        // The product of all numbers is above 2^64.
        let mut huge = good.clone();
        for place in [8, 12, 16] {
            huge[place..place + 4].copy_from_slice(&i32::MAX.to_le_bytes());
        }
        assert!(read_vol(&huge).is_err());
    }

    #[test]
    fn odd_values_and_boxes_are_mended() {
        let mut bytes = write_vol(&grid(Voxels::F32(vec![1.0; 4])), &UNIT);
        bytes[HEADER..HEADER + 4].copy_from_slice(&f32::NAN.to_le_bytes());
        bytes[24..28].copy_from_slice(&2.0f32.to_le_bytes());
        let file = read_vol(&bytes).expect("it is mended");
        assert_eq!((file.grid.mended().zeros, file.bounds), (1, None));
        assert_eq!(file.grid.voxel(UVec3::ZERO).x, 0.0);
    }
}
