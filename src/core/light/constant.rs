//! The same radiance from all directions.

use super::reference::Reference;
use super::{LightSample, Target};
use crate::color::Rgb;
use crate::math::{Frame, Mask, Real, Vector};
use crate::sampling::warp;

#[derive(Clone, Copy, Debug)]
pub(crate) struct ConstantLight {
    pub radiance: Rgb,
}

impl ConstantLight {
    /// Samples a direction: in proportion to the cosine with the normal where there is one, since the light itself
    /// prefers no direction; otherwise uniformly.
    #[inline(always)]
    pub fn sample<R: Real>(&self, from: &Reference<R>, u: [R; 2]) -> LightSample<R> {
        let Reference { normal, halved, .. } = *from;
        let local = warp::cosine_hemisphere(u);
        let (mut wi, mut pdf) = (
            Frame::<R>::around(normal).to_world(local),
            warp::cosine_hemisphere_pdf(local.z()),
        );
        if (!halved).any() {
            wi = R::Vec3::select(halved, wi, warp::uniform_sphere(u));
            pdf = R::select(halved, pdf, R::splat(warp::UNIFORM_SPHERE_PDF));
        }
        LightSample {
            wi,
            target: Target::Infinity,
            radiance: R::Vec3::same(self.radiance),
            pdf,
            is_delta: false,
        }
    }

    /// Density per solid angle of [`Self::sample`].
    #[inline(always)]
    pub fn pdf<R: Real>(&self, from: &Reference<R>, wi: R::Vec3) -> R {
        let cosine = warp::cosine_hemisphere_pdf(from.normal.dot(wi));
        R::select(from.halved, cosine, R::splat(warp::UNIFORM_SPHERE_PDF))
    }
}
