//! Reads Wavefront OBJ meshes (Wavefront, "Advanced Visualizer" manual, appendix B1): the polygons, with their MTL materials.
//!
//! All objects and groups of a file become one mesh. Corners share a vertex where their indices of position, texture coordinate and
//! normal agree; polygons are cut as in [`super::polygon`]. Smoothing groups, points, lines, curves and vertex colours are ignored.
//!
//! Normals follow Mitsuba 3.9.1: where the file has none, they are computed over all triangles that share a vertex, whatever `s` says, so
//! a seam of the texture is a crease. Corners without a normal in a file that has some, and normals that are zero or not finite, get
//! the computed one. Texture coordinates stay as they are (Mitsuba flips v by default: [`MeshData::flip_tex_coords`]).
//!
//! This is a reader of its own rather than the `tobj` crate, which reads the MTL: that one knows no line numbers, cannot tell which corners
//! lack a normal, and starts a new mesh, with vertices of its own, at each object and material.

use std::collections::HashMap;
use std::io;

use glam::{Vec2, Vec3};

use super::mesh::{MeshData, MtlMaterial};
use super::mesh_file::{LoadedMesh, MeshError, Place, Warnings, decode, excerpt};
use super::mtl::{default_material, read_mtl};
use super::obj_lines::{Lines, words};
use super::polygon::triangulate;
use super::vertex_normals::unit;

/// Reads a whole OBJ file. `library` fetches the MTL files it names, relative to it, with `/` between folders; one that cannot be
/// had is a warning. Errors name the line.
pub fn load_obj(bytes: &[u8], library: &mut dyn FnMut(&str) -> io::Result<Vec<u8>>) -> Result<LoadedMesh, MeshError> {
    // Every statement takes two bytes, so all counts below fit 32 bits.
    if bytes.len() > u32::MAX as usize {
        return Err(MeshError::TooLarge {
            what: "the size of the file in bytes",
            limit: u32::MAX.into(),
        });
    }
    let mut warnings = Warnings::default();
    let statements = Statements::read(bytes, library, &mut warnings)?;
    statements.check_indices()?;
    let mut mesh = statements.build(&mut warnings);
    if mesh.triangles.is_empty() {
        return Err(MeshError::NoTriangles);
    }
    statements.assign_materials(&mut mesh, &mut warnings)?;
    Ok(LoadedMesh {
        mesh,
        warnings: warnings.finish(),
    })
}

/// Stands for an index that a corner does not give, and for "no material yet".
const NONE: u32 = u32::MAX;
/// More libraries than any real file names, few enough to look for.
const MOST_LIBRARIES: usize = 64;

/// Indices from 0 into the file's positions, uvs and normals.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Corner {
    position: u32,
    uv: u32,
    normal: u32,
}

struct Face {
    first_corner: u32,
    corner_count: u32,
    /// Index into the used names.
    material: u32,
    line: u32,
}

/// The file's statements as they stand.
#[derive(Default)]
struct Statements {
    positions: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    corners: Vec<Corner>,
    faces: Vec<Face>,
    used_names: Vec<String>,
    materials: Vec<MtlMaterial>,
}

impl Statements {
    fn read(
        bytes: &[u8],
        library: &mut dyn FnMut(&str) -> io::Result<Vec<u8>>,
        warnings: &mut Warnings,
    ) -> Result<Self, MeshError> {
        let mut read = Self::default();
        let mut index_of_name: HashMap<String, u32> = HashMap::new();
        let mut material = NONE;
        let mut libraries: Vec<String> = Vec::new();
        for (line, text) in Lines::new(bytes) {
            let place = Place::Line(line.into());
            let mut rest = words(&text);
            let Some(keyword) = rest.next() else { continue };
            match keyword {
                b"v" => {
                    let position = Vec3::from(numbers(rest, place, &text, "three coordinates")?);
                    if !position.is_finite() {
                        return Err(MeshError::NotFinite { place });
                    }
                    read.positions.push(position);
                }
                b"vn" => read
                    .normals
                    .push(numbers(rest, place, &text, "three components of a normal")?.into()),
                b"vt" => read.uvs.push(texture_coordinate(rest, place, &text)?),
                b"f" | b"fo" => read.add_face(rest, line, material, warnings)?,
                b"usemtl" => {
                    let name = decode(argument(&text, keyword));
                    material = match index_of_name.get(&*name) {
                        Some(&known) => known,
                        None => {
                            let new = read.used_names.len() as u32;
                            read.used_names.push(name.to_string());
                            index_of_name.insert(name.into_owned(), new);
                            new
                        }
                    };
                }
                b"mtllib" => {
                    let names = decode(argument(&text, keyword)).replace('\\', "/");
                    if libraries.contains(&names) {
                        continue;
                    }
                    if libraries.len() == MOST_LIBRARIES {
                        warnings.add(place, "further material libraries are ignored");
                        continue;
                    }
                    read.add_libraries(&names, place, library, warnings);
                    libraries.push(names);
                }
                b"o" | b"g" | b"s" | b"mg" | b"l" | b"p" => {}
                _ => warnings.add(place, &format!("the statement {} is ignored", excerpt(keyword))),
            }
        }
        Ok(read)
    }

    fn add_face<'a>(
        &mut self,
        words: impl Iterator<Item = &'a [u8]>,
        line: u32,
        material: u32,
        warnings: &mut Warnings,
    ) -> Result<(), MeshError> {
        let place = Place::Line(line.into());
        let first_corner = self.corners.len();
        for word in words {
            let mut indices = word.split(|&byte| byte == b'/');
            let mut next = |what: &'static str, defined: usize| match indices.next() {
                None | Some(b"") => Ok(NONE),
                Some(text) => zero_based(text, what, defined, place),
            };
            let corner = Corner {
                position: next("vertex", self.positions.len())?,
                uv: next("texture coordinate", self.uvs.len())?,
                normal: next("normal", self.normals.len())?,
            };
            if corner.position == NONE || indices.next().is_some() {
                return Err(MeshError::syntax(
                    place,
                    "a corner such as 1, 1/2, 1//3 or 1/2/3",
                    excerpt(word),
                ));
            }
            self.corners.push(corner);
        }
        let corner_count = self.corners.len() - first_corner;
        if corner_count < 3 {
            self.corners.truncate(first_corner);
            warnings.add(place, "a face with fewer than three corners is skipped");
            return Ok(());
        }
        self.faces.push(Face {
            first_corner: first_corner as u32,
            corner_count: corner_count as u32,
            material,
            line,
        });
        Ok(())
    }

    /// `names` is one file name, spaces and all; or, if there is no such file, several.
    fn add_libraries(
        &mut self,
        names: &str,
        place: Place,
        library: &mut dyn FnMut(&str) -> io::Result<Vec<u8>>,
        warnings: &mut Warnings,
    ) {
        let unreadable = |name: &str, error: io::Error| {
            let name = excerpt(name.as_bytes());
            format!("the material library {name} cannot be read: {error}")
        };
        let whole = names.trim_matches('"');
        let several: Vec<&str> = names.split_whitespace().take(MOST_LIBRARIES).collect();
        match library(whole) {
            Ok(bytes) => self.materials.extend(read_mtl(&bytes, whole, warnings)),
            Err(error) if several.len() < 2 => warnings.add(place, &unreadable(whole, error)),
            Err(_) => {
                for name in several {
                    match library(name) {
                        Ok(bytes) => self.materials.extend(read_mtl(&bytes, name, warnings)),
                        Err(error) => warnings.add(place, &unreadable(name, error)),
                    }
                }
            }
        }
    }

    /// Indices may point forward, so they are checked when all is read. Texture coordinates and normals of a file that defines none at
    /// all are forgiven: [`Self::build`] leaves them out.
    fn check_indices(&self) -> Result<(), MeshError> {
        for face in &self.faces {
            for corner in self.corners_of(face) {
                let pools = [
                    ("vertex", corner.position, self.positions.len(), true),
                    ("texture coordinate", corner.uv, self.uvs.len(), !self.uvs.is_empty()),
                    ("normal", corner.normal, self.normals.len(), !self.normals.is_empty()),
                ];
                for (what, index, count, must_exist) in pools {
                    if must_exist && index != NONE && index as usize >= count {
                        return Err(MeshError::IndexOutOfRange {
                            place: Place::Line(face.line.into()),
                            what,
                            index: i64::from(index) + 1,
                            count: count as u64,
                        });
                    }
                }
            }
        }
        Ok(())
    }

    fn corners_of(&self, face: &Face) -> &[Corner] {
        &self.corners[face.first_corner as usize..][..face.corner_count as usize]
    }

    /// Everything but the materials. `material_of_triangle` holds nothing yet.
    fn build(&self, warnings: &mut Warnings) -> MeshData {
        let mut mesh = MeshData::default();
        let mut vertices = SharedVertices::new(self);
        let mut outline = Vec::new();
        let mut ids = Vec::new();
        mesh.triangles.reserve(self.faces.len());
        for face in &self.faces {
            let corners = self.corners_of(face);
            outline.clear();
            outline.extend(corners.iter().map(|corner| self.positions[corner.position as usize]));
            ids.clear();
            ids.extend(corners.iter().map(|&corner| vertices.id_of(corner)));
            triangulate(&outline, |triangle| mesh.triangles.push(triangle.map(|i| ids[i])));
        }

        let sources = vertices.sources;
        mesh.positions = sources
            .iter()
            .map(|source| self.positions[source.position as usize])
            .collect();
        if sources.iter().any(|source| source.uv != NONE) && !self.uvs.is_empty() {
            let uv_of = |source: &Corner| self.uvs.get(source.uv as usize).copied().unwrap_or_default();
            mesh.uvs = sources.iter().map(uv_of).collect();
        }
        let given = |source: &Corner| {
            self.normals
                .get(source.normal as usize)
                .and_then(|&normal| unit(normal))
        };
        let lacking = sources.iter().filter(|source| given(source).is_none()).count();
        if lacking > 0 {
            mesh = mesh.with_vertex_normals();
        } else {
            mesh.normals = vec![Vec3::ZERO; sources.len()];
        }
        if lacking < sources.len() {
            for (normal, source) in mesh.normals.iter_mut().zip(&sources) {
                *normal = given(source).unwrap_or(*normal);
            }
            if lacking > 0 {
                warnings.add(
                    format_args!("{lacking} of {} vertices", sources.len()),
                    "without a usable normal of their own get one computed from the triangles",
                );
            }
        }
        mesh
    }

    fn assign_materials(mut self, mesh: &mut MeshData, warnings: &mut Warnings) -> Result<(), MeshError> {
        if self.materials.is_empty() {
            if !self.used_names.is_empty() {
                warnings.add("usemtl", "materials are named, but there is no library that has any");
            }
            return Ok(());
        }
        // Of several materials of one name the first counts.
        let mut index_of_name: HashMap<&str, usize> = HashMap::new();
        for (index, material) in self.materials.iter().enumerate() {
            index_of_name.entry(&material.name).or_insert(index);
        }
        let mut stand_ins = Vec::new();
        let mut stand_in = |name: &str| {
            stand_ins.push(default_material(name));
            self.materials.len() + stand_ins.len() - 1
        };
        let mut index_of_used = Vec::with_capacity(self.used_names.len());
        for name in &self.used_names {
            index_of_used.push(index_of_name.get(name.as_str()).copied().unwrap_or_else(|| {
                let quoted = excerpt(name.as_bytes());
                warnings.add("usemtl", &format!("no library has the material {quoted}; it is grey"));
                stand_in(name)
            }));
        }
        let index_of_none = if self.faces.iter().any(|face| face.material == NONE) {
            stand_in("")
        } else {
            0
        };
        for face in &self.faces {
            let index = index_of_used
                .get(face.material as usize)
                .copied()
                .unwrap_or(index_of_none);
            let index = u16::try_from(index).map_err(|_| MeshError::TooLarge {
                what: "the number of materials",
                limit: u16::MAX.into(),
            })?;
            let triangles = face.corner_count as usize - 2;
            mesh.material_of_triangle.extend(std::iter::repeat_n(index, triangles));
        }
        self.materials.extend(stand_ins);
        mesh.materials = self.materials;
        Ok(())
    }
}

/// Gives each distinct corner one vertex, numbered by first use.
struct SharedVertices {
    /// The corner each vertex comes from.
    sources: Vec<Corner>,
    /// Per position the vertex that has neither uv nor normal: most files need no more than this.
    plain: Vec<u32>,
    others: HashMap<Corner, u32>,
}

impl SharedVertices {
    fn new(file: &Statements) -> Self {
        Self {
            sources: Vec::with_capacity(file.positions.len().min(file.corners.len())),
            plain: vec![NONE; file.positions.len()],
            others: HashMap::new(),
        }
    }

    fn id_of(&mut self, corner: Corner) -> u32 {
        let next = self.sources.len() as u32;
        let id = if corner.uv == NONE && corner.normal == NONE {
            let known = &mut self.plain[corner.position as usize];
            if *known == NONE {
                *known = next;
            }
            *known
        } else {
            *self.others.entry(corner).or_insert(next)
        };
        if id == next {
            self.sources.push(corner);
        }
        id
    }
}

/// The text after the keyword, which may hold spaces.
fn argument<'a>(text: &'a [u8], keyword: &[u8]) -> &'a [u8] {
    text.trim_ascii_start()[keyword.len()..].trim_ascii()
}

fn numbers<'a, const N: usize>(
    mut words: impl Iterator<Item = &'a [u8]>,
    place: Place,
    line: &[u8],
    expected: &str,
) -> Result<[f32; N], MeshError> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = words
            .next()
            .and_then(parse_number)
            .ok_or_else(|| MeshError::syntax(place, expected, excerpt(line)))?;
    }
    Ok(numbers)
}

/// One to three numbers, of which two count. What is not finite becomes 0.
fn texture_coordinate<'a>(
    mut words: impl Iterator<Item = &'a [u8]>,
    place: Place,
    line: &[u8],
) -> Result<Vec2, MeshError> {
    let [u] = numbers(&mut words, place, line, "one to three texture coordinates")?;
    let v = match words.next() {
        None => 0.0,
        Some(word) => parse_number(word)
            .ok_or_else(|| MeshError::syntax(place, "one to three texture coordinates", excerpt(line)))?,
    };
    let uv = Vec2::new(u, v);
    Ok(if uv.is_finite() { uv } else { Vec2::ZERO })
}

fn parse_number(word: &[u8]) -> Option<f32> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// An index of the file, from 1 or backwards from -1 with `defined` so far, as an index from 0; not yet checked against the whole file.
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
