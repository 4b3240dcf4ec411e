//! Rectangles (and parallelograms, the affine images of rectangles) that emit.

use glam::{Vec2, Vec3};

use super::hit::{AreaSample, SurfaceHit, SurfaceSample, solid_angle_pdf};
use crate::math::{Aabb, Mask, Real, Same, Vector, real_struct};
use crate::sampling::{PiecewiseBilinear2d, Rectangle};

/// A parallelogram `corner + a edge_u + b edge_v`, a and b in [0, 1].
#[derive(Clone, Debug)]
pub(super) struct RectangleLight {
    corner: Vec3,
    edge_u: Vec3,
    edge_v: Vec3,
    normal: Vec3,
    pdf_area: f32,
    /// The rectangle; None for a general parallelogram, which is sampled by area.
    rectangle: Option<Rectangle>,
    /// The density over a and b; None if the radiance is constant.
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

    /// The light with its points sampled by a density over its parameters, which are the surface's uv.
    pub fn with_density(self, density: Option<PiecewiseBilinear2d>) -> Self {
        Self {
            density: density.map(Box::new),
            ..self
        }
    }

    /// Whether it has right angles.
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

    /// The point at these fractions of the edges.
    #[inline(always)]
    pub fn at<R: Real>(&self, [a, b]: [R; 2]) -> R::Vec3 {
        R::Vec3::same(self.corner)
            .plus_scaled(a, R::Vec3::same(self.edge_u))
            .plus_scaled(b, R::Vec3::same(self.edge_v))
    }

    /// Samples a point by the density if there is one. Otherwise it is uniform in solid angle where the rectangle
    /// allows that, and else uniform in area.
    #[inline(always)]
    pub fn sample<R: Real>(&self, reference: R::Vec3, u: [R; 2]) -> SurfaceSample<R> {
        match self.uniform() {
            Some(uniform) => Same::<R>::same(uniform).sample(reference, u),
            None => self.sample_area(u).seen_from(reference),
        }
    }

    /// A point by the density if there is one, and else uniform in area.
    #[inline(always)]
    pub fn sample_area<R: Real>(&self, u: [R; 2]) -> AreaSample<R> {
        let (place, pdf) = match &self.density {
            Some(density) => {
                let sample = density.sample(u);
                (sample.position, sample.pdf)
            }
            None => (u, R::ONE),
        };
        AreaSample {
            position: self.at(place),
            normal: R::Vec3::same(self.normal),
            pdf_area: R::splat(self.pdf_area) * pdf,
        }
    }

    /// Density per area of [`Self::sample_area`] at these texture coordinates.
    pub fn pdf_area(&self, uv: Vec2) -> f32 {
        self.pdf_area * self.density.as_ref().map_or(1.0, |density| density.pdf(uv.to_array()))
    }

    /// The rectangle, if it has right angles and constant radiance.
    pub fn uniform(&self) -> Option<UniformRectangle> {
        let shape = self.rectangle.filter(|_| self.density.is_none())?;
        Some(UniformRectangle {
            shape,
            normal: self.normal,
            pdf_area: self.pdf_area,
        })
    }

    pub fn pdf(&self, reference: Vec3, hit: &SurfaceHit) -> f32 {
        let seen = self.uniform().map(|uniform| uniform.shape.seen_from(reference));
        match seen.filter(|seen| seen.is_large()) {
            Some(seen) => seen.pdf_solid_angle(),
            None => solid_angle_pdf(self.pdf_area(hit.uv), hit.position, self.normal, reference),
        }
    }
}

real_struct! {
    #[same]
    /// A rectangle of constant radiance.
    pub(crate) struct UniformRectangle<R> {
        shape: Rectangle<R>,
        /// Unit vector on the emitting side.
        normal: R::Vec3,
        /// One over the area.
        pdf_area: R,
    }
}

impl<R: Real> UniformRectangle<R> {
    /// The point at these fractions of the edges.
    #[inline(always)]
    pub fn at(&self, shares: [R; 2]) -> R::Vec3 {
        self.shape.at(shares)
    }

    /// Samples a point uniformly in solid angle, or in area where the solid angle is tiny.
    #[inline(always)]
    pub(super) fn sample(&self, reference: R::Vec3, u: [R; 2]) -> SurfaceSample<R> {
        let seen = self.shape.seen_from(reference);
        let is_before = (reference - self.shape.at([R::ZERO; 2]))
            .dot(self.normal)
            .is_more(R::ZERO);
        let sample = SurfaceSample {
            position: seen.sample(u),
            normal: self.normal,
            pdf_solid_angle: seen.pdf_solid_angle().only(is_before),
        };
        let is_tiny = is_before & !seen.is_large();
        if !is_tiny.any() {
            return sample;
        }
        let by_area = AreaSample {
            position: self.shape.at(u),
            normal: self.normal,
            pdf_area: self.pdf_area,
        };
        SurfaceSample::select(is_tiny, by_area.seen_from(reference), sample)
    }
}
