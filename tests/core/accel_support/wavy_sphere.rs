//! A generated closed mesh.

use glam::Vec3;
use sunroom::geometry::mesh::MeshData;

/// A wavy sphere of `2 * rings * rings` triangles around the origin: closed, with shared vertices, not convex.
pub fn wavy_sphere(rings: u32) -> MeshData {
    let segments = rings;
    let mut mesh = MeshData::default();
    let point = |ring: u32, segment: u32| {
        let theta = std::f32::consts::PI * ring as f32 / rings as f32;
        let phi = std::f32::consts::TAU * segment as f32 / segments as f32;
        let radius = 1.0 + 0.1 * (8.0 * phi).sin() * (6.0 * theta).sin() * theta.sin();
        radius * Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
    };
    mesh.positions.push(Vec3::Z);
    for ring in 1..rings {
        mesh.positions.extend((0..segments).map(|segment| point(ring, segment)));
    }
    mesh.positions.push(Vec3::NEG_Z);
    let last = mesh.positions.len() as u32 - 1;
    let index = |ring: u32, segment: u32| match ring {
        0 => 0,
        ring if ring == rings => last,
        ring => 1 + (ring - 1) * segments + segment % segments,
    };
    for ring in 0..rings {
        for segment in 0..segments {
            let (a, b) = (index(ring, segment), index(ring, segment + 1));
            let (c, d) = (index(ring + 1, segment), index(ring + 1, segment + 1));
            mesh.triangles.extend(
                [[a, c, d], [a, d, b]]
                    .iter()
                    .filter(|t| t[0] != t[1] && t[1] != t[2] && t[0] != t[2]),
            );
        }
    }
    mesh
}
