//! Triangle meshes in place of curves, for formats that have none.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};

use super::curve::{Basis, Spline};
use super::mesh::MeshData;
use super::strands::Strands;
use crate::memory::{self, Shortage};

/// The corners of a cross-section and the rings of a segment of a spline, from fine to coarse.
const FINENESS: [[u32; 2]; 4] = [[8, 4], [6, 2], [4, 1], [3, 1]];

/// The reason why there are no tubes around curves.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum TubeError {
    /// They have more triangles at the coarsest than are allowed.
    #[error("more triangles than allowed")]
    TooMany,
    /// The memory budget does not suffice.
    #[error("they need {0}")]
    Memory(#[from] Shortage),
}

/// Bytes of a vertex: its position, normal and texture coordinates.
const VERTEX_BYTES: u64 = 32;
/// Bytes of a triangle.
const TRIANGLE_BYTES: u64 = 12;

/// Open tubes around the curves, with normals and with texture coordinates as curves have them. They are as fine as
/// `most` triangles allow, and their memory is reserved.
pub fn tubes(strands: &Strands, basis: Basis, most: usize) -> Result<MeshData, TubeError> {
    let segments = strands.segment_count(basis);
    let triangles = |[corners, rings]: [u32; 2]| 2 * segments as u64 * u64::from(corners * rings);
    let rings_of = |rings| match basis {
        Basis::BSpline => rings,
        Basis::Linear => 1,
    };
    let [corners, rings] = FINENESS
        .into_iter()
        .map(|[corners, rings]| [corners, rings_of(rings)])
        .find(|fineness| triangles(*fineness) <= most as u64)
        .ok_or(TubeError::TooMany)?;
    let rows = segments as u64 * u64::from(rings) + strands.firsts.len() as u64;
    let (vertices, triangles) = (rows * u64::from(corners + 1), triangles([corners, rings]));
    let memory = memory::reserve(VERTEX_BYTES * vertices + TRIANGLE_BYTES * triangles)?;
    let mut mesh = MeshData {
        positions: Vec::with_capacity(vertices as usize),
        normals: Vec::with_capacity(vertices as usize),
        uvs: Vec::with_capacity(vertices as usize),
        triangles: Vec::with_capacity(triangles as usize),
        memory: memory.into(),
        ..MeshData::default()
    };
    let mut before = 0;
    for curve in strands.curves() {
        let points = &strands.points[curve];
        let count = (points.len() + 1).saturating_sub(basis.points());
        if count == 0 {
            continue;
        }
        let steps = count as u32 * rings;
        let along: Vec<Vec4> = (0..=steps).map(|step| center(points, basis, step, rings)).collect();
        let v = |step: usize| (before as f32 + step as f32 / rings as f32) / segments as f32;
        add_tube(&mut mesh, &along, v, corners);
        before += count;
    }
    Ok(mesh)
}

/// The middle of a curve and its radius after `step` of `rings` steps for each segment.
fn center(points: &[Vec4], basis: Basis, step: u32, rings: u32) -> Vec4 {
    let (segment, part) = ((step / rings) as usize, (step % rings) as f32 / rings as f32);
    match basis {
        Basis::Linear => points[segment],
        Basis::BSpline => {
            // The end of the last segment.
            let (segment, part) = match segment + 3 < points.len() {
                true => (segment, part),
                false => (segment - 1, 1.0),
            };
            Spline::new(std::array::from_fn(|index| points[segment + index])).at(part)
        }
    }
}

fn add_tube(mesh: &mut MeshData, along: &[Vec4], v: impl Fn(usize) -> f32, corners: u32) {
    let first = mesh.positions.len() as u32;
    let mut across = Vec3::ZERO;
    for (step, point) in along.iter().enumerate() {
        let (before, after) = (along[step.saturating_sub(1)], along[(step + 1).min(along.len() - 1)]);
        let tangent = (after - before).xyz().try_normalize().unwrap_or(Vec3::Z);
        // Each ring is turned as little as possible against the one before.
        across = (across - tangent * tangent.dot(across))
            .try_normalize()
            .unwrap_or_else(|| tangent.any_orthonormal_vector());
        let other = tangent.cross(across);
        for corner in 0..=corners {
            let u = corner as f32 / corners as f32;
            let (sin, cos) = (TAU * u).sin_cos();
            let normal = cos * across + sin * other;
            mesh.positions.push(point.xyz() + point.w * normal);
            mesh.normals.push(normal);
            mesh.uvs.push(Vec2::new(u, v(step)));
        }
    }
    let row = corners + 1;
    for step in 0..along.len() as u32 - 1 {
        for corner in 0..corners {
            let [a, b] = [corner, corner + 1].map(|corner| first + step * row + corner);
            let [d, c] = [a + row, b + row];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight(points: usize) -> Strands {
        Strands {
            points: (0..points).map(|x| Vec4::new(x as f32, 0.0, 0.0, 0.5)).collect(),
            firsts: vec![0],
            shortest: (points as u32, 1),
        }
    }

    #[test]
    fn tubes_have_the_surface_of_their_curves() {
        for (basis, length, points) in [(Basis::BSpline, 3.0, 6), (Basis::Linear, 5.0, 6)] {
            let mesh = tubes(&straight(points), basis, 1000).unwrap();
            let area: f32 = (0..mesh.triangles.len())
                .map(|triangle| mesh.area_of_triangle(triangle))
                .sum();
            // No more vertices than memory was reserved for.
            assert!(
                mesh.positions.len() == mesh.positions.capacity() && mesh.triangles.len() == mesh.triangles.capacity()
            );
            // A polygon of eight corners has 97.4 % of the circle's circumference.
            assert!((area / (TAU * 0.5 * length) - 0.974).abs() < 1e-2, "{area}");
            for (index, triangle) in mesh.triangles.iter().enumerate() {
                let [a, b, c] = mesh.corners(index);
                assert!((b - a).cross(c - a).dot(mesh.normals[triangle[0] as usize]) > 0.0);
            }
        }
    }

    #[test]
    fn many_curves_are_coarse_and_too_many_are_none() {
        let strands = straight(6);
        let triangles = |basis, most| tubes(&strands, basis, most).unwrap().triangles.len();
        // Five segments with a ring each.
        assert_eq!(
            [80, 79, 59, 39].map(|most| triangles(Basis::Linear, most)),
            [80, 60, 40, 30]
        );
        // Three segments with four rings, two, and one.
        assert_eq!(
            [192, 191, 71, 23].map(|most| triangles(Basis::BSpline, most)),
            [192, 72, 24, 18]
        );
        assert_eq!(tubes(&strands, Basis::Linear, 29), Err(TubeError::TooMany));
    }
}
