//! Points on emitting surfaces: those that rays hit and those that sampling chooses.

use glam::{Vec2, Vec3};

use crate::accel::{Hit, SurfacePoint};

/// A place on a surface as the density of a light needs it, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// The point on the surface.
    pub position: Vec3,
    /// Unit geometric normal.
    pub normal: Vec3,
    /// Unit shading normal, on the side that shines.
    pub shading_normal: Vec3,
    /// The mesh's triangle; zero for other shapes.
    pub primitive: u32,
    /// The weights of the triangle's corners 1 and 2; zero for other shapes.
    pub barycentric: Vec2,
    /// The surface coordinates, for textured light.
    pub uv: Vec2,
}

impl SurfaceHit {
    /// The place that a ray has met.
    pub fn at(hit: &Hit, point: &SurfacePoint) -> Self {
        Self {
            position: point.position,
            normal: point.geometric_normal,
            shading_normal: point.shading_normal,
            primitive: hit.primitive,
            barycentric: Vec2::new(hit.u, hit.v),
            uv: point.uv,
        }
    }
}

/// A point chosen on an emitter, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SurfaceSample {
    pub position: Vec3,
    /// Unit normal of the surface, to the side of the reference point.
    pub normal: Vec3,
    /// Density per solid angle as seen from the reference point.
    pub pdf_solid_angle: f32,
}

/// A point chosen on an emitter without regard to who looks at it, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AreaSample {
    pub position: Vec3,
    /// Unit normal on the side that shines, or on either if both can.
    pub normal: Vec3,
    /// Density per area.
    pub pdf_area: f32,
}

impl AreaSample {
    /// The sample with the normal on the side of a place, for a surface that shines to both.
    pub fn facing(self, reference: Vec3) -> Self {
        let is_behind = (reference - self.position).dot(self.normal) < 0.0;
        Self {
            normal: if is_behind { -self.normal } else { self.normal },
            ..self
        }
    }

    /// The sample as seen from a place; None if the point shows its back or its edge.
    pub fn seen_from(self, reference: Vec3) -> Option<SurfaceSample> {
        SurfaceSample::from_area(self.position, self.normal, self.pdf_area, reference)
    }
}

impl SurfaceSample {
    /// A sample from a density per area; None if the point shows its back or its edge.
    pub fn from_area(position: Vec3, normal: Vec3, pdf_area: f32, reference: Vec3) -> Option<Self> {
        if (reference - position).dot(normal) <= 0.0 {
            return None;
        }
        let pdf_solid_angle = solid_angle_pdf(pdf_area, position, normal, reference);
        (pdf_solid_angle > 0.0 && pdf_solid_angle.is_finite()).then_some(Self {
            position,
            normal,
            pdf_solid_angle,
        })
    }
}

/// Density per area to density per solid angle at `reference`: times distance squared over the cosine; infinite edge-on.
pub(super) fn solid_angle_pdf(pdf_area: f32, position: Vec3, normal: Vec3, reference: Vec3) -> f32 {
    let to_reference = reference - position;
    let distance_squared = to_reference.length_squared();
    let cos = to_reference.dot(normal).abs() / distance_squared.sqrt();
    pdf_area * distance_squared / cos
}
