//! A thin pane of glass: both its interfaces and all reflections between them as one surface, through which light
//! passes straight.

use super::fresnel::{self, DielectricModel};
use super::{BsdfSample, Model, ShadingTables, TransportMode};
use crate::math::{Mask, Real, Vector, real_struct};

real_struct! {
    /// A window pane, or a bubble; the same from both sides.
    pub struct ThinDielectric<R> {
        /// Refractive index of the pane over that around it, above 0.
        pub eta: R,
        /// The law of the Fresnel reflectance: the same in all lanes.
        pub model: DielectricModel,
        /// Multiplies reflected light; 1 is physical.
        pub specular_reflectance: R::Vec3,
        /// The factor on transmitted light; 1 is physical.
        pub specular_transmittance: R::Vec3,
    }
}

impl<R: Real> ThinDielectric<R> {
    /// The reflected fraction: r + t r t + t r^3 t + ... = 2 r / (1 + r).
    #[inline(always)]
    fn reflectance(&self, wo: R::Vec3) -> R {
        let once = fresnel::dielectric(wo.z().abs(), self.eta, self.model).reflectance;
        (once + once) / (R::ONE + once)
    }

    /// The fraction of light transmitted to `wo`.
    #[inline(always)]
    pub(super) fn transmittance(&self, wo: R::Vec3) -> R::Vec3 {
        self.specular_transmittance * (R::ONE - self.reflectance(wo))
    }
}

impl<R: Real> Model<R> for ThinDielectric<R> {
    #[inline(always)]
    fn sample(&self, _: &ShadingTables, wo: R::Vec3, u_lobe: R, _: [R; 2], _: TransportMode) -> BsdfSample<R> {
        let reflectance = self.reflectance(wo);
        let is_reflected = u_lobe.is_less(reflectance);
        BsdfSample {
            wi: R::Vec3::select(is_reflected, wo.mirrored(), -wo),
            weight: R::Vec3::select(is_reflected, self.specular_reflectance, self.specular_transmittance),
            pdf: R::select(is_reflected, reflectance, R::ONE - reflectance),
            is_delta: R::Mask::ALWAYS,
            eta: R::ONE,
            is_returned: R::Mask::ALWAYS,
        }
    }
}
