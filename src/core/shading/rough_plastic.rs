//! A diffuse base below a rough dielectric coat; black from behind.
//!
//! The model of smooth plastic, with a microfacet lobe for the coat and tabulated transmittances in place of Fresnel's.

use super::fresnel::{self, DielectricModel};
use super::rough_coat::CoatThere;
use super::{BsdfSample, CoatId, CoatedBase, DiffuseLobe, Microfacet, Model, ShadingTables, TransportMode};
use crate::math::{Mask, Real, Vector, real_struct};
use crate::sampling::warp;

real_struct! {
    /// Rough plastic.
    pub struct RoughPlastic<R> {
        /// The tabulated transmittances of the coat.
        pub coat: CoatId<R::Word>,
        /// Roughness of the coat.
        pub alpha: R,
        /// The base below the coat.
        pub base: CoatedBase<R>,
    }
}

/// Rough plastic as seen from one direction, with the values that do not depend on the light's direction.
struct Seen<'a, R: Real> {
    wo: R::Vec3,
    base: &'a CoatedBase<R>,
    coat: CoatThere<'a, R>,
    facets: Microfacet<R>,
    /// The fraction of light that the coat transmits to the viewer.
    transmittance: R,
    /// The probability of sampling the coat.
    coat_probability: R,
}

impl<R: Real> RoughPlastic<R> {
    #[inline(always)]
    fn seen<'a>(&'a self, tables: &'a ShadingTables, wo: R::Vec3) -> Seen<'a, R> {
        let coat = tables.coat(self.coat.0, self.alpha);
        let transmittance = coat.transmittance(wo.z());
        Seen {
            wo,
            base: &self.base,
            coat,
            facets: Microfacet::with(coat.is_beckmann, self.alpha, self.alpha),
            transmittance,
            coat_probability: self.base.coat_probability(R::ONE - transmittance),
        }
    }
}

impl<R: Real> Model<R> for RoughPlastic<R> {
    #[inline(always)]
    fn eval_and_pdf(&self, tables: &ShadingTables, wo: R::Vec3, wi: R::Vec3, _: TransportMode) -> (R::Vec3, R) {
        self.seen(tables, wo).eval_and_pdf(wi)
    }

    #[inline(always)]
    fn diffuse_lobe(&self, tables: &ShadingTables, wo: R::Vec3) -> DiffuseLobe<R> {
        DiffuseLobe::below(self.seen(tables, wo).coat_probability, wo.z().is_more(R::ZERO))
    }

    #[inline(always)]
    fn sample(&self, tables: &ShadingTables, wo: R::Vec3, u_lobe: R, u: [R; 2], _: TransportMode) -> BsdfSample<R> {
        let seen = self.seen(tables, wo);
        let is_of_coat = u_lobe.is_less(seen.coat_probability);
        let mut wi = warp::cosine_hemisphere(u);
        if is_of_coat.any() {
            let m = seen.facets.sample_visible(wo, u);
            let cos = wo.dot(m);
            wi = R::Vec3::select(is_of_coat, m * (cos + cos) - wo, wi);
        }
        let (value, pdf) = seen.eval_and_pdf(wi);
        // The density is zero below the horizon, where the light would meet another facet.
        BsdfSample {
            wi,
            weight: value / pdf,
            pdf,
            is_delta: R::Mask::NEVER,
            eta: R::ONE,
            is_returned: pdf.is_more(R::ZERO),
        }
    }
}

impl<R: Real> Seen<'_, R> {
    /// The value and density; zero from behind.
    #[inline(always)]
    fn eval_and_pdf(&self, wi: R::Vec3) -> (R::Vec3, R) {
        let Self { wo, facets, coat, .. } = self;
        let m = (*wo + wi).normalize();
        let seen = facets.density(m) * facets.g1_over_four_cos(*wo);
        let diffuse = warp::cosine_hemisphere_pdf(wi.z());

        let reflectance = fresnel::dielectric(wo.dot(m), coat.eta, DielectricModel::Exact).reflectance;
        let geometry = seen * facets.g1(wi);
        let through = self.transmittance * coat.transmittance(wi.z());
        let escaping = self.base.escaping(coat.eta, coat.internal_reflectance());
        let value = self.base.specular_reflectance * (reflectance * geometry) + escaping * (through * diffuse);

        let visible = seen / facets.masking_ratio(*wo);
        let pdf = self.coat_probability * visible + (R::ONE - self.coat_probability) * diffuse;
        let is_above = wo.z().is_more(R::ZERO) & wi.z().is_more(R::ZERO);
        (value.only(is_above), pdf.only(is_above))
    }
}
