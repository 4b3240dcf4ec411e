//! A diffuse base below a rough dielectric coat; black from behind.
//!
//! As smooth plastic, with a microfacet lobe for the coat and tabulated transmittances in place of Fresnel's.

use super::{BsdfSample, CoatedBase, Microfacet, RoughCoat, fresnel, fresnel::DielectricModel};
use crate::{color::Rgb, sampling::warp};
use glam::{Vec2, Vec3};

/// Rough plastic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughPlastic {
    /// The tabulated transmittances of the coat.
    pub coat: &'static RoughCoat,
    /// Roughness of the coat.
    pub alpha: f32,
    /// The base below the coat.
    pub base: CoatedBase,
}

impl RoughPlastic {
    fn facets(&self) -> Microfacet {
        Microfacet::new(self.coat.kind(), self.alpha, self.alpha)
    }

    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> Rgb {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Rgb::ZERO;
        }
        let (facets, m) = (self.facets(), (wo + wi).normalize());
        let reflectance = fresnel::dielectric(wo.dot(m), self.coat.eta(), DielectricModel::Exact).reflectance;
        let geometry = facets.density(m) * facets.g1_over_four_cos(wo) * facets.g1(wi);
        let coat = self.coat.at(self.alpha);
        let through = coat.transmittance(wo.z) * coat.transmittance(wi.z);
        let escaping = self.base.escaping(self.coat.eta(), coat.internal_reflectance());
        self.base.specular_reflectance * (reflectance * geometry)
            + escaping * (through * warp::cosine_hemisphere_pdf(wi.z))
    }

    fn coat_probability(&self, wo: Vec3) -> f32 {
        self.base
            .coat_probability(1.0 - self.coat.at(self.alpha).transmittance(wo.z))
    }

    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let visible = self.facets().reflected_density(wo, (wo + wi).normalize());
        let coat = self.coat_probability(wo);
        coat * visible + (1.0 - coat) * warp::cosine_hemisphere_pdf(wi.z)
    }

    pub(super) fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let wi = if u_lobe < self.coat_probability(wo) {
            let m = self.facets().sample_visible(wo, u);
            2.0 * wo.dot(m) * m - wo
        } else {
            warp::cosine_hemisphere(u)
        };
        let pdf = self.pdf(wo, wi);
        // The density is zero below the horizon, where the light would hit another facet.
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: self.eval(wo, wi) / pdf,
            pdf,
            is_delta: false,
            eta: 1.0,
        })
    }
}
