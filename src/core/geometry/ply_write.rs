//! Writes meshes as binary PLY files, with all data that this program's reader and Mitsuba's use.

use super::attribute::{AttributeDomain, AttributeValues, MeshAttribute};
use super::mesh::MeshData;
use crate::color::linear_from_srgb8;

/// The mesh with its normals, texture coordinates and attributes. Materials are left out: PLY has none.
pub fn binary_ply(mesh: &MeshData) -> Vec<u8> {
    let of = |domain| {
        mesh.attributes
            .iter()
            .filter(move |attribute| attribute.domain == domain)
    };
    let of_vertices: Vec<&MeshAttribute> = of(AttributeDomain::Vertex).collect();
    let of_triangles: Vec<&MeshAttribute> = of(AttributeDomain::Triangle).collect();
    let has_normals = mesh.normals.len() == mesh.positions.len();
    let has_uvs = mesh.uvs.len() == mesh.positions.len();
    let mut header = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n",
        mesh.positions.len()
    );
    let mut properties = |names: &[&str]| {
        for name in names {
            header += &format!("property float {name}\n");
        }
    };
    properties(&["x", "y", "z"]);
    if has_normals {
        properties(&["nx", "ny", "nz"]);
    }
    if has_uvs {
        properties(&["u", "v"]);
    }
    header += &attribute_properties(&of_vertices);
    header += &format!(
        "element face {}\nproperty list uchar int vertex_indices\n{}end_header\n",
        mesh.triangles.len(),
        attribute_properties(&of_triangles)
    );
    let mut bytes = header.into_bytes();
    bytes.reserve(32 * mesh.positions.len() + 13 * mesh.triangles.len());
    let put = |bytes: &mut Vec<u8>, numbers: &[f32]| {
        numbers.iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    };
    for (vertex, position) in mesh.positions.iter().enumerate() {
        put(&mut bytes, &position.to_array());
        if has_normals {
            put(&mut bytes, &mesh.normals[vertex].to_array());
        }
        if has_uvs {
            put(&mut bytes, &mesh.uvs[vertex].to_array());
        }
        put_values(&mut bytes, &of_vertices, vertex);
    }
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        bytes.push(3);
        triangle
            .iter()
            .for_each(|corner| bytes.extend((*corner as i32).to_le_bytes()));
        put_values(&mut bytes, &of_triangles, index);
    }
    bytes
}

/// The declarations of attributes. Colours have the names that other programs know; the suffixes of others tell the
/// reader which properties form an attribute.
fn attribute_properties(attributes: &[&MeshAttribute]) -> String {
    let declared = |attribute: &&MeshAttribute| {
        let name = attribute
            .name
            .split_once('_')
            .map_or(&*attribute.name, |(_, name)| name);
        let names = match (name, attribute.channels) {
            ("color", 3) => ["r", "g", "b"].map(str::to_owned),
            _ => ["x", "y", "z"].map(|ending| format!("{name}_{ending}")),
        };
        names.into_iter().take(attribute.channels)
    };
    let names = attributes.iter().flat_map(declared);
    names.map(|name| format!("property float {name}\n")).collect()
}

fn put_values(bytes: &mut Vec<u8>, attributes: &[&MeshAttribute], element: usize) {
    for attribute in attributes {
        for channel in 0..attribute.channels.min(3) {
            let place = attribute.channels * element + channel;
            let value = match &attribute.values {
                AttributeValues::Srgb8(values) => values.get(place).map(|value| linear_from_srgb8(*value)),
                AttributeValues::F32(values) => values.get(place).copied(),
            };
            bytes.extend(value.unwrap_or(0.0).to_le_bytes());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ply::load_ply;
    use crate::geometry::primitives::unit_cube;

    #[test]
    fn what_is_written_is_read_again() {
        let attribute = |name: &str, domain, channels: usize, count: usize| MeshAttribute {
            name: name.to_owned(),
            domain,
            channels,
            values: AttributeValues::F32((0..channels * count).map(|value| value as f32 * 0.25).collect()),
        };
        let mut mesh = unit_cube();
        mesh.attributes = vec![
            attribute("vertex_color", AttributeDomain::Vertex, 3, 24),
            attribute("vertex_dust", AttributeDomain::Vertex, 1, 24),
            attribute("face_heat", AttributeDomain::Triangle, 3, 12),
        ];
        let read = load_ply(&binary_ply(&mesh)).expect("a good file").mesh;
        assert_eq!(
            (
                &read.positions,
                &read.normals,
                &read.uvs,
                &read.triangles,
                &read.attributes
            ),
            (
                &mesh.positions,
                &mesh.normals,
                &mesh.uvs,
                &mesh.triangles,
                &mesh.attributes
            )
        );
        // Bytes are colours.
        mesh.attributes[1].values = AttributeValues::Srgb8((0..24).map(|value| value * 10).collect());
        let read = load_ply(&binary_ply(&mesh)).expect("a good file").mesh;
        let AttributeValues::F32(values) = &read.attributes[1].values else {
            panic!("{:?}", read.attributes[1])
        };
        assert_eq!(values[10], linear_from_srgb8(100));
    }
}
