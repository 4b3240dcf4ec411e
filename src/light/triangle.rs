//! Triangles that emit: the parts of a mesh light.

use glam::{Affine3A, Vec2, Vec3};

use super::bounds::NormalCone;
use super::surface::{SurfaceHit, SurfaceSample, solid_angle_pdf};
use crate::geometry::mesh::MeshData;
use crate::math::Aabb;
use crate::sampling::{SphericalTriangle, warp};

#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleLight {
    /// World space.
    corners: [Vec3; 3],
    /// 1 when it emits to the side from which the corners are seen counter-clockwise, else -1.
    side: f32,
    /// Which triangle of the mesh it is.
    pub primitive: u32,
}

impl TriangleLight {
    /// The triangles of one material slot, in the order of the mesh.
    pub fn of_mesh(mesh: &MeshData, slot: u32, world_from_local: &Affine3A, side: f32) -> Vec<Self> {
        let slot_of = |triangle: usize| mesh.material_of_triangle.get(triangle).copied().unwrap_or(0);
        (0..mesh.triangles.len())
            .filter(|&triangle| u32::from(slot_of(triangle)) == slot)
            .map(|triangle| Self {
                corners: mesh.corners(triangle).map(|p| world_from_local.transform_point3(p)),
                side,
                primitive: triangle as u32,
            })
            .collect()
    }

    /// Perpendicular to the triangle on the emitting side, as long as twice its area.
    fn scaled_normal(&self) -> Vec3 {
        let [p0, p1, p2] = self.corners;
        self.side * (p1 - p0).cross(p2 - p0)
    }

    /// None for a degenerate triangle.
    pub fn normal(&self) -> Option<Vec3> {
        self.scaled_normal().try_normalize()
    }

    pub fn area(&self) -> f32 {
        0.5 * self.scaled_normal().length()
    }

    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(self.corners)
    }

    pub fn normals(&self) -> NormalCone {
        self.normal().map_or(NormalCone::ALL, NormalCone::single)
    }

    /// Uniform in solid angle where the triangle looks large, else uniform in area.
    pub fn sample(&self, reference: Vec3, u: Vec2) -> Option<SurfaceSample> {
        let [p0, p1, p2] = self.corners;
        let normal = self.normal()?;
        if (reference - p0).dot(normal) <= 0.0 {
            return None;
        }
        if let Some(seen) = SphericalTriangle::new(self.corners, reference) {
            return Some(SurfaceSample {
                position: seen.sample(u),
                normal,
                pdf_solid_angle: seen.pdf_solid_angle(),
            });
        }
        let b = warp::uniform_triangle(u);
        let position = p0 + b.x * (p1 - p0) + b.y * (p2 - p0);
        SurfaceSample::from_area(position, normal, 1.0 / self.area(), reference)
    }

    /// Weights of the corners 1 and 2 at a point of the triangle.
    pub fn barycentric(&self, position: Vec3) -> Vec2 {
        let [p0, p1, p2] = self.corners;
        let normal = (p1 - p0).cross(p2 - p0);
        let weight = |a: Vec3, b: Vec3| a.cross(b).dot(normal) / normal.length_squared();
        Vec2::new(weight(position - p0, p2 - p0), weight(p1 - p0, position - p0))
    }

    pub fn pdf(&self, reference: Vec3, hit: &SurfaceHit) -> f32 {
        match SphericalTriangle::new(self.corners, reference) {
            Some(seen) => seen.pdf_solid_angle(),
            None => solid_angle_pdf(1.0 / self.area(), hit.position, hit.normal, reference),
        }
    }
}
