//! A metal with a rough surface: scattering off microfacets; black from behind.
//!
//! f = F D G / (4 cos wo cos wi). Light that would bounce between facets is lost, so rough metals are somewhat too
//! dark, unless the lobe is scaled up by the lost light ([`Compensation`]).

use super::{BsdfSample, Compensation, ConductorSpecular, Microfacet, Model, ShadingTables, TransportMode};
use crate::math::{Mask, Real, Vector, real_struct};

real_struct! {
    /// A rough metal.
    pub struct RoughConductor<R> {
        /// The optical constants.
        pub specular: ConductorSpecular<R>,
        /// Roughness of the surface.
        pub distribution: Microfacet<R>,
        /// The compensation for multiple bounces, for the same constants and roughness; without it scattering is
        /// single. With it the model is not reciprocal.
        pub multiple_scattering: Compensation<R>,
    }
}

/// The half vector, and whether both directions are above the surface and see the front of the facet.
#[inline(always)]
fn half_vector<R: Real>(wo: R::Vec3, wi: R::Vec3) -> (R::Vec3, R::Mask) {
    // Two directions above the horizon are never opposite; their cosine with the half vector is positive.
    ((wo + wi).normalize(), wo.z().is_more(R::ZERO) & wi.z().is_more(R::ZERO))
}

impl<R: Real> Model<R> for RoughConductor<R> {
    #[inline(always)]
    fn eval_and_pdf(&self, tables: &ShadingTables, wo: R::Vec3, wi: R::Vec3, _: TransportMode) -> (R::Vec3, R) {
        let (m, is_seen) = half_vector::<R>(wo, wi);
        let facets = &self.distribution;
        let seen = facets.density(m) * facets.g1_over_four_cos(wo);
        let gain = self.multiple_scattering.gain(tables, wo.z());
        let value = gain * self.specular.reflectance(wo.dot(m)) * (seen * facets.g1(wi));
        // The density of the visible normal over the Jacobian 4 (wo . m) of reflection.
        (value.only(is_seen), (seen / facets.masking_ratio(wo)).only(is_seen))
    }

    #[inline(always)]
    fn sample(&self, tables: &ShadingTables, wo: R::Vec3, _: R, u: [R; 2], _: TransportMode) -> BsdfSample<R> {
        let zero = R::ZERO;
        let facets = &self.distribution;
        let m = facets.sample_visible(wo, u);
        let cos = wo.dot(m);
        let wi = m * (cos + cos) - wo;
        let ratio = facets.masking_ratio(wo);
        let pdf = facets.density(m) * facets.g1_over_four_cos(wo) / ratio;
        let gain = self.multiple_scattering.gain(tables, wo.z());
        // Light below the horizon would meet another facet, which this model ignores.
        let is_above = wo.z().is_more(zero) & wi.z().is_more(zero) & cos.is_more(zero);
        BsdfSample {
            wi,
            weight: gain * self.specular.reflectance(cos) * (ratio * facets.g1(wi)),
            pdf,
            is_delta: R::Mask::NEVER,
            eta: R::ONE,
            is_returned: is_above & pdf.is_more(zero),
        }
    }
}
