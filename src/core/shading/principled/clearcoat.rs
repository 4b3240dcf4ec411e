//! The clear coat: an isotropic reflection of fixed index 1.5 on top of all other lobes, with the long-tailed
//! distribution GTR of exponent 1 (Burley 2012, appendix B).

use std::f32::consts::{PI, TAU};

use super::schlick;
use crate::math::{Real, Vector, exp, ln, sin_cos};
use crate::shading::{Ggx, fresnel::DielectricFresnel};

/// The roughness of masking, whatever the gloss.
const MASKING_ALPHA: f32 = 0.25;

/// Reflectance at normal incidence.
const NORMAL_REFLECTANCE: f32 = 0.04;

/// A coat of full strength.
#[derive(Clone, Copy)]
pub(super) struct Clearcoat<R> {
    alpha_squared: R,
}

impl<R: Real> Clearcoat<R> {
    /// A coat of `gloss` in [0, 1], from satin to gloss.
    #[inline(always)]
    pub(super) fn new(gloss: R) -> Self {
        Self {
            alpha_squared: R::splat(0.1).mix(R::splat(0.001), gloss).squared(),
        }
    }

    /// Density of microfacet area by normal: proportional to 1 / (sin^2 + alpha^2 cos^2).
    #[inline(always)]
    fn density(&self, m: R::Vec3) -> R {
        let sin_squared = m.x().mul_add(m.x(), m.y() * m.y());
        let spread = self.alpha_squared.mul_add(m.z() * m.z(), sin_squared);
        (self.alpha_squared - R::ONE) / (R::splat(PI) * ln(self.alpha_squared) * spread)
    }

    /// The value f |cos wi| of reflection off facets of normal `m` that are met with cosine `cos`. Both directions are
    /// above the surface. `fresnel` is the main lobe's; only its side of the interface is used.
    #[inline(always)]
    pub(super) fn value(&self, wo: R::Vec3, wi: R::Vec3, m: R::Vec3, cos: R, fresnel: &DielectricFresnel<R>) -> R {
        let reflectance = R::splat(NORMAL_REFLECTANCE).mix(R::ONE, schlick::facet_weight(cos, fresnel));
        let alpha = R::splat(MASKING_ALPHA);
        let masking = Ggx::new(alpha, alpha);
        reflectance * self.density(m) * masking.g1(wo) * masking.g1(wi) * wi.z()
    }

    /// Solid angle density of reflection off a normal from [`Self::sample_normal`].
    #[inline(always)]
    pub(super) fn pdf(&self, m: R::Vec3, cos: R) -> R {
        self.density(m) * m.z() / (R::splat(4.0) * cos)
    }

    /// A normal with density D(m) |cos m|.
    #[inline(always)]
    pub(super) fn sample_normal(&self, [u, v]: [R; 2]) -> R::Vec3 {
        // sin^2 = (alpha^(2 - 2u) - alpha^2) / (1 - alpha^2). Rounding is below 1e-6 of alpha^2, the width of the lobe.
        let spread = self.alpha_squared * exp(-v * ln(self.alpha_squared));
        let sin_squared = ((spread - self.alpha_squared) / (R::ONE - self.alpha_squared)).saturated();
        let sin = sin_squared.sqrt();
        let (y, x) = sin_cos(R::splat(TAU) * u);
        R::Vec3::of(sin * x, sin * y, (R::ONE - sin_squared).sqrt())
    }
}
