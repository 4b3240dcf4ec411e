//! Meshes that emit, sampled uniformly by area.

use glam::{Affine3A, Vec2, Vec3};

use super::surface::SurfaceSample;
use crate::geometry::mesh::MeshData;
use crate::sampling::{DiscreteDistribution, warp};

#[derive(Clone, Debug)]
pub(super) struct MeshLight {
    /// World-space corners of the emitting triangles.
    triangles: Vec<[Vec3; 3]>,
    choice: DiscreteDistribution,
    area: f32,
    side: f32,
}

impl MeshLight {
    /// The triangles of one material slot; None when they have no area.
    pub fn new(mesh: &MeshData, slot: u32, world_from_local: &Affine3A, side: f32) -> Option<Self> {
        let slot_of = |triangle: usize| mesh.material_of_triangle.get(triangle).copied().unwrap_or(0);
        let triangles: Vec<[Vec3; 3]> = (0..mesh.triangles.len())
            .filter(|&triangle| u32::from(slot_of(triangle)) == slot)
            .map(|triangle| mesh.corners(triangle).map(|p| world_from_local.transform_point3(p)))
            .collect();
        let areas: Vec<f32> = triangles.iter().map(|corners| 0.5 * normal(corners).length()).collect();
        let choice = DiscreteDistribution::in_proportion(&areas)?;
        Some(Self {
            area: areas.iter().map(|&area| f64::from(area)).sum::<f64>() as f32,
            triangles,
            choice,
            side,
        })
    }

    pub fn area(&self) -> f32 {
        self.area
    }

    pub fn sample(&self, reference: Vec3, u: Vec2) -> Option<SurfaceSample> {
        let chosen = self.choice.sample(u.x);
        let corners = &self.triangles[chosen.index as usize];
        let b = warp::uniform_triangle(Vec2::new(chosen.remapped_u, u.y));
        let [p0, p1, p2] = *corners;
        let position = p0 + b.x * (p1 - p0) + b.y * (p2 - p0);
        let normal = self.side * normal(corners).normalize_or_zero();
        SurfaceSample::from_area(position, normal, 1.0 / self.area, reference)
    }
}

/// Perpendicular to the triangle, as long as twice its area.
fn normal([p0, p1, p2]: &[Vec3; 3]) -> Vec3 {
    (p1 - p0).cross(p2 - p0)
}
