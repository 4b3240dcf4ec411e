//! A metal with a rough surface: single scattering off GGX microfacets; black from behind.
//!
//! f = F D G / (4 cos wo cos wi). Light that would bounce between facets is lost, so rough metals are somewhat too dark.

use super::{BsdfSample, ConductorSpecular, microfacet::Ggx};
use crate::color::Rgb;
use glam::{Vec2, Vec3};

/// A rough metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughConductor {
    pub specular: ConductorSpecular,
    pub distribution: Ggx,
}

/// The half vector, if both directions are above the surface and see the front of the facet.
fn half_vector(wo: Vec3, wi: Vec3) -> Option<Vec3> {
    if wo.z <= 0.0 || wi.z <= 0.0 {
        return None;
    }
    // Two directions above the horizon are never opposite; their cosine with the half vector is positive.
    Some((wo + wi).normalize())
}

impl RoughConductor {
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> Rgb {
        let Some(m) = half_vector(wo, wi) else {
            return Rgb::ZERO;
        };
        let ggx = &self.distribution;
        self.specular.reflectance(wo.dot(m)) * (ggx.density(m) * ggx.g1_over_four_cos(wo) * ggx.g1(wi))
    }

    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        // The density of the visible normal over the Jacobian 4 (wo . m) of reflection.
        half_vector(wo, wi).map_or(0.0, |m| {
            self.distribution.density(m) * self.distribution.g1_over_four_cos(wo)
        })
    }

    pub(super) fn sample(&self, wo: Vec3, u: Vec2) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let m = self.distribution.sample_visible(wo, u);
        let cos = wo.dot(m);
        let wi = 2.0 * cos * m - wo;
        // Below the horizon: the light would hit another facet, which this model leaves out.
        if wi.z <= 0.0 || cos <= 0.0 {
            return None;
        }
        let pdf = self.distribution.density(m) * self.distribution.g1_over_four_cos(wo);
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: self.specular.reflectance(cos) * self.distribution.g1(wi),
            pdf,
            is_delta: false,
            eta: 1.0,
        })
    }
}
