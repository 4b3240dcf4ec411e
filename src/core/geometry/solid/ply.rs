//! Writes meshes as PLY text, for programs that do not know the numbers they were made from.

use std::fmt::Write;

use crate::geometry::mesh::MeshData;

/// The mesh with its normals and texture coordinates, as Mitsuba's `ply` reads it.
pub fn to_ply(mesh: &MeshData) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n\
         property float nz\nproperty float u\nproperty float v\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len(),
    );
    let vertices = mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs);
    for ((position, normal), uv) in vertices {
        let numbers = [position.to_array(), normal.to_array()].concat();
        let numbers: Vec<String> = numbers.iter().chain(&uv.to_array()).map(f32::to_string).collect();
        // Writing to a text cannot fail.
        let _ = writeln!(text, "{}", numbers.join(" "));
    }
    for [a, b, c] in &mesh.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}
