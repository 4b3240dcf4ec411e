//! Meshes of analytic shapes: in their own space, with the texture coordinates and normals of the shapes.

use std::f32::consts::{PI, TAU};

use bevy::math::{Affine3A, Mat3, Mat3A, Vec2, Vec3};

use super::solid_mesh::solid_mesh;
use crate::geometry::mesh::MeshData;
use crate::geometry::primitives::unit_cube;
use crate::math::Frame;
use crate::scene::ShapeKind;

/// The segments of a circle.
const AROUND: u32 = 64;
/// The rows of a sphere from pole to pole.
const ROWS: u32 = 32;

/// The mesh of a shape; None for a mesh file, and for a shape without a surface. Round shapes have 64 segments.
pub fn shape_mesh(kind: &ShapeKind) -> Option<MeshData> {
    Some(match kind {
        ShapeKind::Sphere { center, radius } => grid(AROUND, ROWS, |at| {
            let (theta, phi) = (PI * at.y, TAU * at.x);
            let normal = Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
            (*center + *radius * normal, normal)
        }),
        ShapeKind::Rectangle => grid(1, 1, |at| (Vec3::new(2.0 * at.x - 1.0, 2.0 * at.y - 1.0, 0.0), Vec3::Z)),
        // u is the distance from the centre, v the angle.
        ShapeKind::Disk => grid(1, AROUND, |at| {
            let angle = TAU * at.y;
            (at.x * Vec3::new(angle.cos(), angle.sin(), 0.0), Vec3::Z)
        }),
        ShapeKind::Cylinder { p0, p1, radius } => {
            let axis = *p1 - *p0;
            let Frame { s, t, n } = Frame::from_normal(axis.try_normalize()?);
            let axes = Mat3::from_cols(s, t, n);
            grid(AROUND, 1, |at| {
                let angle = TAU * at.x;
                let normal = axes * Vec3::new(angle.cos(), angle.sin(), 0.0);
                (*p0 + at.y * axis + *radius * normal, normal)
            })
        }
        ShapeKind::Cube => unit_cube(),
        ShapeKind::Triangle { corners: [a, b, c] } => MeshData {
            positions: vec![*a, *b, *c],
            normals: vec![(*b - *a).cross(*c - *a).try_normalize()?; 3],
            uvs: vec![Vec2::ZERO, Vec2::X, Vec2::Y],
            triangles: vec![[0, 1, 2]],
            ..MeshData::default()
        },
        ShapeKind::Solid(part) => solid_mesh(part),
        ShapeKind::Mesh(_) | ShapeKind::Instance | ShapeKind::Frame => return None,
    })
}

/// A grid over uv from 0 to 1, with the position and the normal at each of its points. Triangles face along the
/// normals.
fn grid(columns: u32, rows: u32, at: impl Fn(Vec2) -> (Vec3, Vec3)) -> MeshData {
    let mut mesh = MeshData::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let uv = Vec2::new(column as f32 / columns as f32, row as f32 / rows as f32);
            let (position, normal) = at(uv);
            mesh.positions.push(position);
            mesh.normals.push(normal);
            mesh.uvs.push(uv);
        }
    }
    let index = |column: u32, row: u32| row * (columns + 1) + column;
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [index(column, row), index(column + 1, row)];
            let [d, c] = [index(column, row + 1), index(column + 1, row + 1)];
            for mut triangle in [[a, b, c], [a, c, d]] {
                let [p, q, r] = triangle.map(|corner| mesh.positions[corner as usize]);
                let facing = (q - p).cross(r - p);
                // The triangles at the poles of a sphere and in the centre of a disk have no area.
                if facing.length_squared() <= 1e-12 * (q - p).length_squared().max((r - p).length_squared()).powi(2) {
                    continue;
                }
                let normals: Vec3 = triangle.iter().map(|corner| mesh.normals[*corner as usize]).sum();
                if facing.dot(normals) < 0.0 {
                    triangle.swap(1, 2);
                }
                mesh.triangles.push(triangle);
            }
        }
    }
    mesh
}

/// The shape of unit size with the same form, and the transform from its space to that of the shape: spheres and
/// cylinders of all sizes are alike.
pub(crate) fn unit_form(kind: &ShapeKind) -> (ShapeKind, Affine3A) {
    match kind {
        ShapeKind::Sphere { center, radius } => {
            let unit = ShapeKind::Sphere {
                center: Vec3::ZERO,
                radius: 1.0,
            };
            let scale = Affine3A::from_scale(Vec3::splat(*radius));
            (unit, Affine3A::from_translation(*center) * scale)
        }
        ShapeKind::Cylinder { p0, p1, radius } => {
            let unit = ShapeKind::Cylinder {
                p0: Vec3::ZERO,
                p1: Vec3::Z,
                radius: 1.0,
            };
            let axis = *p1 - *p0;
            let Frame { s, t, n } = Frame::from_normal(axis.try_normalize().unwrap_or(Vec3::Z));
            let axes = [s * *radius, t * *radius, n * axis.length()].map(bevy::math::Vec3A::from);
            let map = Affine3A {
                matrix3: Mat3A::from_cols(axes[0], axes[1], axes[2]),
                translation: (*p0).into(),
            };
            (unit, map)
        }
        other => (other.clone(), Affine3A::IDENTITY),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(kind: &ShapeKind) -> f32 {
        let mesh = shape_mesh(kind).expect("it has one");
        (0..mesh.triangles.len())
            .map(|triangle| mesh.area_of_triangle(triangle))
            .sum()
    }

    #[test]
    fn meshes_have_nearly_the_area_of_their_shapes() {
        let sphere = ShapeKind::Sphere {
            center: Vec3::X,
            radius: 2.0,
        };
        let cylinder = ShapeKind::Cylinder {
            p0: Vec3::ZERO,
            p1: Vec3::new(0.0, 3.0, 0.0),
            radius: 0.5,
        };
        for (kind, expected) in [
            (sphere, 16.0 * PI),
            (cylinder, 3.0 * PI),
            (ShapeKind::Disk, PI),
            (ShapeKind::Rectangle, 4.0),
            (ShapeKind::Cube, 24.0),
        ] {
            let found = area(&kind);
            assert!(
                (found - expected).abs() < 0.01 * expected,
                "{kind:?}: {found}, not {expected}"
            );
        }
    }

    #[test]
    fn triangles_face_where_the_normals_point() {
        let sphere = ShapeKind::Sphere {
            center: Vec3::ZERO,
            radius: 1.0,
        };
        for kind in [sphere, ShapeKind::Disk, ShapeKind::Rectangle] {
            let mesh = shape_mesh(&kind).expect("it has one");
            for (index, triangle) in mesh.triangles.iter().enumerate() {
                let [a, b, c] = mesh.corners(index);
                assert!(
                    (b - a).cross(c - a).dot(mesh.normals[triangle[0] as usize]) > 0.0,
                    "{kind:?}"
                );
            }
        }
    }
}
