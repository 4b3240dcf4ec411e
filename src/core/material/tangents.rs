//! Tangent space of glTF 2.0 (section 3.7.2.1): x is along the tangent and y along the bitangent, whose side follows
//! the handedness of the texture coordinates. Mitsuba's y is the shading normal times the direction of u, which is
//! opposite where coordinates are mirrored.

use glam::{DMat2, DVec2, Vec2, Vec3};

use crate::accel::SurfacePoint;
use crate::geometry::mesh::{MeshData, TANGENT, TANGENT_SIGN};
use crate::geometry::triangle;
use crate::math::Frame;
use crate::texture::MeshPoint;

/// A normal of a map, transformed to the shading frame `frame`. Tangents stored with the mesh replace the direction of
/// u.
pub(super) fn in_frame(normal: Vec3, point: &SurfacePoint, frame: &Frame, mesh: Option<MeshPoint>) -> Vec3 {
    // v points down in images, and the bitangent up.
    let of_coordinates = || {
        let is_mirrored = frame.t.dot(point.dp_dv) > 0.0;
        (Vec2::X, if is_mirrored { -1.0 } else { 1.0 })
    };
    let own = mesh.and_then(|at| own_tangent(&at, point, frame));
    let (tangent, side) = own.unwrap_or_else(of_coordinates);
    let across = normal.x * tangent + side * normal.y * tangent.perp();
    across.extend(normal.z)
}

/// The direction of the mesh's own tangent in the plane of the frame, and the side of the bitangent. None if the mesh
/// has no tangents.
fn own_tangent(at: &MeshPoint, point: &SurfacePoint, frame: &Frame) -> Option<(Vec2, f32)> {
    let mesh = at.mesh;
    let of_mesh = |name| {
        Some(
            mesh.attribute(name)?
                .value(&mesh.triangles, at.triangle, at.barycentric),
        )
    };
    let (own, sign) = (of_mesh(TANGENT)?, of_mesh(TANGENT_SIGN)?.x);
    let corners = mesh.triangles.get(at.triangle as usize)?;
    let [Some(&a), Some(&b), Some(&c)] = corners.map(|corner| mesh.uvs.get(corner as usize)) else {
        return None;
    };
    let (u, v) = (at.barycentric.y, at.barycentric.z);
    let local = triangle::parametrisation(mesh.corners(at.triangle as usize), u, v, Some([a, b, c]));
    // The world tangent is the same linear combination of the derivatives in world space.
    let (du, dv, own) = (local.dp_du.as_dvec3(), local.dp_dv.as_dvec3(), own.as_dvec3());
    let products = DMat2::from_cols_array(&[du.dot(du), du.dot(dv), du.dot(dv), dv.dot(dv)]);
    let along = products.inverse() * DVec2::new(own.dot(du), own.dot(dv));
    let world = (along.x * point.dp_du.as_dvec3() + along.y * point.dp_dv.as_dvec3()).as_vec3();
    let tangent = Vec2::new(frame.s.dot(world), frame.t.dot(world)).try_normalize()?;
    // Where the transform mirrors, or normals are flipped, the bitangent keeps its side of the texture coordinates.
    let normal = local_normal(mesh, at)?;
    let is_turned =
        (local.dp_du.cross(local.dp_dv).dot(normal) < 0.0) != (point.dp_du.cross(point.dp_dv).dot(frame.n) < 0.0);
    Some((tangent, if is_turned { -sign.signum() } else { sign.signum() }))
}

/// The shading normal in the space of the mesh, not of unit length.
fn local_normal(mesh: &MeshData, at: &MeshPoint) -> Option<Vec3> {
    let [a, b, c] = mesh.triangles[at.triangle as usize].map(|corner| mesh.normals.get(corner as usize));
    let weights = at.barycentric;
    Some(weights.x * *a? + weights.y * *b? + weights.z * *c?)
}
