//! Writes the vertices and triangles of meshes into the buffer.

use super::model::{Accessor, Attributes};
use super::{GltfWriteError, GltfWriter, push};
use crate::geometry::mesh::MeshData;

pub(super) const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
/// The largest 16-bit index, which is reserved for restarting strips.
const MOST_SHORT: usize = 0xffff;
/// The largest 32-bit index; also the most corners that a reader can number.
const MOST: u64 = 0xffff_ffff;

/// Triangles of a mesh by their corners.
pub type Triangles = [[u32; 3]];

/// An error if a mesh with these numbers of vertices and corners cannot be indexed.
fn check_counts(vertices: u64, corners: u64) -> Result<(), GltfWriteError> {
    let counts = [("vertices", vertices), ("corners of triangles", corners)];
    match counts.into_iter().find(|(_, count)| *count > MOST) {
        Some((what, count)) => Err(GltfWriteError::TooMany {
            what,
            count,
            most: MOST,
        }),
        None => Ok(()),
    }
}

impl GltfWriter {
    /// Adds the vertices of a mesh: positions, and normals and texture coordinates if it has them. `colors`: linear,
    /// one for each vertex.
    pub fn add_vertices(&mut self, mesh: &MeshData, colors: Option<&[[f32; 3]]>) -> Result<Attributes, GltfWriteError> {
        check_counts(mesh.positions.len() as u64, 3 * mesh.triangles.len() as u64)?;
        let mut attributes = Attributes::new();
        let target = Some(ARRAY_BUFFER);
        let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|position| position.to_array()).collect();
        attributes.insert("POSITION".to_owned(), self.add_floats(&positions, true, target));
        if !mesh.normals.is_empty() {
            // Vertices without triangles may have a zero normal.
            let unit = |normal: &glam::Vec3| normal.normalize_or(glam::Vec3::Z).to_array();
            let normals: Vec<[f32; 3]> = mesh.normals.iter().map(unit).collect();
            attributes.insert("NORMAL".to_owned(), self.add_floats(&normals, false, target));
        }
        if !mesh.uvs.is_empty() {
            let uvs: Vec<[f32; 2]> = mesh.uvs.iter().map(|uv| uv.to_array()).collect();
            attributes.insert("TEXCOORD_0".to_owned(), self.add_floats(&uvs, false, target));
        }
        if let Some(colors) = colors {
            attributes.insert("COLOR_0".to_owned(), self.add_floats(colors, false, target));
        }
        Ok(attributes)
    }

    /// Adds a tangent for each vertex, with the sign of the bitangent.
    pub fn add_tangents(&mut self, attributes: &mut Attributes, tangents: &[[f32; 4]]) {
        let accessor = self.add_floats(tangents, false, Some(ARRAY_BUFFER));
        attributes.insert("TANGENT".to_owned(), accessor);
    }

    /// Adds triangles over `vertices` vertices, and returns the accessor of their indices.
    pub fn add_triangles(&mut self, triangles: &Triangles, vertices: usize) -> Result<usize, GltfWriteError> {
        check_counts(vertices as u64, 3 * triangles.len() as u64)?;
        let corners = triangles.as_flattened();
        let target = Some(ELEMENT_ARRAY_BUFFER);
        let (component_type, buffer_view) = if vertices <= MOST_SHORT {
            let bytes = corners.iter().flat_map(|corner| (*corner as u16).to_le_bytes());
            (UNSIGNED_SHORT, self.add_view(bytes, target))
        } else {
            let bytes = corners.iter().flat_map(|corner| corner.to_le_bytes());
            (UNSIGNED_INT, self.add_view(bytes, target))
        };
        let accessor = Accessor {
            buffer_view,
            component_type,
            count: corners.len(),
            kind: "SCALAR",
            min: Vec::new(),
            max: Vec::new(),
        };
        Ok(push(&mut self.root.accessors, accessor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_that_cannot_be_numbered_are_refused() {
        assert_eq!(check_counts(MOST, MOST), Ok(()));
        for (vertices, corners, what) in [(1 << 32, 3, "vertices"), (3, 3 << 31, "corners")] {
            let error = check_counts(vertices, corners).expect_err(what);
            assert!(error.to_string().contains(what), "{error}");
        }
    }
}
