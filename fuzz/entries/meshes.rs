//! Meshes, and glTF files with all that is in them.

use std::io::{self, Write as _};

use glam::Vec3;
use sunroom_core::document::Document;
use sunroom_core::geometry::attribute::{AttributeDomain, AttributeValues};
use sunroom_core::geometry::mesh::MeshData;
use sunroom_core::geometry::obj::load_obj;
use sunroom_core::geometry::ply::load_ply;
use sunroom_core::geometry::ply_write::binary_ply;
use sunroom_core::geometry::serialized::SerializedFile;
use sunroom_core::gltf::Gltf;
use sunroom_core::gltf::files::take_apart;

use super::NOWHERE;
use super::documents::assert_survives_writing;

/// An OBJ file; what follows the first zero byte is the material library, whatever its name.
pub fn obj(bytes: &[u8]) {
    let (mesh, library) = halves(bytes);
    if let Ok(loaded) = load_obj(mesh, &mut |_| Ok(library.to_vec())) {
        assert_sound(&loaded.mesh);
    }
}

/// A material library, used by a mesh of two triangles.
pub fn mtl(bytes: &[u8]) {
    let mesh = b"mtllib a/b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 3 2 1\n";
    let loaded = load_obj(mesh, &mut |_| Ok(bytes.to_vec())).expect("a library is never an error");
    assert_sound(&loaded.mesh);
}

pub fn ply(bytes: &[u8]) {
    if let Ok(loaded) = load_ply(bytes) {
        assert_sound(&loaded.mesh);
    }
}

/// A file of the format `serialized`: its table and its first shapes.
pub fn serialized(bytes: &[u8]) {
    let Ok(file) = SerializedFile::open(bytes) else {
        return;
    };
    for shape in 0..file.count().min(4) {
        if let Ok(loaded) = file.load(shape) {
            assert_sound(&loaded.mesh);
        }
    }
}

/// The content of one shape of such a file, which is packed here. The first byte chooses the version.
pub fn serialized_shape(bytes: &[u8]) {
    let Some((version, content)) = bytes.split_first() else {
        return;
    };
    let version = 3 + u16::from(version % 2);
    let mut file = [0x1c, 0x04, version as u8, 0].to_vec();
    let mut packer = flate2::write::ZlibEncoder::new(&mut file, flate2::Compression::none());
    packer.write_all(content).expect("memory can be written to");
    packer.finish().expect("memory can be written to");
    file.resize(file.len() + if version == 3 { 4 } else { 8 }, 0);
    file.extend(1u32.to_le_bytes());
    serialized(&file);
}

/// What the documentation of meshes promises of every mesh that was loaded.
pub fn assert_sound(mesh: &MeshData) {
    let vertices = mesh.positions.len();
    assert!(mesh.positions.iter().all(|position| position.is_finite()));
    assert!(!mesh.triangles.is_empty());
    let mut corners = mesh.triangles.as_flattened().iter();
    assert!(corners.all(|&corner| (corner as usize) < vertices));
    assert_eq!(mesh.normals.len(), vertices);
    let is_unit = |normal: &Vec3| (normal.length() - 1.0).abs() < 1e-5;
    assert!(mesh.normals.iter().all(is_unit), "{:?}", mesh.normals);
    assert!(mesh.uvs.is_empty() || mesh.uvs.len() == vertices);
    assert!(mesh.uvs.iter().all(|uv| uv.is_finite()), "{:?}", mesh.uvs);
    assert!(mesh.material_of_triangle.is_empty() || mesh.material_of_triangle.len() == mesh.triangles.len());
    let mut materials = mesh.material_of_triangle.iter();
    assert!(materials.all(|&material| usize::from(material) < mesh.materials.len()));
    for (place, attribute) in mesh.attributes.iter().enumerate() {
        let name = &attribute.name;
        assert!(mesh.attributes[..place].iter().all(|other| other.name != *name));
        let elements = match attribute.domain {
            AttributeDomain::Vertex => vertices,
            AttributeDomain::Triangle => mesh.triangles.len(),
        };
        let values = match &attribute.values {
            AttributeValues::Srgb8(values) => values.len(),
            AttributeValues::F32(values) => {
                assert!(values.iter().all(|value| value.is_finite()), "{name}: {values:?}");
                values.len()
            }
        };
        assert!(matches!(attribute.channels, 1 | 3));
        assert_eq!(values, elements * attribute.channels, "{name}");
    }
    for triangle in 0..mesh.triangles.len().min(64) {
        mesh.regular_corners(triangle);
    }
    if vertices <= 1000 && mesh.triangles.len() <= 1000 {
        assert_comes_back(mesh);
    }
}

/// Writes the geometry as PLY and reads it again.
fn assert_comes_back(mesh: &MeshData) {
    let geometry = MeshData {
        attributes: Vec::new(),
        ..mesh.clone()
    };
    let again = load_ply(&binary_ply(&geometry)).expect("it was written").mesh;
    assert_eq!(again.positions, mesh.positions);
    assert_eq!(again.triangles, mesh.triangles);
    assert_eq!(again.uvs, mesh.uvs);
    let mut normals = again.normals.iter().zip(&mesh.normals);
    assert!(normals.all(|(one, other)| one.distance(*other) < 1e-5));
}

/// A glTF file of either kind; what follows the first zero byte of a JSON one is every file that it names. Its meshes
/// are sound, the meshes and pictures that are written for other programs can be read, and its scene survives writing.
pub fn gltf(bytes: &[u8]) {
    let (file, other) = match bytes.starts_with(b"glTF") {
        true => (bytes, &b""[..]),
        false => halves(bytes),
    };
    let mut read = |name: &str| match name.is_empty() {
        true => Err(io::ErrorKind::NotFound.into()),
        false => Ok(other.to_vec()),
    };
    let gltf = match Gltf::open(file, &mut read) {
        Ok(gltf) => gltf,
        Err(error) => {
            let _ = error.to_string();
            return;
        }
    };
    for number in 0..gltf.mesh_count().min(16) {
        if let Ok(loaded) = gltf.mesh(number) {
            assert_sound(&loaded.mesh);
        }
    }
    let mut keep = |name: &str, bytes: &[u8]| {
        if name.ends_with(".ply") {
            let loaded = load_ply(bytes).expect("a mesh that was written here");
            assert_sound(&loaded.mesh);
        }
        Ok(name.to_owned())
    };
    let Ok(imported) = take_apart(&gltf, &mut keep, &mut read) else {
        return;
    };
    assert_survives_writing(&Document::new(NOWHERE, imported.root));
}

/// The bytes before and after the first zero byte.
fn halves(bytes: &[u8]) -> (&[u8], &[u8]) {
    match bytes.iter().position(|&byte| byte == 0) {
        Some(zero) => (&bytes[..zero], &bytes[zero + 1..]),
        None => (bytes, b""),
    }
}
