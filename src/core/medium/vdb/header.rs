//! The header of a .vdb file with its table of grids, and the headers of grids with their compression and transform.

use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::VdbError;
use super::bytes::Bytes;

/// The first eight bytes.
const MAGIC: u64 = 0x5644_4220;

/// The first version with masks of inactive values and a compression per grid: OpenVDB 1.2 of 2013.
pub(super) const OLDEST: u32 = 222;
/// The newest version that can be read.
pub(super) const NEWEST: u32 = 224;

/// The length of the identifier of a file.
const IDENTIFIER: usize = 36;

/// Separates a name from the number that makes it unique.
const SEPARATOR: char = '\u{1e}';
/// The suffix of the types of grids that are stored in half precision.
const HALF_SUFFIX: &str = "_HalfFloat";

/// The entry of a grid in the table of a file.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    /// The name in the file, which no other grid has.
    unique_name: String,
    /// The name that users see.
    pub(super) name: String,
    /// The type of the tree, such as `Tree_float_5_4_3`.
    pub(super) tree: String,
    /// Whether the type says that numbers are stored in half precision.
    pub(super) is_half: bool,
    /// The unique name of the grid whose tree this one uses; empty if it has its own.
    parent: String,
    /// The position of the grid in the file.
    pub(super) at: u64,
}

impl Entry {
    /// The entry whose tree this grid uses.
    pub(super) fn with_tree<'e>(&'e self, all: &'e [Self]) -> Option<&'e Self> {
        match self.parent.is_empty() {
            true => Some(self),
            // A grid that uses another's tree has none of its own, so there are no chains.
            false => all
                .iter()
                .find(|entry| entry.unique_name == self.parent && entry.parent.is_empty()),
        }
    }
}

/// Reads the header of a file and the table of its grids.
pub(super) fn read_entries(bytes: &mut Bytes) -> Result<Vec<Entry>, VdbError> {
    if bytes.u64() != Ok(MAGIC) {
        return Err(VdbError::NotVdb);
    }
    let version = bytes.u32()?;
    if !(OLDEST..=NEWEST).contains(&version) {
        return Err(VdbError::Version(version));
    }
    let _library_version = [bytes.u32()?, bytes.u32()?];
    if bytes.u8()? == 0 {
        return Err(VdbError::Stream);
    }
    bytes.take(IDENTIFIER)?;
    read_metadata(bytes)?;
    let count = bytes.u32()?;
    let mut entries = Vec::new();
    for _ in 0..count {
        let unique_name = bytes.string()?;
        let tree = bytes.string()?;
        let parent = bytes.string()?;
        let [at, _, end] = [bytes.u64()?, bytes.u64()?, bytes.u64()?];
        // Each grid follows its entry.
        if at < bytes.at() || end < at {
            return Err(bytes.damaged("the place of a grid"));
        }
        bytes.seek(end)?;
        entries.push(Entry {
            name: shown_name(&unique_name),
            is_half: tree.ends_with(HALF_SUFFIX),
            tree: tree.trim_end_matches(HALF_SUFFIX).to_owned(),
            unique_name,
            parent,
            at,
        });
    }
    Ok(entries)
}

/// The name as OpenVDB shows it, such as `density[1]` for the second grid of the name `density`.
fn shown_name(unique_name: &str) -> String {
    match unique_name.split_once(SEPARATOR) {
        Some((name, number)) => format!("{name}[{number}]"),
        None => unique_name.to_owned(),
    }
}

/// The compression of arrays of values.
#[derive(Clone, Copy, Debug)]
pub(super) struct Compression {
    pub(super) is_zip: bool,
    pub(super) is_blosc: bool,
    /// Arrays hold active values only.
    pub(super) is_masked: bool,
}

/// The header of a grid, before its tree.
pub(super) struct GridHeader {
    pub(super) compression: Compression,
    pub(super) is_half: bool,
    pub(super) is_level_set: bool,
    /// World from index space, where voxels have their centres at integers; or the type of a map that is not affine.
    pub(super) world_from_index: Result<DAffine3, String>,
}

/// Reads the header of a grid.
pub(super) fn read_grid_header(bytes: &mut Bytes) -> Result<GridHeader, VdbError> {
    let flags = bytes.u32()?;
    if flags & !0x7 != 0 {
        return Err(VdbError::Compression(flags));
    }
    let metadata = read_metadata(bytes)?;
    Ok(GridHeader {
        compression: Compression {
            is_zip: flags & 0x1 != 0,
            is_masked: flags & 0x2 != 0,
            is_blosc: flags & 0x4 != 0,
        },
        is_half: metadata.is_half,
        is_level_set: metadata.is_level_set,
        world_from_index: read_map(bytes)?,
    })
}

/// The metadata that are used.
#[derive(Default)]
struct Metadata {
    is_half: bool,
    is_level_set: bool,
}

fn read_metadata(bytes: &mut Bytes) -> Result<Metadata, VdbError> {
    let mut found = Metadata::default();
    for _ in 0..bytes.u32()? {
        let [name, kind, value] = [bytes.sized()?, bytes.sized()?, bytes.sized()?];
        match (name, kind) {
            (b"is_saved_as_half_float", b"bool") => found.is_half = value == [1],
            (b"class", b"string") => found.is_level_set = value == b"level set",
            _ => {}
        }
    }
    Ok(found)
}

/// World from index space. The type of a map that is not affine ends the reading: the map's length is unknown.
fn read_map(bytes: &mut Bytes) -> Result<Result<DAffine3, String>, VdbError> {
    let vector = |bytes: &mut Bytes| Ok::<_, VdbError>(DVec3::new(bytes.f64()?, bytes.f64()?, bytes.f64()?));
    let kind = bytes.string()?;
    let has_scale = kind.contains("Scale");
    let (scale, translation) = match kind.as_str() {
        "UniformScaleMap" | "ScaleMap" => (vector(bytes)?, DVec3::ZERO),
        "UniformScaleTranslateMap" | "ScaleTranslateMap" => {
            let translation = vector(bytes)?;
            (vector(bytes)?, translation)
        }
        "TranslationMap" => (DVec3::ONE, vector(bytes)?),
        "AffineMap" | "UnitaryMap" => {
            // The file multiplies rows by matrices from the right, so its rows are columns here.
            let mut columns = [0.0; 16];
            for number in &mut columns {
                *number = bytes.f64()?;
            }
            return Ok(Ok(DAffine3::from_mat4(DMat4::from_cols_array(&columns))));
        }
        _ => return Ok(Err(kind)),
    };
    if has_scale {
        // The size of a voxel, and three more vectors that follow from the scale.
        for _ in 0..4 {
            vector(bytes)?;
        }
    }
    Ok(Ok(DAffine3::from_scale_rotation_translation(
        scale,
        DQuat::IDENTITY,
        translation,
    )))
}
