//! Reads Wavefront OBJ meshes (Wavefront, "Advanced Visualizer" manual, appendix B1): the polygons, with their MTL
//! materials.
//!
//! All objects and groups of a file become one mesh. Corners share a vertex where their indices of position, texture
//! coordinate and normal agree; polygons are cut as in `polygon.rs`. Colours behind the coordinates of vertices (`v x y
//! z r g b`, as MeshLab writes them) become the attribute `vertex_color`, taken as they are, like the floats of a PLY
//! file. Smoothing groups, points, lines and curves are ignored.
//!
//! Normals follow Mitsuba 3.9.1: where the file has none, they are computed over all triangles that share a vertex,
//! whatever `s` says, so a seam of the texture is a crease. Corners without a normal in a file that has some, and
//! normals that are zero or not finite, get the computed one. Texture coordinates stay as they are (Mitsuba flips v by
//! default: [`MeshData::flip_tex_coords`]).
//!
//! The crate `tobj` reads the MTL but not the OBJ: it takes three to seven times as long, ends at text that other
//! programs read, and knows neither the lines of errors nor the names of missing materials (see the table in
//! `benches/NOTES.md`).

use std::collections::HashMap;
use std::io;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::attribute::{AttributeDomain, AttributeValues, MeshAttribute};
use super::mesh::{MeshData, MtlMaterial};
use super::mesh_file::{LoadedMesh, MeshError, MeshMemory, Place, Warnings, excerpt, replace_not_finite};
use super::mtl::{Libraries, default_material};
use super::obj_lines::stretches;
use super::obj_part::{Corner, Counts, NONE, Part};
use super::obj_vertices::SharedVertices;
use super::polygon::triangulate;
use super::vertex_normals::{angle_weighted_normals, unit};

/// Reads a whole OBJ file on all threads. `library` returns the content of an MTL file named relative to it, with `/`
/// between folders; a missing one is a warning. Errors name the line.
pub fn load_obj(bytes: &[u8], library: &mut dyn FnMut(&str) -> io::Result<Vec<u8>>) -> Result<LoadedMesh, MeshError> {
    load_in_stretches(bytes, STRETCH, library)
}

/// The size of a chunk in bytes: large enough to keep a thread busy, small enough for all threads to end at about the
/// same time.
const STRETCH: usize = 1 << 18;
/// The bytes of memory that parsed statements take for each byte of text, without colours.
const BYTES_PER_BYTE: u64 = 4;
/// The bytes of memory for the colour of a vertex, in its part and in the joined array.
const BYTES_PER_COLOR: u64 = 2 * size_of::<Vec3>() as u64;

fn load_in_stretches(
    bytes: &[u8],
    length: usize,
    library: &mut dyn FnMut(&str) -> io::Result<Vec<u8>>,
) -> Result<LoadedMesh, MeshError> {
    // Every statement takes at least two bytes, so all counts below fit 32 bits.
    if bytes.len() > u32::MAX as usize {
        return Err(MeshError::TooLarge {
            what: "the size of the file in bytes",
            limit: u32::MAX.into(),
        });
    }
    let length_bytes = bytes.len() as u64;
    let mut memory = MeshMemory::reserve(BYTES_PER_BYTE * length_bytes, || {
        format!("{length_bytes} bytes of text")
    })?;
    let mut warnings = Warnings::default();
    let mut statements = Statements::read(
        bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes),
        length,
        &mut memory,
        &mut warnings,
    )?;
    statements.add_libraries(library, &mut warnings);
    statements.check_indices()?;
    let mut mesh = statements.build(&mut warnings);
    if mesh.triangles.is_empty() {
        return Err(MeshError::NoTriangles);
    }
    statements.assign_materials(&mut mesh, &mut warnings)?;
    Ok(LoadedMesh {
        mesh: memory.hold(mesh)?,
        warnings: warnings.finish(),
    })
}

/// The parsed statements of the file.
struct Statements {
    positions: Vec<Vec3>,
    /// One colour for each position, or empty.
    colors: Vec<Vec3>,
    /// The number of positions that have a colour in the file.
    colored: usize,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// The other statements, in the order of the file.
    parts: Vec<Part>,
    materials: Vec<MtlMaterial>,
}

impl Statements {
    fn read(text: &[u8], length: usize, memory: &mut MeshMemory, warnings: &mut Warnings) -> Result<Self, MeshError> {
        let texts = stretches(text, length);
        let read = |(i, text): (usize, &&[u8])| Part::read(text, (i == 0).then_some(Counts::default()));
        let mut parts: Vec<Part> = texts.par_iter().enumerate().map(read).collect();
        let counts_before = parts.iter().scan(Counts::default(), |counts, part| {
            let before = *counts;
            *counts = before + part.counts();
            Some(before)
        });
        let counts_before: Vec<Counts> = counts_before.collect();
        let readings = parts.par_iter_mut().zip(&texts).zip(counts_before);
        readings.for_each(|((part, text), before)| part.follow(before, text));
        for part in &mut parts {
            if let Some(error) = part.error.take() {
                return Err(error);
            }
            warnings.append(std::mem::take(&mut part.warnings));
        }
        let colored = parts.iter().map(|part| part.colored).sum();
        if colored > 0 {
            // If one vertex has a colour, all get one.
            let count: usize = parts.iter().map(|part| part.positions.len()).sum();
            memory.add(BYTES_PER_COLOR * count as u64, || {
                format!("{count} colours of vertices")
            })?;
            for part in &mut parts {
                part.colors.resize(part.positions.len(), Vec3::ONE);
            }
        }
        Ok(Self {
            colors: joined(&mut parts, |part| &mut part.colors),
            colored,
            positions: joined(&mut parts, |part| &mut part.positions),
            uvs: joined(&mut parts, |part| &mut part.uvs),
            normals: joined(&mut parts, |part| &mut part.normals),
            parts,
            materials: Vec::new(),
        })
    }

    fn add_libraries(&mut self, library: &mut dyn FnMut(&str) -> io::Result<Vec<u8>>, warnings: &mut Warnings) {
        let mut libraries = Libraries::new(library);
        for (line, names) in self.parts.iter_mut().flat_map(|part| part.libraries.drain(..)) {
            libraries.add(&names, Place::Line(line.into()), warnings);
        }
        self.materials = libraries.materials;
    }

    /// Checks indices. They may point forward, so this comes at the end. Missing texture coordinates and normals are no
    /// error if the file defines none at all: [`Self::build`] leaves them out.
    fn check_indices(&self) -> Result<(), MeshError> {
        let forgiving = |count: usize| if count == 0 { usize::MAX } else { count };
        let pools = [
            ("vertex", self.positions.len()),
            ("texture coordinate", forgiving(self.uvs.len())),
            ("normal", forgiving(self.normals.len())),
        ];
        let error_of = |corner: &Corner, place: Place| {
            let indices = [corner.position, corner.uv, corner.normal];
            let mut both = indices.into_iter().zip(pools);
            let (index, (what, count)) = both.find(|&(index, (_, count))| index != NONE && index as usize >= count)?;
            Some(MeshError::IndexOutOfRange {
                place,
                what,
                index: i64::from(index) + 1,
                count: count as u64,
            })
        };
        let first_error = |part: &Part| {
            let mut errors = part.faces.iter().flat_map(|face| {
                let corners = part.corners_of(face).iter();
                corners.filter_map(|corner| error_of(corner, part.place_of(face)))
            });
            errors.next()
        };
        self.parts.par_iter().find_map_first(first_error).map_or(Ok(()), Err)
    }

    /// Builds the mesh without its materials; `material_of_triangle` stays empty.
    fn build(&self, warnings: &mut Warnings) -> MeshData {
        let mut vertices = SharedVertices::new(self.positions.len());
        let ids: Vec<Vec<u32>> = self.parts.iter().map(|part| vertices.ids_of(&part.corners)).collect();
        let parts = self.parts.par_iter().zip(ids);
        let triangles: Vec<Vec<[u32; 3]>> = parts.map(|(part, ids)| self.triangles_of(part, &ids)).collect();
        let mut mesh = MeshData {
            triangles: triangles.concat(),
            ..MeshData::default()
        };
        drop(triangles);

        let sources = vertices.into_corners();
        let position_of = |source: &Corner| self.positions[source.position as usize];
        mesh.positions = sources.par_iter().map(position_of).collect();
        if !self.uvs.is_empty() && sources.iter().any(|source| source.uv != NONE) {
            let uv_of = |source: &Corner| self.uvs.get(source.uv as usize).copied().unwrap_or_default();
            mesh.uvs = sources.par_iter().map(uv_of).collect();
        }
        self.add_colors(&mut mesh, &sources, warnings);
        replace_not_finite(&mut mesh, warnings);
        self.add_normals(&mut mesh, &sources, warnings);
        mesh
    }

    fn triangles_of(&self, part: &Part, ids: &[u32]) -> Vec<[u32; 3]> {
        let mut triangles = Vec::with_capacity(part.corners.len() - 2 * part.faces.len());
        let mut outline = Vec::new();
        for face in &part.faces {
            let ids = &ids[face.first_corner as usize..][..face.corner_count as usize];
            if let &[a, b, c] = ids {
                triangles.push([a, b, c]);
                continue;
            }
            let corners = part.corners_of(face);
            outline.clear();
            outline.extend(corners.iter().map(|corner| self.positions[corner.position as usize]));
            triangulate(&outline, |triangle| triangles.push(triangle.map(|i| ids[i])));
        }
        triangles
    }

    fn add_colors(&self, mesh: &mut MeshData, sources: &[Corner], warnings: &mut Warnings) {
        if self.colors.is_empty() {
            return;
        }
        let lacking = self.positions.len() - self.colored;
        if lacking > 0 {
            let count = self.positions.len();
            warnings.add(
                format_args!("{lacking} of {count} vertices"),
                "without a colour are white",
            );
        }
        let color_of = |source: &Corner| self.colors[source.position as usize].to_array();
        let channels: Vec<[f32; 3]> = sources.iter().map(color_of).collect();
        mesh.attributes.push(MeshAttribute {
            name: "vertex_color".to_owned(),
            domain: AttributeDomain::Vertex,
            channels: 3,
            values: AttributeValues::F32(channels.into_flattened()),
        });
    }

    fn add_normals(&self, mesh: &mut MeshData, sources: &[Corner], warnings: &mut Warnings) {
        let given = |source: &Corner| unit(*self.normals.get(source.normal as usize)?);
        let mut lacking = sources.len();
        if !self.normals.is_empty() {
            mesh.normals = sources
                .par_iter()
                .map(|source| given(source).unwrap_or(Vec3::NAN))
                .collect();
            lacking = mesh.normals.iter().filter(|normal| normal.is_nan()).count();
        }
        if lacking == 0 {
            return;
        }
        let computed = angle_weighted_normals(&mesh.positions, &mesh.triangles);
        if lacking == sources.len() {
            if sources
                .iter()
                .any(|source| (source.normal as usize) < self.normals.len())
            {
                warnings.add("normals", "none is usable, and all are computed from the triangles");
            }
            mesh.normals = computed;
            mesh.has_computed_normals = true;
            return;
        }
        for (normal, computed) in mesh.normals.iter_mut().zip(computed) {
            if normal.is_nan() {
                *normal = computed;
            }
        }
        warnings.add(
            format_args!("{lacking} of {} vertices", sources.len()),
            "without a usable normal of their own get one computed from the triangles",
        );
    }

    fn assign_materials(mut self, mesh: &mut MeshData, warnings: &mut Warnings) -> Result<(), MeshError> {
        if self.materials.is_empty() {
            if self.parts.iter().any(|part| !part.used_names.is_empty()) {
                warnings.add("usemtl", "materials are named, but there is no library that has any");
            }
            return Ok(());
        }
        // The first of several materials with one name counts.
        let mut index_of_name: HashMap<&str, usize> = HashMap::new();
        for (index, material) in self.materials.iter().enumerate() {
            index_of_name.entry(&material.name).or_insert(index);
        }
        let mut stand_ins = Vec::new();
        let mut stand_in = |name: &str| {
            stand_ins.push(default_material(name));
            self.materials.len() + stand_ins.len() - 1
        };
        // For each part, the material index of each name that the part uses.
        let mut indices: Vec<Vec<usize>> = Vec::with_capacity(self.parts.len());
        for part in &self.parts {
            let mut of_part = Vec::with_capacity(part.used_names.len());
            for name in &part.used_names {
                let index = index_of_name.entry(name).or_insert_with(|| {
                    let quoted = excerpt(name.as_bytes());
                    warnings.add("usemtl", &format!("no library has the material {quoted}; it is grey"));
                    stand_in(name)
                });
                of_part.push(*index);
            }
            indices.push(of_part);
        }
        let mut index_of_none = None;
        let mut current = None;
        for (part, indices) in self.parts.iter().zip(&indices) {
            for face in &part.faces {
                let index = indices.get(face.material as usize).copied().or(current);
                let index = index.unwrap_or_else(|| *index_of_none.get_or_insert_with(|| stand_in("")));
                let index = u16::try_from(index).map_err(|_| MeshError::TooLarge {
                    what: "the number of materials",
                    limit: u16::MAX.into(),
                })?;
                let triangles = face.corner_count as usize - 2;
                mesh.material_of_triangle.extend(std::iter::repeat_n(index, triangles));
            }
            current = indices.get(part.material as usize).copied().or(current);
        }
        self.materials.extend(stand_ins);
        mesh.materials = self.materials;
        Ok(())
    }
}

/// Concatenates an array of all parts.
fn joined<T>(parts: &mut [Part], array: impl Fn(&mut Part) -> &mut Vec<T>) -> Vec<T> {
    let mut all = Vec::with_capacity(parts.iter_mut().map(|part| array(part).len()).sum());
    for part in parts {
        all.extend(std::mem::take(array(part)));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A text with every feature of the format, and with statements that depend on earlier chunks: line numbers,
    /// current materials, indices that count backwards.
    const TRICKY: &str = "\u{feff}# tricky\r\nmtllib a.mtl\\\n b.mtl\r\nv 0 0 0\rv 1 0 0\nv 1 1 0 0.5 0.5 0.5\nv 0 1 \\\r\n0\nf 1 2 3\nusemtl red\n\
        vt 0 0\nvt 1\nvt 1 1 1\nvt nan 1\nvn 0 0 1\nvn 0 0 0\nf 1/1 2/2 3/3 4/4\nf -4/-4/-2 -3/-3/-1 -2/-2/-2\ng one\n\nusemtl none\nodd 1\n\
        f 9 10 11\nusemtl red\nv 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\nvn 0 0 2\nf -4//-1 -3//-1 -2//-1 -1//-1\nmtllib c.mtl\nf 1 2\ns off\n\
        v 7 0 0\nv 8 0 1e-1\nv +7.5 1 0\nf -3 -2 -1 # end\nodd 2\nodder\nf -3 \\\n-2 \\\n-1\nf 5 6 7 8 \\\n11 # \\\nv 9 9 9\nf 11//2 10//3 9//1\n";

    fn load(text: &str, length: usize) -> (Result<LoadedMesh, MeshError>, Vec<String>) {
        let mut asked = Vec::new();
        let mut library = |name: &str| {
            asked.push(name.to_owned());
            match name {
                "c.mtl" => Ok(b"newmtl red\nKd 1 0 0\n".to_vec()),
                _ => Err(io::ErrorKind::NotFound.into()),
            }
        };
        let loaded = load_in_stretches(text.as_bytes(), length, &mut library);
        (loaded, asked)
    }

    #[test]
    fn stretches_of_any_length_give_the_same_mesh() {
        let whole = load(TRICKY, usize::MAX);
        let mesh = &whole.0.as_ref().expect("loads").mesh;
        assert_eq!((mesh.triangles.len(), mesh.materials.len()), (13, 3));
        assert_eq!(whole.1, ["a.mtl  b.mtl", "a.mtl", "b.mtl", "c.mtl"]);
        for length in 0..TRICKY.len() {
            assert_eq!(load(TRICKY, length), whole, "{length}");
        }
        for (ends, other) in [
            ("\n", TRICKY.replace('\r', "")),
            ("\r", TRICKY.replace("\r\n", "\n").replace('\n', "\r")),
        ] {
            let whole = load(&other, usize::MAX);
            for length in 0..TRICKY.len() {
                assert_eq!(load(&other, length), whole, "{ends:?} {length}");
            }
        }
    }

    #[test]
    fn stretches_of_any_length_give_the_same_error() {
        // Each line in turn is broken, and later ones too: the first error is reported.
        let lines: Vec<&str> = TRICKY.split_inclusive('\n').collect();
        for wrong in [
            "v 1 2 x\n",
            "f -9 -1 -1\n",
            "f 1 2 99\n",
            "f 1 2 3/9\n",
            "vn 1\n",
            "v inf 0 0\n",
            "f 1 a 2\n",
        ] {
            let mut errors = 0;
            for at in 0..lines.len() {
                let text = [&lines[..at], &[wrong], &lines[at..], &["f 99 99 99\nv x\n"]]
                    .concat()
                    .concat();
                let whole = load(&text, usize::MAX);
                errors += u32::from(whole.0.is_err());
                for length in [0, 1, 7, 30, 100, text.len() / 2] {
                    assert_eq!(load(&text, length), whole, "{wrong} {at} {length}");
                }
            }
            assert_eq!(errors as usize, lines.len());
        }
    }
}
