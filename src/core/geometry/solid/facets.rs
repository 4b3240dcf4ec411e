//! Collects flat polygons as a mesh.

use glam::{DVec3, Vec2, Vec3};

use crate::geometry::mesh::MeshData;
use crate::geometry::polygon::triangulate;

/// The mesh so far.
pub(super) struct Facets {
    mesh: MeshData,
    /// The point that has the texture coordinates (0, 0).
    origin: Vec3,
}

impl Facets {
    pub fn new(origin: Vec3) -> Self {
        Self {
            mesh: MeshData::default(),
            origin,
        }
    }

    /// Adds a flat polygon, counter-clockwise as seen from outside. One without area adds nothing.
    pub fn polygon(&mut self, corners: &[Vec3]) {
        let [first, ..] = corners else { return };
        // Newell's normal holds for polygons that are not convex, too. It needs double precision, because squares of
        // large lengths overflow in single precision.
        let turned = corners.iter().zip(corners.iter().cycle().skip(1));
        let from_first = |corner: &Vec3| corner.as_dvec3() - first.as_dvec3();
        let area: DVec3 = turned.map(|(a, b)| from_first(a).cross(from_first(b))).sum();
        let size = area.length();
        if !(size > 0.0 && size.is_finite()) {
            return;
        }
        // Unlike the product with a reciprocal, this is exactly 1 along an axis.
        let normal = (area / size).as_vec3();
        let (u, v) = directions(normal);
        let base = self.mesh.positions.len() as u32;
        for corner in corners {
            let along = *corner - self.origin;
            self.mesh.positions.push(*corner);
            self.mesh.normals.push(normal);
            self.mesh.uvs.push(Vec2::new(along.dot(u), along.dot(v)));
        }
        let triangles = &mut self.mesh.triangles;
        triangulate(corners, |triangle| {
            triangles.push(triangle.map(|corner| base + corner as u32));
        });
    }

    pub fn finish(self) -> MeshData {
        self.mesh
    }
}

/// The directions in which u and v grow on a face: to the right and down as seen from outside, on level faces along x
/// and against y.
fn directions(normal: Vec3) -> (Vec3, Vec3) {
    let right = match Vec3::Z.cross(normal) {
        level if level.length_squared() < 1e-6 => Vec3::X,
        right => right.normalize(),
    };
    (right, right.cross(normal))
}
