//! Tangents of meshes with normal maps. In glTF the bitangent follows the handedness of the texture coordinates, here
//! it does so only if the material says it: otherwise mirrored triangles get a picture of their own.

use bevy::math::{Affine3A, Vec2, Vec3, Vec4};

use super::form::Form;
use crate::geometry::attribute::{AttributeValues, MeshAttribute};
use crate::geometry::mesh::{MeshData, TANGENT, TANGENT_SIGN};

/// The vertex indices of all triangles of a form, in the order and winding in which they are written.
pub(super) fn written_corners(form: &Form, is_unwelded: bool, runs_backwards: bool) -> impl Iterator<Item = [u32; 3]> {
    let corners = form.mesh.triangles.iter().enumerate();
    corners.map(move |(triangle, corners)| {
        let [a, b, c] = match is_unwelded {
            true => [0, 1, 2].map(|corner| 3 * triangle as u32 + corner),
            false => *corners,
        };
        if runs_backwards { [a, c, b] } else { [a, b, c] }
    })
}

/// For each of these triangles whether its picture is mirrored, as seen from the side of its normals.
pub(super) fn mirrored(mesh: &MeshData, corners: impl Iterator<Item = [u32; 3]>) -> Vec<bool> {
    let is_mirrored = |triangle: [u32; 3]| {
        let Some([du, dv]) = derivatives(mesh, triangle) else {
            return false;
        };
        let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
        let normal = match mesh.normals.is_empty() {
            true => (b - a).cross(c - a),
            false => triangle.map(|corner| mesh.normals[corner as usize]).into_iter().sum(),
        };
        // v points down in pictures.
        du.cross(dv).dot(normal) > 0.0
    };
    corners.map(is_mirrored).collect()
}

/// The derivatives of a triangle's position by u and by v, zero if its area in uv is zero; None without texture
/// coordinates.
fn derivatives(mesh: &MeshData, triangle: [u32; 3]) -> Option<[Vec3; 2]> {
    let [p, q, r] = triangle.map(|corner| mesh.positions[corner as usize]);
    let [a, b, c]: [Option<&Vec2>; 3] = triangle.map(|corner| mesh.uvs.get(corner as usize));
    let (a, b, c) = (*a?, *b?, *c?);
    let (to_b, to_c) = (b - a, c - a);
    let determinant = to_b.perp_dot(to_c);
    let side = if determinant == 0.0 { 0.0 } else { determinant.signum() };
    let by_u = to_c.y * (q - p) - to_b.y * (r - p);
    let by_v = to_b.x * (r - p) - to_c.x * (q - p);
    Some([by_u, by_v].map(|direction| side * direction.normalize_or_zero()))
}

/// A tangent for each vertex, from the triangles around it that are mirrored, or from those that are not: the mean of
/// the directions of u, weighted by the angles of the triangles, as in MikkTSpace. None without normals, or without
/// coordinates.
pub(super) fn of_coordinates(
    mesh: &MeshData,
    corners: impl Iterator<Item = [u32; 3]>,
    mirrored: &[bool],
    of_mirrored: bool,
) -> Option<Vec<Vec4>> {
    if mesh.normals.is_empty() || mesh.uvs.is_empty() {
        return None;
    }
    let mut sums = vec![Vec3::ZERO; mesh.positions.len()];
    for (triangle, _) in corners.zip(mirrored).filter(|(_, is)| **is == of_mirrored) {
        let Some([du, _]) = derivatives(mesh, triangle) else {
            continue;
        };
        for corner in 0..3 {
            let [at, next, last] = [0, 1, 2].map(|step| triangle[(corner + step) % 3] as usize);
            let edge = |other: usize| (mesh.positions[other] - mesh.positions[at]).normalize_or_zero();
            let angle = edge(next).dot(edge(last)).clamp(-1.0, 1.0).acos();
            let normal = mesh.normals[at];
            sums[at] += angle * (du - normal * normal.dot(du)).normalize_or_zero();
        }
    }
    let sign = if of_mirrored { -1.0 } else { 1.0 };
    let across = |(sum, normal): (Vec3, &Vec3)| {
        let tangent = sum.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
        tangent.extend(sign)
    };
    Some(sums.into_iter().zip(&mesh.normals).map(across).collect())
}

/// The mesh's own tangents, for its written vertices. None if it has none.
pub(super) fn of_mesh(form: &Form, baked: Option<Affine3A>, is_turned: bool, is_unwelded: bool) -> Option<Vec<Vec4>> {
    let source = &form.mesh;
    let numbers = |attribute: &'_ MeshAttribute| match &attribute.values {
        AttributeValues::F32(numbers) => Some(numbers.clone()),
        AttributeValues::Srgb8(_) => None,
    };
    let directions = source
        .attribute(TANGENT)
        .filter(|it| it.channels == 3)
        .and_then(numbers)?;
    let signs = source
        .attribute(TANGENT_SIGN)
        .filter(|it| it.channels == 1)
        .and_then(numbers)?;
    let is_whole = directions.len() == 3 * source.positions.len() && signs.len() == source.positions.len();
    if !is_whole || form.is_flat || source.normals.is_empty() || source.uvs.is_empty() {
        return None;
    }
    let map = baked.unwrap_or(Affine3A::IDENTITY);
    let turn = if is_turned != (map.matrix3.determinant() < 0.0) {
        -1.0
    } else {
        1.0
    };
    let tangent = |vertex: usize| {
        let direction = Vec3::new(
            directions[3 * vertex],
            directions[3 * vertex + 1],
            directions[3 * vertex + 2],
        );
        let placed = map.transform_vector3(direction).try_normalize().unwrap_or(Vec3::X);
        placed.extend(if signs[vertex] < 0.0 { -turn } else { turn })
    };
    Some(match is_unwelded {
        true => source
            .triangles
            .as_flattened()
            .iter()
            .map(|vertex| tangent(*vertex as usize))
            .collect(),
        false => (0..source.positions.len()).map(tangent).collect(),
    })
}
