//! A glTF file taken apart into files that other programs of the scene format read: meshes as PLY, pictures as PNG, JPEG or EXR.

use glam::Vec3;

use super::mesh::VERTEX_COLOR;
use super::picture::Picture;
use super::scene::{Imported, References, object, with};
use super::{Gltf, GltfError, ReadFile};
use crate::document::{Category, Object, Value};
use crate::geometry::attribute::AttributeValues;
use crate::geometry::mesh::MeshData;

/// A file to write.
pub struct NewFile {
    /// Relative to the scene's folder, with `/`.
    pub name: String,
    pub bytes: Vec<u8>,
}

/// The scene with the files that it names. These are in the folder `folder` beside it; `read` as for [`Gltf::open`].
pub fn take_apart(gltf: &Gltf, folder: &str, read: &mut ReadFile) -> Result<(Imported, Vec<NewFile>), GltfError> {
    let mut parts = Parts {
        gltf,
        folder,
        read,
        files: Vec::new(),
    };
    let imported = gltf.scene(&mut parts)?;
    Ok((imported, parts.files))
}

struct Parts<'a, 'r> {
    gltf: &'a Gltf,
    folder: &'a str,
    read: &'a mut ReadFile<'r>,
    files: Vec<NewFile>,
}

impl Parts<'_, '_> {
    fn has(&self, name: &str) -> bool {
        self.files.iter().any(|file| file.name == name)
    }
}

impl References for Parts<'_, '_> {
    fn shape(&mut self, number: u32) -> Result<Object, GltfError> {
        let name = format!("{}/mesh-{number}.ply", self.folder);
        if !self.has(&name) {
            let bytes = ply(&self.gltf.mesh(number)?.mesh);
            self.files.push(NewFile {
                name: name.clone(),
                bytes,
            });
        }
        Ok(with(object(Category::Shape, "ply"), "filename", Value::String(name)))
    }

    fn picture(&mut self, bitmap: Object, index: usize, picture: &Picture) -> Result<Object, GltfError> {
        let stem = format!("{}/picture-{index}", self.folder);
        let known = ["png", "jpg", "exr"].map(|extension| format!("{stem}.{extension}"));
        let name = match known.into_iter().find(|name| self.has(name)) {
            Some(name) => name,
            None => {
                let made = self.gltf.picture(picture, self.read)?;
                let name = format!("{stem}.{}", made.extension);
                self.files.push(NewFile {
                    name: name.clone(),
                    bytes: made.bytes,
                });
                name
            }
        };
        Ok(with(bitmap, "filename", Value::String(name)))
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
