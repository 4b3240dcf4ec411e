//! Reads volumes from .vdb files, in which OpenVDB and programs built on it store smoke and fire (Museth, VDB:
//! High-Resolution Sparse Volumes with Dynamic Topology, 2013; the layout of the file is that of OpenVDB's own reader).
//!
//! Supported are trees of the usual form (5, 4, 3) whose values are one or three numbers in half, single or double
//! precision, packed by zlib, by Blosc with LZ4, or not at all, of the versions 222 to 224, which are those of OpenVDB
//! 1.2 to 12. A grid is made dense over the box of its active voxels and one layer of voxels around it; the values
//! there are those of the file, active or not. With that layer, mostly of the background, values between voxels and
//! beyond the box equal OpenVDB's. Not supported are grids of integers, masks, points and level sets, frustums, files
//! that were written as streams, and Blosc with other packers than LZ4, which OpenVDB does not use.

mod blosc;
mod bytes;
mod header;
#[cfg(test)]
mod tests;
mod tree;
mod values;

use glam::{Affine3A, DAffine3, DMat4, I64Vec3, IVec3};
use half::f16;
use thiserror::Error;

use self::bytes::Bytes;
use self::header::{Entry, NEWEST, OLDEST, read_entries, read_grid_header};
use self::tree::{Dense, Extent, visit_nodes};
use self::values::{Component, Form, Number, ValueReader};
use super::{GridError, VolumeGrid};
use crate::memory::{self, Shortage};

/// The grid that is read if there are several and no name is given.
const USUAL_NAME: &str = "density";

/// The most names that an error lists.
const MOST_LISTED: usize = 20;

/// The reason why a grid of a .vdb file cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum VdbError {
    /// The file does not start as a .vdb file.
    #[error("this is not a .vdb file")]
    NotVdb,
    /// The version of the file is not supported.
    #[error("the .vdb file has version {0}: versions {OLDEST} to {NEWEST} can be read")]
    Version(u32),
    /// The table of grids is missing.
    #[error("the .vdb file was written as a stream, without a table of its grids: write it as a file")]
    Stream,
    /// The file is shorter than it should be.
    #[error("the .vdb file ends too early, after {0} bytes")]
    Truncated(u64),
    /// The content differs from the expected one.
    #[error("the .vdb file is damaged: expected {expected} before byte {at}")]
    Damaged {
        /// The position, in bytes from the start of the file.
        at: u64,
        /// The expected content.
        expected: &'static str,
    },
    /// A grid is packed by an unsupported method.
    #[error("the grid is compressed in an unknown way ({0:#x}): zip and blosc can be read")]
    Compression(u32),
    /// There is no grid at all.
    #[error("the .vdb file has no grids")]
    NoGrids,
    /// There is no grid of this name.
    #[error("the .vdb file has no grid `{name}`, only {}", listed(.names))]
    UnknownGrid {
        /// The requested name.
        name: String,
        /// The names of all grids.
        names: Vec<String>,
    },
    /// There are several grids, and none of them was named.
    #[error("the .vdb file has several grids: name one of {}", listed(.0))]
    ManyGrids(Vec<String>),
    /// The grid's values are of an unsupported type.
    #[error("the grid `{name}` is a `{tree}`, which cannot be read: numbers and vectors of three numbers can")]
    Type {
        /// The name of the grid.
        name: String,
        /// The type of its tree, as the file names it.
        tree: String,
    },
    /// The grid stores distances to a surface.
    #[error("the grid `{0}` is a level set, not a volume: convert it to a fog volume")]
    LevelSet(String),
    /// The grid's map to the world is not affine or not invertible.
    #[error("the grid `{name}` has a {map}: only maps that are affine and can be inverted are read")]
    Map {
        /// The name of the grid.
        name: String,
        /// The type of the map, as the file names it.
        map: String,
    },
    /// The grid has no active voxels.
    #[error("the grid `{0}` is empty")]
    Empty(String),
    /// The box of active voxels has too many voxels.
    #[error(
        "the grid `{name}` has {} x {} x {} voxels, which take {bytes} bytes: at most {limit} are allowed",
        .size.x, .size.y, .size.z
    )]
    TooLarge {
        /// The name of the grid.
        name: String,
        /// The number of voxels along each axis.
        size: I64Vec3,
        /// The bytes of memory that their values would take.
        bytes: u128,
        /// The most bytes that are allowed.
        limit: u64,
    },
    /// The memory budget has no room for the voxels.
    #[error("the grid `{name}` has {} x {} x {} voxels, which need {shortage}", .size.x, .size.y, .size.z)]
    Memory {
        /// The name of the grid.
        name: String,
        /// The number of voxels along each axis.
        size: I64Vec3,
        /// The missing memory.
        shortage: Shortage,
    },
    /// The voxels do not make up a valid grid.
    #[error(transparent)]
    Grid(#[from] GridError),
}

/// Names as a list in a sentence.
fn listed(names: &[String]) -> String {
    let shown: Vec<String> = names.iter().take(MOST_LISTED).map(|name| format!("`{name}`")).collect();
    let more = if names.len() > MOST_LISTED { ", and others" } else { "" };
    shown.join(", ") + more
}

/// A grid read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct VdbVolume {
    /// The voxels in the box of active ones, and one layer around it. Values are in half precision if the file's are,
    /// otherwise in single precision.
    pub grid: VolumeGrid,
    /// World from local space, in which the grid fills the unit cube, [0, 1]^3; invertible. The world has the units and
    /// axes of the file.
    pub world_from_local: Affine3A,
}

/// A .vdb file after its table of grids has been read.
pub struct VdbFile<'a> {
    bytes: &'a [u8],
    entries: Vec<Entry>,
}

impl<'a> VdbFile<'a> {
    /// Reads the table of grids.
    pub fn open(bytes: &'a [u8]) -> Result<Self, VdbError> {
        let entries = read_entries(&mut Bytes::new(bytes))?;
        Ok(Self { bytes, entries })
    }

    /// The names of all grids, as in the file. Where grids share a name, each has a number, as in `density[1]`.
    pub fn names(&self) -> Vec<String> {
        self.entries.iter().map(|entry| entry.name.clone()).collect()
    }

    /// Reads the grid with this name; without a name, the grid `density`, or else the only one. Its voxels may take up
    /// to `limit` bytes, and no more than the memory budget has left.
    pub fn read(&self, name: Option<&str>, limit: u64) -> Result<VdbVolume, VdbError> {
        let entry = self.choose(name)?;
        let damaged = VdbError::Damaged {
            at: entry.at,
            expected: "the grid whose tree this one shares",
        };
        let with_tree = entry.with_tree(&self.entries).ok_or(damaged)?;
        let source = Source {
            entry,
            bytes: self.bytes,
            limit,
        };
        let (channels, single) = match with_tree.tree.as_str() {
            "Tree_float_5_4_3" => (1, Number::Single),
            "Tree_double_5_4_3" => (1, Number::Double),
            "Tree_half_5_4_3" => (1, Number::Half),
            "Tree_vec3s_5_4_3" => (3, Number::Single),
            "Tree_vec3d_5_4_3" => (3, Number::Double),
            other => {
                return Err(VdbError::Type {
                    name: entry.name.clone(),
                    tree: other.to_owned(),
                });
            }
        };
        source.read(with_tree, channels, single)
    }

    fn choose(&self, name: Option<&str>) -> Result<&Entry, VdbError> {
        let named = |name: &str| self.entries.iter().find(|entry| entry.name == name);
        match (name, &self.entries[..]) {
            (_, []) => Err(VdbError::NoGrids),
            (Some(name), _) => named(name).ok_or_else(|| VdbError::UnknownGrid {
                name: name.to_owned(),
                names: self.names(),
            }),
            (None, [only]) => Ok(only),
            (None, _) => named(USUAL_NAME).ok_or_else(|| VdbError::ManyGrids(self.names())),
        }
    }
}

/// The grid to be read.
struct Source<'a> {
    entry: &'a Entry,
    bytes: &'a [u8],
    limit: u64,
}

impl<'a> Source<'a> {
    /// Reads the grid, whose tree is stored with `with_tree`, most often the grid itself.
    fn read(&self, with_tree: &Entry, channels: usize, single: Number) -> Result<VdbVolume, VdbError> {
        let mut bytes = Bytes::new(self.bytes);
        bytes.seek(self.entry.at)?;
        let map = read_grid_header(&mut bytes)?.world_from_index;
        let world_from_index = map.map_err(|map| self.map_error(&map))?;
        bytes.seek(with_tree.at)?;
        let header = read_grid_header(&mut bytes)?;
        if header.is_level_set {
            return Err(VdbError::LevelSet(self.entry.name.clone()));
        }
        // After a map of unknown length the position of the tree is unknown.
        header.world_from_index.map_err(|map| self.map_error(&map))?;
        if bytes.u32()? != 1 {
            return Err(bytes.damaged("one buffer of values"));
        }
        let form = Form {
            single,
            is_reduced: (with_tree.is_half || header.is_half) && single != Number::Half,
        };
        let compression = header.compression;
        let (grid, first) = match (channels, form.in_arrays()) {
            (1, Number::Half) => self.fill(ValueReader::<f16, 1>::new(bytes, form, compression)?)?,
            (1, _) => self.fill(ValueReader::<f32, 1>::new(bytes, form, compression)?)?,
            (_, Number::Half) => self.fill(ValueReader::<f16, 3>::new(bytes, form, compression)?)?,
            _ => self.fill(ValueReader::<f32, 3>::new(bytes, form, compression)?)?,
        };
        // In index space the centres of voxels are at integers, half a voxel from the faces of the local unit cube.
        let index_from_local =
            DAffine3::from_translation(first.as_dvec3() - 0.5) * DAffine3::from_scale(grid.resolution().as_dvec3());
        let world_from_local = DMat4::from(world_from_index * index_from_local).as_mat4();
        let world_from_local = Affine3A::from_mat4(world_from_local);
        match world_from_local.inverse().is_finite() {
            true => Ok(VdbVolume { grid, world_from_local }),
            false => Err(self.map_error("map that cannot be inverted")),
        }
    }

    /// Reads the tree, which is next in the file: the voxels in the box of active ones and around it, and the first of
    /// them in index space.
    fn fill<T: Component, const C: usize>(
        &self,
        mut reader: ValueReader<'a, T, C>,
    ) -> Result<(VolumeGrid, IVec3), VdbError> {
        let root = reader.bytes.clone();
        let mut extent = Extent::default();
        visit_nodes(&mut reader, &mut extent)?;
        let name = &self.entry.name;
        let (first, size) = extent.bordered_box().ok_or_else(|| VdbError::Empty(name.clone()))?;
        let voxels = size.to_array().iter().map(|along| *along as u128).product::<u128>();
        let bytes = voxels * size_of::<[T; C]>() as u128;
        if bytes > u128::from(self.limit) {
            return Err(VdbError::TooLarge {
                name: name.clone(),
                size,
                bytes,
                limit: self.limit,
            });
        }
        let reserved = memory::reserve(bytes as u64).map_err(|shortage| VdbError::Memory {
            name: name.clone(),
            size,
            shortage,
        })?;
        let size = size.as_uvec3();
        let mut dense = Dense::new(first, size, reader.background);
        reader.bytes = root;
        visit_nodes(&mut reader, &mut dense)?;
        dense.fill_leaves(&extent, &mut reader)?;
        let voxels = T::voxels(dense.voxels.into_flattened());
        Ok((VolumeGrid::new(size, C as u32, voxels)?.holding(reserved), first))
    }

    fn map_error(&self, map: &str) -> VdbError {
        VdbError::Map {
            name: self.entry.name.clone(),
            map: map.to_owned(),
        }
    }
}
