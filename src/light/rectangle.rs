//! Rectangles (and parallelograms, the affine images of rectangles) that emit.

use glam::{Vec2, Vec3};

use super::hit::{AreaSample, SurfaceHit, SurfaceSample, solid_angle_pdf};
use super::lanes::SoleRectangle;
use crate::color::Rgb;
use crate::math::Aabb;
use crate::sampling::lanes::RectangleLanes;
use crate::sampling::{PiecewiseBilinear2d, Rectangle, SphericalRectangle};

/// A parallelogram `corner + a edge_u + b edge_v`, a and b in [0, 1].
#[derive(Clone, Debug)]
pub(super) struct RectangleLight {
    corner: Vec3,
    edge_u: Vec3,
    edge_v: Vec3,
    normal: Vec3,
    pdf_area: f32,
    /// The rectangle; None if it is another parallelogram, which is sampled by area.
    rectangle: Option<Rectangle>,
    /// The density over a and b, if it is not equally bright all over.
    density: Option<Box<PiecewiseBilinear2d>>,
}

impl RectangleLight {
    pub fn new(corner: Vec3, edge_u: Vec3, edge_v: Vec3, normal: Vec3) -> Self {
        Self {
            corner,
            edge_u,
            edge_v,
            normal,
            pdf_area: 1.0 / edge_u.cross(edge_v).length(),
            rectangle: Rectangle::new(corner, edge_u, edge_v),
            density: None,
        }
    }

    /// The light, sampled by a density over its parameters, which are the surface's uv.
    pub fn with_density(self, density: Option<PiecewiseBilinear2d>) -> Self {
        Self {
            density: density.map(Box::new),
            ..self
        }
    }

    /// Whether it is a rectangle, and no other parallelogram.
    pub fn is_rectangle(&self) -> bool {
        self.rectangle.is_some()
    }

    pub fn area(&self) -> f32 {
        1.0 / self.pdf_area
    }

    pub fn bounds(&self) -> Aabb {
        let opposite = self.corner + self.edge_u + self.edge_v;
        Aabb::from_points([
            self.corner,
            self.corner + self.edge_u,
            self.corner + self.edge_v,
            opposite,
        ])
    }

    pub fn normal(&self) -> Vec3 {
        self.normal
    }

    /// The point with these shares of the edges.
    pub fn at(&self, u: Vec2) -> Vec3 {
        self.corner + u.x * self.edge_u + u.y * self.edge_v
    }

    /// Samples a point by the density if there is one. Otherwise it is uniform in solid angle where the rectangle allows it, and else uniform in
    /// area.
    pub fn sample(&self, reference: Vec3, u: Vec2) -> Option<SurfaceSample> {
        if (reference - self.corner).dot(self.normal) <= 0.0 {
            return None;
        }
        match self.seen_from(reference) {
            Some(seen) if self.density.is_none() => Some(SurfaceSample {
                position: seen.sample(u),
                normal: self.normal,
                pdf_solid_angle: seen.pdf_solid_angle(),
            }),
            _ => self.sample_area(u).seen_from(reference),
        }
    }

    /// The rectangle in a form that is sampled from many places at once; None unless it is uniform in solid angle.
    pub fn sole(&self, radiance: Rgb, error: f32) -> Option<SoleRectangle> {
        let rectangle = self.rectangle.as_ref().filter(|_| self.density.is_none())?;
        Some(SoleRectangle {
            radiance,
            rectangle: RectangleLanes::new(rectangle),
            corner: self.corner,
            edges: [self.edge_u, self.edge_v],
            normal: self.normal,
            pdf_area: self.pdf_area,
            error,
        })
    }

    /// A point by the density if there is one, and else uniform in area.
    pub fn sample_area(&self, u: Vec2) -> AreaSample {
        let (place, pdf) = match &self.density {
            Some(density) => {
                let sample = density.sample(u);
                (sample.position, sample.pdf)
            }
            None => (u, 1.0),
        };
        AreaSample {
            position: self.at(place),
            normal: self.normal,
            pdf_area: self.pdf_area * pdf,
        }
    }

    /// Density per area of [`Self::sample_area`] at these texture coordinates.
    pub fn pdf_area(&self, uv: Vec2) -> f32 {
        self.pdf_area * self.density.as_ref().map_or(1.0, |density| density.pdf(uv))
    }

    fn seen_from(&self, reference: Vec3) -> Option<SphericalRectangle> {
        self.rectangle.as_ref()?.seen_from(reference)
    }

    pub fn pdf(&self, reference: Vec3, hit: &SurfaceHit) -> f32 {
        match self.seen_from(reference) {
            Some(seen) if self.density.is_none() => seen.pdf_solid_angle(),
            _ => solid_angle_pdf(self.pdf_area(hit.uv), hit.position, self.normal, reference),
        }
    }
}
