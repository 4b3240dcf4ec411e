//! A metal with a rough surface: scattering off microfacets; black from behind.
//!
//! f = F D G / (4 cos wo cos wi). Light that would bounce between facets is lost, so rough metals are somewhat too dark, unless the
//! lobe is scaled up by what it lost ([`Compensation`]).

use super::{BsdfSample, Compensation, ConductorSpecular, Microfacet, ShadingTables};
use crate::color::Rgb;
use glam::{Vec2, Vec3};

/// A rough metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughConductor {
    /// The optical constants.
    pub specular: ConductorSpecular,
    /// Roughness of the surface.
    pub distribution: Microfacet,
    /// The compensation for light that bounces several times, of the same constants and roughness; `None` is single scattering. With it the
    /// model is not reciprocal.
    pub multiple_scattering: Option<Compensation>,
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
    /// The factor by which light after more than one bounce makes the surface brighter for `wo`.
    fn gain(&self, tables: &ShadingTables, wo: Vec3) -> Rgb {
        self.multiple_scattering
            .map_or(Rgb::ONE, |compensation| compensation.gain(tables, wo.z))
    }

    pub(super) fn eval_and_pdf(&self, tables: &ShadingTables, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let Some(m) = half_vector(wo, wi) else {
            return (Rgb::ZERO, 0.0);
        };
        let facets = &self.distribution;
        let seen = facets.density(m) * facets.g1_over_four_cos(wo);
        let value = self.gain(tables, wo) * self.specular.reflectance(wo.dot(m)) * (seen * facets.g1(wi));
        // The density of the visible normal over the Jacobian 4 (wo . m) of reflection.
        (value, seen / facets.masking_ratio(wo))
    }

    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        half_vector(wo, wi).map_or(0.0, |m| self.distribution.reflected_density(wo, m))
    }

    pub(super) fn sample(&self, tables: &ShadingTables, wo: Vec3, u: Vec2) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let facets = &self.distribution;
        let m = facets.sample_visible(wo, u);
        let cos = wo.dot(m);
        let wi = 2.0 * cos * m - wo;
        // Light below the horizon would hit another facet, which this model leaves out.
        if wi.z <= 0.0 || cos <= 0.0 {
            return None;
        }
        let ratio = facets.masking_ratio(wo);
        let pdf = facets.density(m) * facets.g1_over_four_cos(wo) / ratio;
        let masking = ratio * facets.g1(wi);
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: self.gain(tables, wo) * self.specular.reflectance(cos) * masking,
            pdf,
            is_delta: false,
            eta: 1.0,
        })
    }
}
