//! A glTF file taken apart into files that other programs of the scene format read: meshes as PLY, pictures as PNG, JPEG or EXR.

use glam::Vec3;

use super::mesh::VERTEX_COLOR;
use super::picture::Picture;
use super::scene::{Imported, References, object, with};
use super::{Gltf, GltfError, ReadFile};
use crate::document::{Category, Object, Value};
use crate::geometry::attribute::AttributeValues;
use crate::geometry::mesh::MeshData;

/// Keeps a part under a plain name such as `mesh-0.ply`, which is given once. Returns the name by which the scene finds it.
pub type KeepFile<'a> = dyn FnMut(&str, &[u8]) -> std::io::Result<String> + 'a;

/// Makes the scene, whose meshes and pictures are given to `keep`. `read` is as for [`Gltf::open`].
pub fn take_apart(gltf: &Gltf, keep: &mut KeepFile, read: &mut ReadFile) -> Result<Imported, GltfError> {
    gltf.scene(&mut Parts { gltf, keep, read })
}

struct Parts<'a, 'k, 'r> {
    gltf: &'a Gltf,
    keep: &'a mut KeepFile<'k>,
    read: &'a mut ReadFile<'r>,
}

impl Parts<'_, '_, '_> {
    fn keep(&mut self, name: String, bytes: &[u8]) -> Result<String, GltfError> {
        (self.keep)(&name, bytes).map_err(|source| GltfError::Keep { name, source })
    }
}

impl References for Parts<'_, '_, '_> {
    fn shape(&mut self, number: u32, mesh: &MeshData) -> Result<Object, GltfError> {
        let name = self.keep(format!("mesh-{number}.ply"), &ply(mesh))?;
        Ok(with(object(Category::Shape, "ply"), "filename", Value::String(name)))
    }

    fn picture(&mut self, index: usize, picture: &Picture) -> Result<String, GltfError> {
        let made = self.gltf.picture(picture, self.read)?;
        self.keep(format!("picture-{index}.{}", made.extension), &made.bytes)
    }
}

/// The mesh as binary PLY, with normals, texture coordinates and vertex colours where it has them.
fn ply(mesh: &MeshData) -> Vec<u8> {
    let colors = mesh
        .attribute(VERTEX_COLOR)
        .and_then(|attribute| match &attribute.values {
            AttributeValues::F32(values) => Some(values),
            AttributeValues::Srgb8(_) => None,
        });
    let mut properties = vec!["x", "y", "z", "nx", "ny", "nz"];
    if !mesh.uvs.is_empty() {
        properties.extend(["u", "v"]);
    }
    if colors.is_some() {
        properties.extend(["r", "g", "b"]);
    }
    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n",
        mesh.positions.len()
    );
    for property in properties {
        header += &format!("property float {property}\n");
    }
    header += &format!(
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.triangles.len()
    );
    let mut bytes = header.into_bytes();
    let mut push = |numbers: &[f32]| numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    for (vertex, position) in mesh.positions.iter().enumerate() {
        push(&position.to_array());
        push(&mesh.normals.get(vertex).copied().unwrap_or(Vec3::Z).to_array());
        if let Some(uv) = mesh.uvs.get(vertex) {
            push(&uv.to_array());
        }
        if let Some(color) = colors.and_then(|colors| colors.get(3 * vertex..3 * vertex + 3)) {
            push(color);
        }
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        triangle.iter().for_each(|index| bytes.extend(index.to_le_bytes()));
    }
    bytes
}
