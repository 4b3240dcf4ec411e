//! A smooth metal: mirror reflection with the Fresnel reflectance of a complex index; black from behind.

use super::{BsdfSample, Model, ShadingTables, TransportMode, fresnel};
use crate::math::{Mask, Real, Vector, real_struct};

real_struct! {
    /// The optical constants of a metal, and a tint without physical meaning.
    pub struct ConductorSpecular<R> {
        /// Real part of the refractive index relative to the outside.
        pub eta: R::Vec3,
        /// Imaginary part (extinction), positive.
        pub k: R::Vec3,
        /// Multiplies the reflection; 1 is physical.
        pub specular_reflectance: R::Vec3,
    }
}

impl<R: Real> ConductorSpecular<R> {
    /// Reflectance at the cosine `cos_i` between direction and (micro)normal.
    #[inline(always)]
    pub fn reflectance(&self, cos_i: R) -> R::Vec3 {
        self.specular_reflectance * fresnel::conductor(cos_i, self.eta, self.k)
    }
}

real_struct! {
    /// A smooth metal.
    pub struct Conductor<R> {
        /// The optical constants.
        pub specular: ConductorSpecular<R>,
    }
}

impl<R: Real> Model<R> for Conductor<R> {
    #[inline(always)]
    fn sample(&self, _: &ShadingTables, wo: R::Vec3, _: R, _: [R; 2], _: TransportMode) -> BsdfSample<R> {
        BsdfSample {
            wi: wo.mirrored(),
            weight: self.specular.reflectance(wo.z()),
            pdf: R::ONE,
            is_delta: R::Mask::ALWAYS,
            eta: R::ONE,
            is_returned: wo.z().is_more(R::ZERO),
        }
    }
}
