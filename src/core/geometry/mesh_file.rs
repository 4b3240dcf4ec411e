//! The result of every mesh file reader: the mesh with its warnings, or one error with its place.

use std::fmt;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::attribute::AttributeValues;
use super::mesh::MeshData;
use super::vertex_normals::{angle_weighted_normals, unit};
use crate::color::BRIGHTEST;
use crate::memory::{self, Reservation, Shortage};

/// A mesh that was read, and what was left out or repaired, one sentence each.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedMesh {
    /// The complete mesh, with normals.
    pub mesh: MeshData,
    /// The warnings, limited in number for any file; equal ones are counted, not repeated.
    pub warnings: Vec<String>,
}

impl LoadedMesh {
    /// The mesh with warnings that quote no text of the file.
    pub fn without_quotes(mut self) -> Self {
        for warning in &mut self.warnings {
            // Quoted text may contain the quotation mark itself.
            if let (Some(start), Some(end)) = (warning.find('`'), warning.rfind('`')) {
                warning.replace_range(start..=end, "…");
            }
        }
        self
    }
}

/// A place in a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The 1-based line of a text file, or of a binary file's text header.
    Line(u64),
    /// The 0-based offset into a binary file.
    Byte(u64),
    /// The 0-based offset into the unpacked content of a compressed file.
    Unpacked(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(offset) => write!(f, "byte {offset}"),
            Self::Unpacked(offset) => write!(f, "byte {offset} of the unpacked shape"),
        }
    }
}

/// The reason why a mesh file could not be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum MeshError {
    #[error("{place}: expected {expected}, found {found}")]
    Syntax {
        place: Place,
        expected: String,
        /// The offending text, quoted and shortened, or a description such as "the end of the line".
        found: String,
    },
    /// An index out of range. `index` is as written in the file (OBJ counts from 1, or backwards from -1).
    #[error("{place}: {what} index {index} is out of range: the file has {count}")]
    IndexOutOfRange {
        place: Place,
        /// "vertex", "texture coordinate", "normal" or "shape".
        what: &'static str,
        index: i64,
        count: u64,
    },
    #[error("{place}: a vertex position is not finite")]
    NotFinite { place: Place },
    #[error("{place}: the file ends early: {promised}")]
    Truncated { place: Place, promised: String },
    #[error("the file holds no triangles")]
    NoTriangles,
    #[error("{what} is beyond what this program reads ({limit})")]
    TooLarge { what: &'static str, limit: u64 },
    /// The memory budget has no room. `what` is a plural noun with its number.
    #[error("{what} need {shortage}")]
    Memory { what: String, shortage: Shortage },
}

/// The memory that a reader reserves while it reads a mesh.
pub(super) struct MeshMemory {
    reservation: Reservation,
}

impl MeshMemory {
    /// Reserves bytes. `what` says what they hold: a plural noun with its number.
    pub fn reserve(bytes: u64, what: impl FnOnce() -> String) -> Result<Self, MeshError> {
        match memory::reserve(bytes) {
            Ok(reservation) => Ok(Self { reservation }),
            Err(shortage) => Err(MeshError::Memory { what: what(), shortage }),
        }
    }

    /// Reserves `bytes` more.
    pub fn add(&mut self, bytes: u64, what: impl FnOnce() -> String) -> Result<(), MeshError> {
        let sum = self.reservation.bytes().saturating_add(bytes);
        let resized = self.reservation.resize(sum);
        resized.map_err(|shortage| MeshError::Memory { what: what(), shortage })
    }

    /// The mesh, which now holds the reservation for itself and its acceleration structure.
    pub fn hold(mut self, mut mesh: MeshData) -> Result<MeshData, MeshError> {
        let resized = self.reservation.resize(mesh.memory_bytes());
        resized.map_err(|shortage| MeshError::Memory {
            what: match mesh.strands.points.len() {
                0 => format!("{} triangles", mesh.triangles.len()),
                points => format!("{points} control points of curves"),
            },
            shortage,
        })?;
        mesh.memory = self.reservation.into();
        Ok(mesh)
    }
}

impl MeshError {
    /// The error without text of the file.
    pub fn without_quotes(self) -> Self {
        match self {
            Self::Syntax { place, expected, .. } => Self::syntax(place, expected, "something else"),
            other => other,
        }
    }

    pub(super) fn syntax(place: Place, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self::Syntax {
            place,
            expected: expected.into(),
            found: found.into(),
        }
    }
}

/// An excerpt of `bytes` in quotes for a message: one line, at most 40 characters.
pub(super) fn excerpt(bytes: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = decode(&bytes[..bytes.len().min(4 * LONGEST)]);
    let mut short: String = text
        .trim()
        .chars()
        .take(LONGEST)
        .map(|c| if c.is_control() { '\u{fffd}' } else { c })
        .collect();
    if text.trim().chars().count() > LONGEST {
        short.push('…');
    }
    if short.is_empty() {
        "nothing".into()
    } else {
        format!("`{short}`")
    }
}

/// Decodes text of unknown encoding: UTF-8 if it is valid, otherwise Latin-1, which every byte string is.
pub(super) fn decode(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.into(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect::<String>().into(),
    }
}

/// Collects warnings: equal ones are counted under the place of the first, and the different ones are limited in
/// number.
#[derive(Default)]
pub(crate) struct Warnings {
    kinds: Vec<Kind>,
    left_out: u64,
}

struct Kind {
    place: String,
    message: String,
    count: u64,
}

impl Warnings {
    const MOST_KINDS: usize = 32;

    pub fn add(&mut self, place: impl fmt::Display, message: &str) {
        match self.known(message) {
            Some(known) => known.count += 1,
            None => self.add_kind(Kind {
                place: place.to_string(),
                message: message.to_owned(),
                count: 1,
            }),
        }
    }

    /// Adds the warnings of a later part.
    pub fn append(&mut self, after: Self) {
        for kind in after.kinds {
            match self.known(&kind.message) {
                Some(known) => known.count += kind.count,
                None => self.add_kind(kind),
            }
        }
        self.left_out += after.left_out;
    }

    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    fn known(&mut self, message: &str) -> Option<&mut Kind> {
        self.kinds.iter_mut().find(|kind| kind.message == message)
    }

    fn add_kind(&mut self, kind: Kind) {
        if self.kinds.len() < Self::MOST_KINDS {
            self.kinds.push(kind);
        } else {
            self.left_out += kind.count;
        }
    }

    pub fn finish(self) -> Vec<String> {
        let mut sentences: Vec<String> = self
            .kinds
            .into_iter()
            .map(|Kind { place, message, count }| match count {
                1 => format!("{place}: {message}"),
                _ => format!("{place}: {message} (and {} times more)", count - 1),
            })
            .collect();
        if self.left_out > 0 {
            sentences.push(format!("{} further warnings", self.left_out));
        }
        sentences
    }
}

/// Replaces texture coordinates and attribute values that are not finite by zero, and limits attribute values, which
/// may be light; with warnings.
pub(crate) fn replace_not_finite(mesh: &mut MeshData, warnings: &mut Warnings) {
    for uv in mesh.uvs.iter_mut().filter(|uv| !uv.is_finite()) {
        *uv = Vec2::ZERO;
        warnings.add("texture coordinates", "a pair that is not finite counts as 0 0");
    }
    for attribute in &mut mesh.attributes {
        if let AttributeValues::F32(values) = &mut attribute.values {
            let is_good = |value: &f32| value.abs() <= BRIGHTEST;
            for value in values.iter_mut().filter(|value| !is_good(value)) {
                let name = &attribute.name;
                let what = if value.is_finite() {
                    *value = BRIGHTEST.copysign(*value);
                    format!("a number of `{name}` is beyond {BRIGHTEST:e}, and counts as that")
                } else {
                    *value = 0.0;
                    format!("a number of `{name}` that is not finite counts as 0")
                };
                warnings.add("attributes", &what);
            }
        }
    }
}

/// Computes all normals if the file has none. Otherwise normalises them, and computes those that are zero or not
/// finite.
pub(crate) fn complete_normals(mesh: &mut MeshData, warnings: &mut Warnings) {
    if mesh.normals.is_empty() {
        mesh.normals = angle_weighted_normals(&mesh.positions, &mesh.triangles);
        mesh.has_computed_normals = true;
        return;
    }
    mesh.normals
        .par_iter_mut()
        .for_each(|normal| *normal = unit(*normal).unwrap_or(Vec3::NAN));
    if !mesh.normals.iter().any(|normal| normal.is_nan()) {
        return;
    }
    let computed = angle_weighted_normals(&mesh.positions, &mesh.triangles);
    for (normal, computed) in mesh
        .normals
        .iter_mut()
        .zip(computed)
        .filter(|(normal, _)| normal.is_nan())
    {
        *normal = computed;
        warnings.add(
            "normals",
            "a normal that is zero or not finite is computed from the triangles instead",
        );
    }
}
