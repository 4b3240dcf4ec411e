//! A smooth interface between two transparent media: reflection and refraction, chosen by the Fresnel reflectance.

use super::fresnel::{self, DielectricModel};
use super::{BsdfSample, Model, ShadingTables, TransportMode};
use crate::math::{Mask, Real, Vector, real_struct};

real_struct! {
    /// Smooth glass, water, and the like; the normal points outside.
    pub struct Dielectric<R> {
        /// Refractive index inside over outside, above 0.
        pub eta: R,
        /// The law of the Fresnel reflectance: the same in all lanes.
        pub model: DielectricModel,
        /// Multiplies reflected light; 1 is physical.
        pub specular_reflectance: R::Vec3,
        /// Multiplies refracted light; 1 is physical.
        pub specular_transmittance: R::Vec3,
    }
}

impl<R: Real> Model<R> for Dielectric<R> {
    #[inline(always)]
    fn sample(&self, _: &ShadingTables, wo: R::Vec3, u_lobe: R, _: [R; 2], mode: TransportMode) -> BsdfSample<R> {
        let fresnel = fresnel::dielectric(wo.z(), self.eta, self.model);
        let eta_ti = fresnel.eta_ti;
        let is_reflected = u_lobe.is_less(fresnel.reflectance);
        let refracted = R::Vec3::of(-eta_ti * wo.x(), -eta_ti * wo.y(), fresnel.cos_t);
        BsdfSample {
            wi: R::Vec3::select(is_reflected, wo.mirrored(), refracted),
            weight: R::Vec3::select(
                is_reflected,
                self.specular_reflectance,
                self.specular_transmittance * mode.refraction_factor(eta_ti),
            ),
            pdf: R::select(is_reflected, fresnel.reflectance, R::ONE - fresnel.reflectance),
            is_delta: R::Mask::ALWAYS,
            eta: R::select(is_reflected, R::ONE, fresnel.eta_it),
            is_returned: !wo.z().equals(R::ZERO),
        }
    }
}
