//! The clear coat: an isotropic reflection of fixed index 1.5 over everything else, with the long-tailed distribution GTR of exponent 1
//! (Burley 2012, appendix B).

use glam::{FloatExt, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

use super::schlick;
use crate::shading::{Ggx, fresnel::DielectricFresnel};

/// The roughness of masking, whatever the gloss.
const MASKING_ALPHA: f32 = 0.25;

/// Reflectance at normal incidence.
const NORMAL_REFLECTANCE: f32 = 0.04;

/// A coat of full strength.
#[derive(Clone, Copy)]
pub(super) struct Clearcoat {
    alpha_squared: f32,
}

impl Clearcoat {
    /// A coat of `gloss` in [0, 1], from satin to gloss.
    pub(super) fn new(gloss: f32) -> Self {
        let alpha = 0.1f32.lerp(0.001, gloss);
        Self {
            alpha_squared: alpha * alpha,
        }
    }

    /// Density of microfacet area by normal: proportional to 1 / (sin^2 + alpha^2 cos^2).
    fn density(&self, m: Vec3) -> f32 {
        let spread = m.truncate().length_squared() + self.alpha_squared * m.z * m.z;
        (self.alpha_squared - 1.0) / (PI * self.alpha_squared.ln() * spread)
    }

    /// The value f |cos wi| of reflection off facets of normal `m` that are met with cosine `cos`. Both directions are above the surface. `fresnel`
    /// is that of the main lobe, which says only on which side the angle counts.
    pub(super) fn value(&self, wo: Vec3, wi: Vec3, m: Vec3, cos: f32, fresnel: &DielectricFresnel) -> f32 {
        let reflectance = NORMAL_REFLECTANCE.lerp(1.0, schlick::facet_weight(cos, fresnel));
        let masking = Ggx::new(MASKING_ALPHA, MASKING_ALPHA);
        reflectance * self.density(m) * masking.g1(wo) * masking.g1(wi) * wi.z
    }

    /// Solid angle density of reflection off a normal from [`Self::sample_normal`].
    pub(super) fn pdf(&self, m: Vec3, cos: f32) -> f32 {
        self.density(m) * m.z / (4.0 * cos)
    }

    /// A normal with density D(m) |cos m|.
    pub(super) fn sample_normal(&self, u: Vec2) -> Vec3 {
        // sin^2 = alpha^2 (alpha^-2u - 1) / (1 - alpha^2): small ones keep their digits.
        let growth = (-u.y * self.alpha_squared.ln()).exp_m1();
        let sin_squared = (self.alpha_squared * growth / (1.0 - self.alpha_squared)).min(1.0);
        let azimuth = Vec2::from_angle(TAU * u.x);
        (azimuth * sin_squared.sqrt()).extend((1.0 - sin_squared).sqrt())
    }
}
