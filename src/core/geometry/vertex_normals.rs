//! Smooth vertex normals from the triangles around each vertex, for files without normals.
//!
//! Each triangle adds its unit normal, weighted by its interior angle at the vertex (Thürmer and Wüthrich, "Computing
//! vertex normals from polygonal facets", Journal of Graphics Tools 3(1), 1998). Mitsuba 3.9 does the same when a mesh
//! file has no normals and `face_normals` is off, so pictures agree.

use glam::Vec3;
use rayon::prelude::*;
use wide::{f32x4, u32x4};

/// The normal of a vertex without triangles that have an area; no ray sees it, but it has unit length all the same.
pub(crate) const NORMAL_OF_LONE_VERTEX: Vec3 = Vec3::X;

/// The number of triangles that are computed at once.
const LANES: usize = 4;

/// The least number of triangles for several threads: smaller meshes are done before other threads have woken up.
const FEWEST_TO_SHARE: usize = 1 << 13;

/// One unit normal for each position. Every index must be below `positions.len()`.
///
/// Triangles without area do not count; a vertex whose triangles cancel out, or that has none, gets
/// [`NORMAL_OF_LONE_VERTEX`]. Each thread has a range of vertices, and adds their triangles in order: the sums do not
/// depend on the number of threads.
pub(crate) fn angle_weighted_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    let shares = match triangles.len() {
        0..FEWEST_TO_SHARE => 1,
        _ => rayon::current_num_threads(),
    };
    let share = positions.len().div_ceil(shares).max(1);
    sums.par_chunks_mut(share).enumerate().for_each(|(i, sums)| {
        add_normals(positions, triangles, i * share, sums);
        for sum in sums {
            *sum = unit(*sum).unwrap_or(NORMAL_OF_LONE_VERTEX);
        }
    });
    sums
}

/// Adds the weighted normals of all triangles to `sums`, which belong to the vertices from `first` on.
fn add_normals(positions: &[Vec3], triangles: &[[u32; 3]], first: usize, sums: &mut [Vec3]) {
    // There are at most as many vertices as indices.
    let (first, count) = (first as u32, sums.len() as u32);
    let is_here = |vertex: u32| vertex.wrapping_sub(first) < count;
    for block in triangles.chunks(LANES) {
        if !block
            .as_flattened()
            .iter()
            .fold(false, |any, &vertex| any | is_here(vertex))
        {
            continue;
        }
        let Weighted { normal, angles } = weighted(positions, block);
        let [x, y, z] = [normal[0].to_array(), normal[1].to_array(), normal[2].to_array()];
        let angles = [angles[0].to_array(), angles[1].to_array(), angles[2].to_array()];
        for (lane, triangle) in block.iter().enumerate() {
            let normal = Vec3::new(x[lane], y[lane], z[lane]);
            // The normal is NaN if the area is zero.
            if !normal.is_finite() {
                continue;
            }
            for (&vertex, angle) in triangle.iter().zip(&angles) {
                if is_here(vertex) {
                    sums[(vertex - first) as usize] += normal * angle[lane];
                }
            }
        }
    }
}

/// The normals and angles of [`LANES`] triangles.
struct Weighted {
    normal: [f32x4; 3],
    /// The angle at each corner, in [0, π].
    angles: [f32x4; 3],
}

/// Computes the normals and angles of at most [`LANES`] triangles. Edges are scaled by a power of two to lengths around
/// 1, then so is their cross product, so that nothing under- or overflows. The tangent of an angle is the length of the
/// cross product, the same at all corners, over the dot product.
#[inline(always)]
fn weighted(positions: &[Vec3], block: &[[u32; 3]]) -> Weighted {
    // Lanes beyond the end of the mesh are never read.
    let triangle = |lane: usize| block[lane.min(block.len() - 1)];
    let triangles = [triangle(0), triangle(1), triangle(2), triangle(3)];
    let corner = |k: usize| {
        let position = |lane: usize| positions[triangles[lane][k] as usize];
        let (p, q, r, s) = (position(0), position(1), position(2), position(3));
        [[p.x, q.x, r.x, s.x], [p.y, q.y, r.y, s.y], [p.z, q.z, r.z, s.z]].map(f32x4::new)
    };
    let corners = [corner(0), corner(1), corner(2)];
    let [a, b, c] = [
        sub(corners[1], corners[0]),
        sub(corners[2], corners[1]),
        sub(corners[0], corners[2]),
    ];
    let (_, to_one) = power_of_two(largest(a).fast_max(largest(b)).fast_max(largest(c)));
    let [a, b, c] = [scaled(a, to_one), scaled(b, to_one), scaled(c, to_one)];
    let normal = cross(c, a);
    let (size, to_one) = power_of_two(largest(normal));
    let normal = scaled(normal, to_one);
    let length = dot(normal, normal).sqrt();
    let double_area = length * size;
    let angle = |before, after| double_area.atan2(-dot(before, after));
    Weighted {
        normal: scaled(normal, f32x4::ONE / length),
        angles: [angle(c, a), angle(a, b), angle(b, c)],
    }
}

#[inline(always)]
fn sub(a: [f32x4; 3], b: [f32x4; 3]) -> [f32x4; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn scaled(v: [f32x4; 3], factor: f32x4) -> [f32x4; 3] {
    [v[0] * factor, v[1] * factor, v[2] * factor]
}

/// The power of two at or below a positive number, and its inverse; 0 and 2^127 below 2^-126, 2^127 and 0 from 2^127
/// on.
#[inline(always)]
fn power_of_two(x: f32x4) -> (f32x4, f32x4) {
    let exponent = bytemuck::cast::<_, u32x4>(x) & u32x4::splat(0xff << 23);
    (
        bytemuck::cast(exponent),
        bytemuck::cast(u32x4::splat(254 << 23) - exponent),
    )
}

#[inline(always)]
fn dot(a: [f32x4; 3], b: [f32x4; 3]) -> f32x4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross(a: [f32x4; 3], b: [f32x4; 3]) -> [f32x4; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[inline(always)]
fn largest(v: [f32x4; 3]) -> f32x4 {
    v[0].abs().fast_max(v[1].abs()).fast_max(v[2].abs())
}

/// The unit vector along `vector` for any length, even if its square is beyond an `f32`; `None` for zero and vectors
/// that are not finite.
pub fn unit(vector: Vec3) -> Option<Vec3> {
    let square = vector.length_squared();
    if (1e-30..1e30).contains(&square) {
        return Some(vector / square.sqrt());
    }
    let size = vector.abs().max_element();
    (vector.is_finite() && size > 0.0).then(|| (vector / size).normalize())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn the_angle_counts_not_the_number_of_triangles() {
        // It is a cube corner whose top face is cut in two: by angle both halves weigh together as much as one side
        // does.
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

    /// The definition, in f64.
    fn expected(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; positions.len()];
        for triangle in triangles {
            let corners = triangle.map(|i| positions[i as usize].as_dvec3());
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            for k in 0..3 {
                let [at, next, last] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
                sums[triangle[k] as usize] += normal * (next - at).angle_between(last - at);
            }
        }
        sums.iter().map(|sum| sum.normalize()).collect()
    }

    /// A bumpy sheet in the given order of its rows, with long thin triangles where `step` is small.
    fn sheet(size: u32, step: f32, row: impl Fn(u32) -> u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let height = |i: u32, j: u32| 0.5 * (0.7 * i as f32).sin() + 0.3 * (1.3 * j as f32).cos();
        let mut positions = vec![Vec3::ZERO; (size * size) as usize];
        let index = |i: u32, j: u32| row(i) * size + j;
        let mut triangles = Vec::new();
        for i in 0..size {
            for j in 0..size {
                positions[index(i, j) as usize] = Vec3::new(i as f32, step * j as f32, height(i, j));
                if i + 1 < size && j + 1 < size {
                    let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        (positions, triangles)
    }

    #[test]
    fn normals_are_the_definitions() {
        // A cross product of edges at an angle of 0.01 loses a hundredth of its seven digits.
        for (step, tolerance) in [(1.0, 1e-5), (0.01, 3e-4)] {
            let (positions, triangles) = sheet(16, step, |row| row);
            let normals = angle_weighted_normals(&positions, &triangles);
            for (normal, expected) in normals.iter().zip(expected(&positions, &triangles)) {
                assert!(
                    (normal.as_dvec3() - expected).length() < tolerance,
                    "{step}: {normal} {expected}"
                );
            }
        }
    }

    #[test]
    fn sums_do_not_depend_on_the_number_of_threads() {
        // Rows are next to their neighbours, or far from them, so that all threads meet all triangles.
        for stride in [1, 37] {
            let (positions, triangles) = sheet(80, 1.0, |row| row * stride % 80);
            assert!(triangles.len() > FEWEST_TO_SHARE);
            let [one, three] = [1, 3].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .expect("a pool");
                pool.install(|| angle_weighted_normals(&positions, &triangles))
            });
            assert_eq!(one, three);
        }
    }
}
