//! Smooth vertex normals from the triangles around each vertex, for files that carry none.
//!
//! Each triangle adds its unit normal, weighted by its interior angle at the vertex (Thürmer and Wüthrich, "Computing vertex normals from
//! polygonal facets", Journal of Graphics Tools 3(1), 1998). Mitsuba 3.9 does the same when a mesh file has no normals and
//! `face_normals` is off, so pictures agree.

use std::f32::consts::PI;

use glam::Vec3;

use super::mesh::MeshData;
use super::mesh_file::Warnings;

/// The normal of a vertex that no triangle with an area touches; never seen by a ray, but unit length all the same.
pub const NORMAL_OF_LONE_VERTEX: Vec3 = Vec3::X;

/// One unit normal per position. Every index must be below `positions.len()`.
///
/// Triangles without area count for nothing; a vertex whose triangles cancel out, or that has none, gets [`NORMAL_OF_LONE_VERTEX`].
pub fn angle_weighted_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for &triangle in triangles {
        let corners = triangle.map(|i| positions[i as usize]);
        let edges = [0, 1, 2].map(|k| unit(corners[(k + 1) % 3] - corners[k]));
        let [Some(a), Some(b), Some(c)] = edges else { continue };
        // Of unit edges, so that a tiny triangle's cross product does not underflow.
        let Some(normal) = unit(a.cross(-c)) else { continue };
        let angles = [angle_between(a, -c), angle_between(b, -a), angle_between(c, -b)];
        for (vertex, angle) in triangle.into_iter().zip(angles) {
            sums[vertex as usize] += normal * angle;
        }
    }
    for sum in &mut sums {
        *sum = unit(*sum).unwrap_or(NORMAL_OF_LONE_VERTEX);
    }
    sums
}

/// Computes all normals where the file has none, and those it has but that are no directions; the others become unit length.
pub(super) fn complete_normals(mesh: &mut MeshData, warnings: &mut Warnings) {
    if mesh.normals.is_empty() {
        mesh.normals = angle_weighted_normals(&mesh.positions, &mesh.triangles);
        return;
    }
    let mut computed = Vec::new();
    for i in 0..mesh.normals.len() {
        mesh.normals[i] = unit(mesh.normals[i]).unwrap_or_else(|| {
            if computed.is_empty() {
                computed = angle_weighted_normals(&mesh.positions, &mesh.triangles);
            }
            warnings.add(
                "normals",
                "a normal that is zero or not finite is computed from the triangles instead",
            );
            computed[i]
        });
    }
}

/// The direction of `vector`, whatever its length, even where the square of that is beyond an `f32`; `None` for zero and what is not finite.
pub fn unit(vector: Vec3) -> Option<Vec3> {
    let size = vector.abs().max_element();
    (vector.is_finite() && size > 0.0).then(|| (vector / size).normalize())
}

/// The angle between unit vectors in [0, π], from half the chord: accurate near 0 and π, where the arc cosine is not.
fn angle_between(a: Vec3, b: Vec3) -> f32 {
    if a.dot(b) < 0.0 {
        PI - 2.0 * (0.5 * (a + b).length()).min(1.0).asin()
    } else {
        2.0 * (0.5 * (b - a).length()).min(1.0).asin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_angle_counts_not_the_number_of_triangles() {
        // A cube corner whose top face is cut in two: by angle both halves weigh together as much as one side does.
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, Vec3::new(1.0, 1.0, 0.0)];
        let triangles = [[0, 1, 4], [0, 4, 2], [0, 2, 3], [0, 3, 1]];
        let normal = angle_weighted_normals(&positions, &triangles)[0];
        assert!((normal - Vec3::ONE.normalize()).length() < 1e-6, "{normal}");
    }

    #[test]
    fn triangles_without_area_and_lone_vertices_do_no_harm() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::splat(7.0), Vec3::X * 2.0];
        let normals = angle_weighted_normals(&positions, &[[0, 1, 2], [0, 1, 4], [1, 1, 1]]);
        assert_eq!(normals[0], Vec3::Z);
        assert_eq!(normals[3], NORMAL_OF_LONE_VERTEX);
        assert_eq!(normals[4], NORMAL_OF_LONE_VERTEX);
    }

    #[test]
    fn tiny_and_huge_triangles_have_normals() {
        for scale in [1e-38, 1e-18, 1e18, 1e38] {
            let positions = [Vec3::ZERO, Vec3::X * scale, Vec3::Y * scale];
            assert_eq!(
                angle_weighted_normals(&positions, &[[0, 1, 2]]),
                [Vec3::Z; 3],
                "{scale}"
            );
        }
    }

    #[test]
    fn every_direction_has_unit_length() {
        for vector in [
            Vec3::MAX,
            Vec3::splat(f32::from_bits(1)),
            Vec3::new(1e-30, -2e-30, 1e-45),
            Vec3::new(3e38, 1.0, -1e-20),
        ] {
            let length = unit(vector).unwrap().length();
            assert!((length - 1.0).abs() < 1e-6, "{vector}: {length}");
        }
        for vector in [Vec3::ZERO, Vec3::NAN, Vec3::new(1.0, f32::INFINITY, 0.0)] {
            assert_eq!(unit(vector), None, "{vector}");
        }
    }

    #[test]
    fn angles_are_right_at_the_ends() {
        let nearly = Vec3::new(1.0, 1e-4, 0.0).normalize();
        assert!((angle_between(Vec3::X, nearly) - 1e-4).abs() < 1e-8);
        assert!((PI - angle_between(-Vec3::X, nearly) - 1e-4).abs() < 1e-6);
        assert!((angle_between(Vec3::X, Vec3::Y) - PI / 2.0).abs() < 1e-6);
    }
}
