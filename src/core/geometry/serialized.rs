//! Reads Mitsuba's `serialized` meshes: several shapes in one file, each a zlib stream (RFC 1950), versions 3 and 4.
//!
//! A shape holds flags, in version 4 a name, the counts, and then positions, normals, texture coordinates and colours
//! of all vertices in single or double precision, and the triangles. The colours are skipped, as in Mitsuba 3. A table
//! at the file's end gives the offset of each shape. Missing normals are computed.

use std::io::Read;

use flate2::bufread::ZlibDecoder;
use glam::{Vec2, Vec3};

use super::mesh::{HIERARCHY_BYTES, MeshData};
use super::mesh_file::{LoadedMesh, MeshError, MeshMemory, Place, Warnings, complete_normals, replace_not_finite};

const MAGIC: u16 = 0x041c;

/// Bytes of the magic number and version before every shape.
const HEADER: usize = 4;

const HAS_NORMALS: u32 = 0x1;
const HAS_TEXTURE_COORDINATES: u32 = 0x2;
const HAS_COLORS: u32 = 0x8;
const DOUBLE_PRECISION: u32 = 0x2000;

/// The highest compression ratio of deflate.
const MOST_PER_BYTE: u64 = 1032;

/// The longest name of a shape, in bytes.
const LONGEST_NAME: usize = 1 << 16;

/// Whether a file has the magic number of the format.
pub fn is_serialized(bytes: &[u8]) -> bool {
    bytes.starts_with(&MAGIC.to_le_bytes())
}

/// A file with the offsets of its shapes, in the order of the file's table.
pub struct SerializedFile<'a> {
    bytes: &'a [u8],
    version: u16,
    offsets: Vec<u64>,
}

impl<'a> SerializedFile<'a> {
    /// Reads the header and the table of shapes; the shapes themselves are read one by one.
    pub fn open(bytes: &'a [u8]) -> Result<Self, MeshError> {
        let word = |at: usize| bytes.get(at..at + 2).map(|two| u16::from_le_bytes([two[0], two[1]]));
        match (word(0), word(2)) {
            (Some(MAGIC), Some(version @ (3 | 4))) => Ok(Self {
                bytes,
                version,
                offsets: offsets(bytes, version)?,
            }),
            (Some(MAGIC), Some(other)) => Err(syntax(
                2,
                "a serialized mesh of version 3 or 4",
                format!("version {other}"),
            )),
            _ => Err(syntax(0, "a serialized mesh", "something else")),
        }
    }

    /// The number of shapes.
    pub fn count(&self) -> u32 {
        self.offsets.len() as u32
    }

    /// Reads one shape, the first being 0.
    pub fn load(&self, shape: u32) -> Result<LoadedMesh, MeshError> {
        let Some(&offset) = self.offsets.get(shape as usize) else {
            return Err(MeshError::IndexOutOfRange {
                place: Place::Byte(self.bytes.len() as u64),
                what: "shape",
                index: shape.into(),
                count: self.offsets.len() as u64,
            });
        };
        let packed = usize::try_from(offset)
            .ok()
            .and_then(|offset| self.bytes.get(offset.checked_add(HEADER)?..))
            .ok_or_else(|| syntax(self.bytes.len() as u64, "the place of a shape", format!("{offset}")))?;
        read_shape(Unpacked::new(packed), self.version)
    }
}

fn syntax(byte: u64, expected: &str, found: impl Into<String>) -> MeshError {
    MeshError::syntax(Place::Byte(byte), expected, found)
}

/// The table: the offsets of all shapes (4 bytes each in version 3, 8 in version 4), then their number.
fn offsets(bytes: &[u8], version: u16) -> Result<Vec<u64>, MeshError> {
    let end = bytes.len() as u64;
    let promised = || MeshError::Truncated {
        place: Place::Byte(end),
        promised: "a table of shapes belongs here".into(),
    };
    let (rest, count) = bytes[HEADER..].split_last_chunk().ok_or_else(promised)?;
    let count = u32::from_le_bytes(*count) as usize;
    let width = if version == 3 { 4 } else { 8 };
    let start = count.checked_mul(width).and_then(|table| rest.len().checked_sub(table));
    let table = &rest[start.ok_or_else(promised)?..];
    let offset = |entry: &[u8]| {
        let mut wide = [0; 8];
        wide[..width].copy_from_slice(entry);
        u64::from_le_bytes(wide)
    };
    let offsets: Vec<u64> = table.chunks_exact(width).map(offset).collect();
    // Otherwise a small file could contain one shape a million times.
    if !offsets.is_sorted_by(|before, after| before < after) {
        return Err(syntax(
            end,
            "shapes one after the other",
            "a table with places out of order",
        ));
    }
    Ok(offsets)
}

/// The content of one shape, decompressed while it is read.
struct Unpacked<'a> {
    decoder: ZlibDecoder<&'a [u8]>,
    read: u64,
    /// The largest number of bytes that can be left.
    most: u64,
}

impl<'a> Unpacked<'a> {
    fn new(packed: &'a [u8]) -> Self {
        Self {
            decoder: ZlibDecoder::new(packed),
            read: 0,
            most: MOST_PER_BYTE.saturating_mul(packed.len() as u64),
        }
    }

    /// Reads bytes. Memory grows only with bytes actually read.
    fn bytes(&mut self, count: u64) -> Result<Vec<u8>, MeshError> {
        let mut bytes = Vec::new();
        let result = self.decoder.by_ref().take(count).read_to_end(&mut bytes);
        self.read += bytes.len() as u64;
        match result {
            Err(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
                Err(MeshError::syntax(self.place(), "compressed data", error.to_string()))
            }
            Ok(_) if bytes.len() as u64 == count => Ok(bytes),
            _ => Err(MeshError::Truncated {
                place: self.place(),
                promised: "its counts promise more".into(),
            }),
        }
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], MeshError> {
        let mut array = [0; N];
        array.copy_from_slice(&self.bytes(N as u64)?);
        Ok(array)
    }

    /// The place of the next byte.
    fn place(&self) -> Place {
        Place::Unpacked(self.read)
    }

    /// Reads `count` points of `N` numbers each.
    fn points<const N: usize>(&mut self, count: u64, is_double: bool) -> Result<Vec<[f32; N]>, MeshError> {
        let width = if is_double { 8 } else { 4 };
        let bytes = self.bytes(count.saturating_mul((N * width) as u64))?;
        let number = |bytes: &[u8]| match *bytes {
            [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
            [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]) as f32,
            _ => f32::NAN,
        };
        let point = |bytes: &[u8]| std::array::from_fn(|i| number(&bytes[i * width..(i + 1) * width]));
        Ok(bytes.chunks_exact(N * width).map(point).collect())
    }
}

fn read_shape(mut source: Unpacked, version: u16) -> Result<LoadedMesh, MeshError> {
    let flags = u32::from_le_bytes(source.array()?);
    if version == 4 {
        skip_name(&mut source)?;
    }
    let vertices = u64::from_le_bytes(source.array()?);
    let triangles = u64::from_le_bytes(source.array()?);
    for (what, count) in [
        ("the number of vertices", vertices),
        ("the number of triangles", triangles),
    ] {
        if count > u64::from(u32::MAX) {
            return Err(MeshError::TooLarge {
                what,
                limit: u32::MAX.into(),
            });
        }
    }
    if triangles == 0 {
        return Err(MeshError::NoTriangles);
    }

    let is_double = flags & DOUBLE_PRECISION != 0;
    let memory = reserve(&source, flags, vertices, triangles)?;
    let mut mesh = MeshData::default();
    let place = source.place();
    mesh.positions = source
        .points(vertices, is_double)?
        .into_iter()
        .map(Vec3::from)
        .collect();
    if !mesh.positions.iter().all(|position| position.is_finite()) {
        return Err(MeshError::NotFinite { place });
    }
    if flags & HAS_NORMALS != 0 {
        mesh.normals = source
            .points(vertices, is_double)?
            .into_iter()
            .map(Vec3::from)
            .collect();
    }
    if flags & HAS_TEXTURE_COORDINATES != 0 {
        mesh.uvs = source
            .points(vertices, is_double)?
            .into_iter()
            .map(Vec2::from)
            .collect();
    }
    if flags & HAS_COLORS != 0 {
        source.points::<3>(vertices, is_double)?;
    }

    let first = source.read;
    let corners = source.bytes(triangles.saturating_mul(12))?;
    let corners = corners
        .as_chunks::<4>()
        .0
        .iter()
        .map(|&corner| u32::from_le_bytes(corner));
    let corners: Vec<u32> = corners.collect();
    if let Some(wrong) = corners.iter().position(|&corner| u64::from(corner) >= vertices) {
        return Err(MeshError::IndexOutOfRange {
            place: Place::Unpacked(first + 4 * wrong as u64),
            what: "vertex",
            index: corners[wrong].into(),
            count: vertices,
        });
    }
    mesh.triangles = corners.as_chunks::<3>().0.to_vec();

    let mut warnings = Warnings::default();
    replace_not_finite(&mut mesh, &mut warnings);
    complete_normals(&mut mesh, &mut warnings);
    Ok(LoadedMesh {
        mesh: memory.hold(mesh)?,
        warnings: warnings.finish(),
    })
}

fn skip_name(source: &mut Unpacked) -> Result<(), MeshError> {
    let place = source.place();
    for _ in 0..LONGEST_NAME {
        if source.array::<1>()? == [0] {
            return Ok(());
        }
    }
    let found = "a longer one";
    Err(MeshError::syntax(
        place,
        format!("a name of at most {LONGEST_NAME} bytes"),
        found,
    ))
}

/// Reserves memory for the declared counts, before any of it is decompressed.
fn reserve(source: &Unpacked, flags: u32, vertices: u64, triangles: u64) -> Result<MeshMemory, MeshError> {
    let width = if flags & DOUBLE_PRECISION != 0 { 8 } else { 4 };
    let numbers = |flag: u32, count: u64| if flags & flag != 0 { count } else { 0 };
    let per_vertex = 3 + numbers(HAS_NORMALS, 3) + numbers(HAS_TEXTURE_COORDINATES, 2) + numbers(HAS_COLORS, 3);
    // The counts are 32 bits wide, so nothing below overflows.
    let promised = vertices * per_vertex * width + triangles * 12;
    if promised > source.most {
        return Err(MeshError::Truncated {
            place: source.place(),
            promised: "its counts promise more than can be packed into it".into(),
        });
    }
    // Normals are always present in the finished mesh.
    let arrays = vertices * 4 * (6 + numbers(HAS_TEXTURE_COORDINATES, 2)) + triangles * 12;
    // One list of the file is in memory while it is converted; the acceleration structure comes later.
    let unpacked = (vertices * 3 * width).max(triangles * 12);
    let more = unpacked.max(triangles * HIERARCHY_BYTES);
    MeshMemory::reserve(arrays + more, || {
        format!("{vertices} vertices and {triangles} triangles")
    })
}
