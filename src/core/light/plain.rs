//! Surfaces of common shapes with constant radiance on one side. The lanes of a batch sample many such lights at once.

use super::LightSample;
use super::hit::SurfaceSample;
use super::rectangle::UniformRectangle;
use super::sphere::SphereLight;
use crate::math::lanes::{Lanes, Vec3Lanes};
use crate::math::{Held, Real, real_struct};

/// A plain surface, with the data that [`Glow`] adds to the points of its shape.
#[derive(Clone, Copy, Debug)]
pub(super) enum PlainSurface {
    Rectangle(UniformRectangle, Glow),
    Sphere(SphereLight, Glow),
}

real_struct! {
    #[same]
    /// The emission of a plain surface, which completes a point of its shape to a light sample.
    pub(crate) struct Glow<R> {
        pub(super) radiance: R::Vec3,
        /// The bound on the rounding error of points.
        pub(super) error: R,
    }
}

impl<R: Real> Glow<R> {
    /// The direction from `reference` to a point of the surface.
    #[inline(always)]
    pub(super) fn towards(&self, point: SurfaceSample<R>, reference: R::Vec3) -> LightSample<R> {
        point.towards(reference, self.error, self.radiance)
    }
}

/// The surfaces that lanes have chosen, grouped by kind.
#[derive(Default)]
pub(super) struct PlainLanes {
    rectangles: Held<UniformRectangle<Lanes>>,
    spheres: Held<SphereLight<Lanes>>,
    glow: Held<Glow<Lanes>>,
    /// The lanes that are not sampled yet, a bit each.
    left: u32,
}

impl PlainLanes {
    pub fn set(&mut self, lane: usize, surface: PlainSurface) {
        self.left |= 1 << lane;
        let glow = match surface {
            PlainSurface::Rectangle(shape, glow) => {
                self.rectangles.set(lane, shape);
                glow
            }
            PlainSurface::Sphere(shape, glow) => {
                self.spheres.set(lane, shape);
                glow
            }
        };
        self.glow.set(lane, glow);
    }

    /// Returns all lanes that are not sampled yet, a bit each, and marks them as sampled.
    pub fn take(&mut self) -> u32 {
        std::mem::take(&mut self.left)
    }

    /// Directions to the surfaces; the density is zero in lanes without one. None if no lane has a surface.
    pub fn sample(&self, reference: Vec3Lanes, u: [Lanes; 2]) -> Option<LightSample<Lanes>> {
        let (_, glow) = self.glow.held()?;
        let mut point = SurfaceSample {
            position: Vec3Lanes::ZERO,
            normal: Vec3Lanes::ZERO,
            pdf_solid_angle: Lanes::ZERO,
        };
        if let Some((here, shape)) = self.rectangles.held() {
            point = SurfaceSample::select(here, shape.sample(reference, u), point);
        }
        if let Some((here, shape)) = self.spheres.held() {
            point = SurfaceSample::select(here, shape.sample(reference, u), point);
        }
        Some(glow.towards(point, reference))
    }
}
