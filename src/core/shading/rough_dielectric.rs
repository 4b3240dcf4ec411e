//! A rough interface between two transparent media: reflection and refraction by microfacets.
//!
//! Walter et al., Microfacet Models for Refraction through Rough Surfaces, EGSR 2007. The surface is the same from both
//! sides; f(wo, wi) / n_o^2 is symmetric for radiance, n_o being the index on the side of wo.

use super::fresnel::{self, DielectricModel};
use super::{BsdfSample, LEAST_HALF_VECTOR, Microfacet, Model, ShadingTables, TransportMode};
use crate::math::{Mask, Real, Vector, real_struct};

real_struct! {
    /// Ground glass, ice, and the like; the normal points outside.
    pub struct RoughDielectric<R> {
        /// The refractive index inside over outside, above 0. It must not be 1, without a surface and a density: the
        /// smooth dielectric is used instead.
        pub eta: R,
        /// The law of the Fresnel reflectance: the same in all lanes.
        pub model: DielectricModel,
        /// Roughness of the interface.
        pub distribution: Microfacet<R>,
        /// Multiplies reflected light; 1 is physical.
        pub specular_reflectance: R::Vec3,
        /// Multiplies refracted light; 1 is physical.
        pub specular_transmittance: R::Vec3,
    }
}

impl<R: Real> RoughDielectric<R> {
    /// The index behind the surface over that in front.
    #[inline(always)]
    fn eta_it(&self, wo: R::Vec3) -> R {
        R::select(wo.z().is_more(R::ZERO), self.eta, R::ONE / self.eta)
    }
}

impl<R: Real> Model<R> for RoughDielectric<R> {
    #[inline(always)]
    fn eval_and_pdf(&self, _: &ShadingTables, wo: R::Vec3, wi: R::Vec3, mode: TransportMode) -> (R::Vec3, R) {
        let (zero, one) = (R::ZERO, R::ONE);
        let eta_it = self.eta_it(wo);
        let is_seen = !wo.z().equals(zero);
        let side = one.copy_sign(wo.z());
        let (wo, wi) = (wo * side, wi * side);
        let is_reflected = wi.z().is_more(zero);

        // The facet that connects the directions, with each direction on its side of both facet and surface.
        let half = wo + wi * R::select(is_reflected, one, eta_it);
        let length_squared = half.length_squared();
        let m = half * (one / length_squared.sqrt()).copy_sign(half.z());
        let (cos_o, cos_i) = (wo.dot(m), wi.dot(m));
        let is_connected =
            length_squared.is_more(R::splat(LEAST_HALF_VECTOR)) & cos_o.is_more(zero) & (cos_i * wi.z()).is_more(zero);
        // The Jacobian d omega_m / d omega_i.
        let path = cos_o + eta_it * cos_i;
        let refracting = eta_it * eta_it * -cos_i / (path * path);
        let jacobian = R::select(is_reflected, R::splat(0.25) / cos_i, refracting);

        let reflectance = fresnel::dielectric(cos_o, eta_it, self.model).reflectance;
        let lobe = R::select(is_reflected, reflectance, one - reflectance);
        let color = R::Vec3::select(
            is_reflected,
            self.specular_reflectance,
            self.specular_transmittance / mode.refraction_factor(eta_it),
        );
        let facets = &self.distribution;
        let visible = R::splat(4.0) * facets.density(m) * facets.g1_over_four_cos(wo) * cos_o * jacobian;
        let here = is_seen & is_connected;
        let value = color * (lobe * visible * facets.g1(wi));
        (value.only(here), (lobe * visible / facets.masking_ratio(wo)).only(here))
    }

    #[inline(always)]
    fn sample(&self, _: &ShadingTables, wo: R::Vec3, u_lobe: R, u: [R; 2], mode: TransportMode) -> BsdfSample<R> {
        let (zero, one) = (R::ZERO, R::ONE);
        let (eta_it, facets) = (self.eta_it(wo), &self.distribution);
        let is_seen = !wo.z().equals(zero);
        let side = one.copy_sign(wo.z());
        let wo = wo * side;
        let m = facets.sample_visible(wo, u);
        let cos_o = wo.dot(m);
        let fresnel = fresnel::dielectric(cos_o, eta_it, self.model);
        let is_reflected = u_lobe.is_less(fresnel.reflectance);
        let eta_ti = fresnel.eta_ti;
        let reflected = m * (cos_o + cos_o) - wo;
        // A large `eta_ti` magnifies rounding.
        let refracted = (m * (eta_ti * cos_o + fresnel.cos_t) - wo * eta_ti).normalize();
        let wi = R::Vec3::select(is_reflected, reflected, refracted);
        let path = cos_o + eta_it * fresnel.cos_t;
        let refracting = eta_it * eta_it * -fresnel.cos_t / (path * path);
        let jacobian = R::select(is_reflected, R::splat(0.25) / cos_o, refracting);
        let lobe = R::select(is_reflected, fresnel.reflectance, one - fresnel.reflectance);
        let color = R::Vec3::select(
            is_reflected,
            self.specular_reflectance,
            self.specular_transmittance * mode.refraction_factor(eta_ti),
        );
        let pdf = R::splat(4.0) * lobe * facets.reflected_density(wo, m) * cos_o * jacobian;
        // Light on the wrong side of the surface would meet another facet, which this model ignores.
        let is_right = (is_reflected & wi.z().is_more(zero)) | (!is_reflected & wi.z().is_less(zero));
        let has_density = pdf.is_more(zero) & pdf.is_less(R::splat(f32::INFINITY));
        BsdfSample {
            wi: wi * side,
            weight: color * (facets.masking_ratio(wo) * facets.g1(wi)),
            pdf,
            is_delta: R::Mask::NEVER,
            eta: R::select(is_reflected, one, eta_it),
            is_returned: is_seen & cos_o.is_more(zero) & is_right & has_density,
        }
    }
}
