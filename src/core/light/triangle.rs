//! Triangles that emit: the parts of a mesh light.

use glam::{Vec2, Vec3};

use super::bounds::NormalCone;
use super::hit::{AreaSample, SurfaceHit, SurfaceSample, solid_angle_pdf};
use crate::accel::Instance;
use crate::geometry::mesh::MeshData;
use crate::math::Aabb;
use crate::sampling::{SphericalTriangle, warp};

#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleLight {
    /// The corners in world space.
    corners: [Vec3; 3],
    emission: Emission,
    /// The index of the triangle in the mesh.
    pub primitive: u32,
}

/// The side to which a triangle emits: that of the shading normal.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Emission {
    /// The same side all over: 1 for the one from which the corners run counter-clockwise, else -1.
    OneSide(f32),
    /// The shading normal decides at each point, because vertex normals are at an angle to the triangle. Seen from near
    /// its plane, either side can emit.
    ByShadingNormal,
    /// Both sides.
    BothWays,
}

/// Sine of the angle between a vertex normal and the triangle's normal up to which they count as parallel: the rounding
/// of four decimal digits.
const PARALLEL: f32 = 1e-4;

impl TriangleLight {
    /// The triangles of one material slot, in the order of the mesh.
    pub fn of_mesh(instance: &Instance, mesh: &MeshData, slot: u32, shines_both_ways: bool) -> Vec<Self> {
        let slot_of = |triangle: usize| mesh.material_of_triangle.get(triangle).copied().unwrap_or(0);
        (0..mesh.triangles.len())
            .filter(|&triangle| u32::from(slot_of(triangle)) == slot)
            .map(|triangle| {
                let primitive = triangle as u32;
                let place = &instance.world_from_local;
                let corners = mesh.corners(triangle).map(|p| place.transform_point3(p));
                Self {
                    corners,
                    emission: match shines_both_ways {
                        true => Emission::BothWays,
                        false => Emission::of(instance, primitive, corners),
                    },
                    primitive,
                }
            })
            .collect()
    }

    /// The normal on the emitting side, if there is only one, with twice the area as its length.
    fn scaled_normal(&self) -> Vec3 {
        match self.emission {
            Emission::OneSide(side) => side * counter_clockwise_normal(self.corners),
            Emission::ByShadingNormal | Emission::BothWays => counter_clockwise_normal(self.corners),
        }
    }

    /// Unit normal on the emitting side. None for a degenerate triangle, and where either side can emit.
    pub fn emitting_normal(&self) -> Option<Vec3> {
        match self.emission {
            Emission::OneSide(_) => self.scaled_normal().try_normalize(),
            Emission::ByShadingNormal | Emission::BothWays => None,
        }
    }

    /// Whether directions to the triangle find light only where the shading normal says so.
    pub fn emits_by_shading_normal(&self) -> bool {
        self.emission == Emission::ByShadingNormal
    }

    pub fn area(&self) -> f32 {
        0.5 * self.scaled_normal().length()
    }

    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(self.corners)
    }

    /// A cone around the shading normals of the triangle, which belongs to `smooth` if it emits by shading normals.
    pub fn normals(&self, smooth: Option<&Instance>) -> NormalCone {
        let (Emission::ByShadingNormal, Some(instance)) = (self.emission, smooth) else {
            return self.emitting_normal().map_or(NormalCone::ALL, NormalCone::single);
        };
        let [a, b, c] = corner_normals(instance, self.primitive).map(|normal| normal.map(NormalCone::single));
        match (a, b, c) {
            (Some(a), Some(b), Some(c)) => {
                let cone = a.union(b).union(c);
                // Only a cone narrower than a right angle holds all normals interpolated between the three.
                if cone.cos_angle > 0.0 { cone } else { NormalCone::ALL }
            }
            _ => NormalCone::ALL,
        }
    }

    /// Samples uniformly in solid angle where the triangle looks large, else uniformly in area.
    pub fn sample(&self, reference: Vec3, u: Vec2) -> Option<SurfaceSample> {
        let mut normal = self.scaled_normal().try_normalize()?;
        let height = (reference - self.corners[0]).dot(normal);
        match self.emission {
            Emission::OneSide(_) if height <= 0.0 => return None,
            Emission::OneSide(_) => {}
            Emission::ByShadingNormal | Emission::BothWays => normal *= height.signum(),
        }
        if let Some(seen) = SphericalTriangle::new(self.corners, reference) {
            return Some(SurfaceSample {
                position: seen.sample(u),
                normal,
                pdf_solid_angle: seen.pdf_solid_angle(),
            });
        }
        let sample = AreaSample {
            position: self.at(u),
            normal,
            pdf_area: 1.0 / self.area(),
        };
        Some(sample.seen_from(reference))
    }

    /// The normal on the emitting side, or on either if both can emit.
    pub fn normal(&self) -> Option<Vec3> {
        self.scaled_normal().try_normalize()
    }

    /// A point that is uniform in area.
    pub fn at(&self, u: Vec2) -> Vec3 {
        let [p0, p1, p2] = self.corners;
        let b = warp::uniform_triangle(u);
        p0 + b.x * (p1 - p0) + b.y * (p2 - p0)
    }

    /// Whether light goes from `position` on this triangle of `smooth` to `reference`; [`Self::sample`] has found it
    /// possible.
    pub fn shines(&self, smooth: &Instance, position: Vec3, reference: Vec3) -> bool {
        if self.emission != Emission::ByShadingNormal {
            return true;
        }
        (reference - position).dot(self.shading_normal(smooth, position)) > 0.0
    }

    /// The shading normal at a point of the triangle, which belongs to `smooth`. Not of unit length.
    pub fn shading_normal(&self, smooth: &Instance, position: Vec3) -> Vec3 {
        smooth
            .shading_normal(self.primitive, self.barycentric(position))
            .unwrap_or_else(|| flip(smooth) * counter_clockwise_normal(self.corners))
    }

    /// The weights of the corners 1 and 2 at a point of the triangle.
    pub fn barycentric(&self, position: Vec3) -> Vec2 {
        let [p0, p1, p2] = self.corners;
        let normal = counter_clockwise_normal(self.corners);
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

impl Emission {
    fn of(instance: &Instance, triangle: u32, corners: [Vec3; 3]) -> Self {
        let [Some(a), Some(b), Some(c)] = corner_normals(instance, triangle) else {
            return Self::OneSide(flip(instance));
        };
        let Some(normal) = counter_clockwise_normal(corners).try_normalize() else {
            return Self::OneSide(flip(instance));
        };
        let side = a.dot(normal).signum();
        let is_like = |vertex: Vec3| vertex.dot(normal) * side > 0.0 && vertex.cross(normal).length() < PARALLEL;
        if [a, b, c].into_iter().all(is_like) {
            Self::OneSide(side)
        } else {
            Self::ByShadingNormal
        }
    }
}

/// The sign of the geometric normal: -1 where it is flipped, else 1.
fn flip(instance: &Instance) -> f32 {
    if instance.flip_normals { -1.0 } else { 1.0 }
}

/// The shading normals at the corners; None where the geometric normal is used.
fn corner_normals(instance: &Instance, triangle: u32) -> [Option<Vec3>; 3] {
    [Vec2::ZERO, Vec2::X, Vec2::Y].map(|corner| instance.shading_normal(triangle, corner))
}

/// The normal on the side from which the corners run counter-clockwise, with twice the area as its length.
fn counter_clockwise_normal([p0, p1, p2]: [Vec3; 3]) -> Vec3 {
    (p1 - p0).cross(p2 - p0)
}
