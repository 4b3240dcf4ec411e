//! A diffuse base below a rough dielectric coat; black from behind.
//!
//! As smooth plastic, with a microfacet lobe for the coat and tabulated transmittances in place of Fresnel's.

use super::rough_coat::CoatThere;
use super::{
    BsdfSample, CoatId, CoatedBase, DiffuseLobe, Microfacet, ShadingTables, fresnel, fresnel::DielectricModel,
};
use crate::{color::Rgb, sampling::warp};
use glam::{Vec2, Vec3};

/// Rough plastic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughPlastic {
    /// The tabulated transmittances of the coat.
    pub coat: CoatId,
    /// Roughness of the coat.
    pub alpha: f32,
    /// The base below the coat.
    pub base: CoatedBase,
}

/// Rough plastic as seen from one direction above it, with what all directions of the light have in common.
struct Seen<'a> {
    wo: Vec3,
    base: &'a CoatedBase,
    coat: CoatThere<'a>,
    facets: Microfacet,
    /// The fraction of light that gets out of the coat to the viewer.
    transmittance: f32,
    /// The probability of sampling the coat.
    coat_probability: f32,
}

impl RoughPlastic {
    /// None from behind.
    fn seen<'a>(&'a self, tables: &'a ShadingTables, wo: Vec3) -> Option<Seen<'a>> {
        if wo.z <= 0.0 {
            return None;
        }
        let coat = tables.coat(self.coat, self.alpha);
        let transmittance = coat.transmittance(wo.z);
        Some(Seen {
            wo,
            base: &self.base,
            coat,
            facets: Microfacet::new(coat.kind, self.alpha, self.alpha),
            transmittance,
            coat_probability: self.base.coat_probability(1.0 - transmittance),
        })
    }

    pub(super) fn eval_and_pdf(&self, tables: &ShadingTables, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        self.seen(tables, wo)
            .map_or((Rgb::ZERO, 0.0), |seen| seen.eval_and_pdf(wi))
    }

    pub(super) fn diffuse_lobe(&self, tables: &ShadingTables, wo: Vec3) -> DiffuseLobe {
        self.seen(tables, wo)
            .map_or(DiffuseLobe::NONE, |seen| DiffuseLobe::below(seen.coat_probability))
    }

    pub(super) fn sample(&self, tables: &ShadingTables, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let seen = self.seen(tables, wo)?;
        let wi = if u_lobe < seen.coat_probability {
            let m = seen.facets.sample_visible(wo, u);
            2.0 * wo.dot(m) * m - wo
        } else {
            warp::cosine_hemisphere(u)
        };
        let (value, pdf) = seen.eval_and_pdf(wi);
        // The density is zero below the horizon, where the light would hit another facet.
        (pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: value / pdf,
            pdf,
            is_delta: false,
            eta: 1.0,
        })
    }
}

impl Seen<'_> {
    fn eval_and_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        let Self { wo, facets, coat, .. } = self;
        if wi.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let m = (wo + wi).normalize();
        let seen = facets.density(m) * facets.g1_over_four_cos(*wo);
        let diffuse = warp::cosine_hemisphere_pdf(wi.z);

        let reflectance = fresnel::dielectric(wo.dot(m), coat.eta, DielectricModel::Exact).reflectance;
        let geometry = seen * facets.g1(wi);
        let through = self.transmittance * coat.transmittance(wi.z);
        let escaping = self.base.escaping(coat.eta, coat.internal_reflectance());
        let value = self.base.specular_reflectance * (reflectance * geometry) + escaping * (through * diffuse);

        let visible = seen / facets.masking_ratio(*wo);
        let pdf = self.coat_probability * visible + (1.0 - self.coat_probability) * diffuse;
        (value, pdf)
    }
}
