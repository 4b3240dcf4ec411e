//! Parses the statements of a chunk of an OBJ file.
//!
//! A chunk depends little on those before it: only for its line numbers and for the meaning of indices that count
//! backwards. So chunks are parsed in parallel, and those with such indices once more when the counts before them are
//! known: see [`Part::follow`].

use std::collections::HashMap;

use glam::{Vec2, Vec3};

use super::decimal::{leading_f32, leading_u32, longest_number};
use super::mesh_file::{MeshError, Place, Warnings, decode, excerpt};
use super::obj_lines::{Lines, Words};

/// Stands for an index that a corner lacks, and for "no material yet".
pub const NONE: u32 = u32::MAX;

/// Zero-based indices into the file's positions, uvs and normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Corner {
    pub position: u32,
    pub uv: u32,
    pub normal: u32,
}

pub struct Face {
    pub first_corner: u32,
    pub corner_count: u32,
    /// Index into the material names of this part, or [`NONE`] before the first of them.
    pub material: u32,
    /// The line within the part, from 1.
    pub line: u32,
}

/// The numbers of position, uv and normal statements in a text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    pub lines: u32,
    pub positions: usize,
    pub uvs: usize,
    pub normals: usize,
}

impl std::ops::Add for Counts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            lines: self.lines + other.lines,
            positions: self.positions + other.positions,
            uvs: self.uvs + other.uvs,
            normals: self.normals + other.normals,
        }
    }
}

#[derive(Default)]
pub struct Part {
    /// The counts in the file before this part; zero if not known yet.
    before: Counts,
    knows_before: bool,
    /// The number of lines read, up to an error.
    pub lines: u32,
    pub positions: Vec<Vec3>,
    /// The colours of the positions up to the last coloured one; white where a colour is missing.
    pub colors: Vec<Vec3>,
    /// The number of positions with a colour.
    pub colored: usize,
    pub uvs: Vec<Vec2>,
    pub normals: Vec<Vec3>,
    pub corners: Vec<Corner>,
    pub faces: Vec<Face>,
    pub used_names: Vec<String>,
    /// The index of the current material name, or [`NONE`].
    pub material: u32,
    /// The lines and arguments of `mtllib`, counted from the first line of the file.
    pub libraries: Vec<(u32, String)>,
    pub warnings: Warnings,
    /// The first error, at which parsing stops.
    pub error: Option<MeshError>,
    /// Whether the part has indices that count backwards across its start.
    counts_backwards: bool,
}

impl Part {
    /// Parses a part. `before` holds the counts in the file before `text`, if they are known.
    pub fn read(text: &[u8], before: Option<Counts>) -> Self {
        let mut part = Self {
            before: before.unwrap_or_default(),
            knows_before: before.is_some(),
            material: NONE,
            ..Self::default()
        };
        let mut index_of_name = HashMap::new();
        let mut lines = Lines::new(text);
        for (line, statement) in lines.by_ref() {
            if let Err(error) = part.read_statement(&statement, line, &mut index_of_name) {
                part.error = Some(error);
                break;
            }
        }
        part.lines = lines.taken();
        part
    }

    pub fn counts(&self) -> Counts {
        Counts {
            lines: self.lines,
            positions: self.positions.len(),
            uvs: self.uvs.len(),
            normals: self.normals.len(),
        }
    }

    /// Completes the part when the counts `before` it are known; `text` is the text of the part.
    pub fn follow(&mut self, before: Counts, text: &[u8]) {
        let matters =
            self.counts_backwards || self.error.is_some() || !self.warnings.is_empty() || !self.libraries.is_empty();
        if matters && !self.knows_before {
            *self = Self::read(text, Some(before));
        }
        self.before = before;
    }

    pub fn corners_of(&self, face: &Face) -> &[Corner] {
        &self.corners[face.first_corner as usize..][..face.corner_count as usize]
    }

    /// The line of a face in the file.
    pub fn place_of(&self, face: &Face) -> Place {
        Place::Line((self.before.lines + face.line).into())
    }

    fn read_statement(
        &mut self,
        text: &[u8],
        line: u32,
        index_of_name: &mut HashMap<String, u32>,
    ) -> Result<(), MeshError> {
        let place = Place::Line((self.before.lines + line).into());
        let mut words = Words::new(text);
        let Some(keyword) = words.next() else {
            return Ok(());
        };
        match keyword {
            b"v" => {
                let position = Vec3::from(self.numbers(&mut words, place, text, "three coordinates")?);
                if !position.is_finite() {
                    return Err(MeshError::NotFinite { place });
                }
                if let Some(color) = color_of_vertex(&mut words) {
                    self.colors.resize(self.positions.len(), Vec3::ONE);
                    self.colors.push(color);
                    self.colored += 1;
                }
                self.positions.push(position);
            }
            b"vn" => {
                let normal: [f32; 3] = self.numbers(&mut words, place, text, "three components of a normal")?;
                self.normals.push(normal.into());
            }
            b"vt" => {
                let uv = self.texture_coordinate(&mut words, place, text)?;
                self.uvs.push(uv);
            }
            b"f" | b"fo" => self.add_face(&mut words, line, place)?,
            b"usemtl" => {
                let name = decode(argument(text, keyword));
                self.material = match index_of_name.get(&*name) {
                    Some(&known) => known,
                    None => {
                        let new = self.used_names.len() as u32;
                        self.used_names.push(name.to_string());
                        index_of_name.insert(name.into_owned(), new);
                        new
                    }
                };
            }
            b"mtllib" => {
                let names = decode(argument(text, keyword)).replace('\\', "/");
                self.libraries.push((self.before.lines + line, names));
            }
            b"o" | b"g" | b"s" | b"mg" | b"l" | b"p" => {}
            _ => {
                let message = format!("the statement {} is ignored", excerpt(keyword));
                self.warnings.add(place, &message);
            }
        }
        Ok(())
    }

    #[inline]
    fn numbers<const N: usize>(
        &mut self,
        words: &mut Words,
        place: Place,
        line: &[u8],
        expected: &str,
    ) -> Result<[f32; N], MeshError> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = match words.next_if(leading_f32) {
                Some(number) => number,
                None => {
                    let word = words.next();
                    self.number(word, place)
                        .ok_or_else(|| MeshError::syntax(place, expected, excerpt(line)))?
                }
            };
        }
        Ok(numbers)
    }

    /// The number of a word or, with a warning, the number at its beginning, as tinyobjloader and Assimp read it.
    fn number(&mut self, word: Option<&[u8]>, place: Place) -> Option<f32> {
        let word = word?;
        let whole = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        whole.or_else(|| {
            let number = longest_number(word)?;
            let message = format!(
                "{} is no number: {number} is taken, with which it begins",
                excerpt(word)
            );
            self.warnings.add(place, &message);
            Some(number)
        })
    }

    /// Parses one to three numbers, of which two are used. A pair that is not finite becomes 0 0, with a warning.
    fn texture_coordinate(&mut self, words: &mut Words, place: Place, line: &[u8]) -> Result<Vec2, MeshError> {
        const EXPECTED: &str = "one to three texture coordinates";
        let [u] = self.numbers(words, place, line, EXPECTED)?;
        let v = match words.next_if(leading_f32) {
            Some(v) => v,
            None => match words.next() {
                None => 0.0,
                word => self
                    .number(word, place)
                    .ok_or_else(|| MeshError::syntax(place, EXPECTED, excerpt(line)))?,
            },
        };
        let uv = Vec2::new(u, v);
        if uv.is_finite() {
            return Ok(uv);
        }
        self.warnings
            .add(place, "texture coordinates that are not finite count as 0 0");
        Ok(Vec2::ZERO)
    }

    fn add_face(&mut self, words: &mut Words, line: u32, place: Place) -> Result<(), MeshError> {
        let first_corner = self.corners.len();
        loop {
            let corner = match words.next_if(plain_corner) {
                Some(corner) => corner,
                None => match words.next() {
                    Some(word) => self.corner(word, place)?,
                    None => break,
                },
            };
            self.corners.push(corner);
        }
        let corner_count = self.corners.len() - first_corner;
        if corner_count < 3 {
            self.corners.truncate(first_corner);
            self.warnings
                .add(place, "a face with fewer than three corners is skipped");
            return Ok(());
        }
        self.faces.push(Face {
            first_corner: first_corner as u32,
            corner_count: corner_count as u32,
            material: self.material,
            line,
        });
        Ok(())
    }

    fn corner(&mut self, word: &[u8], place: Place) -> Result<Corner, MeshError> {
        let mut indices = word.split(|&byte| byte == b'/');
        let mut next = |what: &'static str, before: usize, here: usize| match indices.next() {
            None | Some(b"") => Ok(NONE),
            Some([b'-', ..]) if !self.knows_before => {
                self.counts_backwards = true;
                Ok(0)
            }
            Some(text) => zero_based(text, what, before + here, place),
        };
        let corner = Corner {
            position: next("vertex", self.before.positions, self.positions.len())?,
            uv: next("texture coordinate", self.before.uvs, self.uvs.len())?,
            normal: next("normal", self.before.normals, self.normals.len())?,
        };
        if corner.position == NONE || indices.next().is_some() {
            let expected = "a corner such as 1, 1/2, 1//3 or 1/2/3";
            return Err(MeshError::syntax(place, expected, excerpt(word)));
        }
        Ok(corner)
    }
}

/// The colour after the coordinates of a vertex, as MeshLab and Blender write it: three numbers, and a fourth, alpha,
/// which is ignored. A single number is a weight of the vertex, which polygons do not have.
#[inline]
fn color_of_vertex(words: &mut Words) -> Option<Vec3> {
    let mut next = || {
        let plain = words.next_if(leading_f32);
        plain.or_else(|| std::str::from_utf8(words.next()?).ok()?.parse().ok())
    };
    let color = Vec3::new(next()?, next()?, next()?);
    color.is_finite().then_some(color)
}

/// The corner at the beginning of `text` and its length, if it is in the usual form: indices from 1 on.
#[inline]
fn plain_corner(text: &[u8]) -> Option<(Corner, usize)> {
    let mut indices = [NONE; 3];
    let mut end = 0;
    for (i, index) in indices.iter_mut().enumerate() {
        if i > 0 {
            match text.get(end) {
                Some(b'/') => end += 1,
                _ => break,
            }
        }
        if let Some((number, length)) = leading_u32(&text[end..]) {
            *index = number.checked_sub(1)?;
            end += length;
        }
    }
    let [position, uv, normal] = indices;
    let corner = Corner { position, uv, normal };
    (position != NONE).then_some((corner, end))
}

/// The text after the keyword, which may hold spaces.
fn argument<'a>(text: &'a [u8], keyword: &[u8]) -> &'a [u8] {
    text.trim_ascii_start()[keyword.len()..].trim_ascii()
}

/// Converts an index of the file, from 1 or backwards from -1 with `defined` so far, to an index from 0; not yet
/// checked against the whole file.
fn zero_based(text: &[u8], what: &'static str, defined: usize, place: Place) -> Result<u32, MeshError> {
    let index: i64 = std::str::from_utf8(text)
        .ok()
        .and_then(|text| text.parse().ok())
        .ok_or_else(|| MeshError::syntax(place, format!("the index of a {what}"), excerpt(text)))?;
    let from_zero = if index < 0 { defined as i64 + index } else { index - 1 };
    match u32::try_from(from_zero) {
        Ok(found) if found != NONE => Ok(found),
        _ => Err(MeshError::IndexOutOfRange {
            place,
            what,
            index,
            count: defined as u64,
        }),
    }
}
