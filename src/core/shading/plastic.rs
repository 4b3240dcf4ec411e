//! A diffuse base below a smooth dielectric coat, with light reflected between the two until it escapes; black from
//! behind.
//!
//! The coat reflects F(wo); the rest enters and is scattered by the base, and each time the fraction R_int returns to
//! the base: f = albedo (1 - F(wo)) (1 - F(wi)) / (pi eta^2 (1 - a R_int)), a being the albedo. "Linear" plastic keeps
//! the colour by omitting a from the denominator. (Weidlich and Wilkie, Arbitrarily Layered Micro-Facet Surfaces, 2007;
//! Elias, Simonot and Menu, 2001.)

use super::fresnel::{self, DielectricModel};
use super::{BsdfSample, DiffuseLobe, Model, ShadingTables, TransportMode};
use crate::math::{Real, Vector, real_struct};
use crate::sampling::warp;

real_struct! {
    /// The coat, with all values that depend on its index alone.
    pub struct SmoothCoat<R> {
        eta: R,
        internal_reflectance: R,
    }
}

impl SmoothCoat {
    /// A coat with this refractive index relative to the outside, above 0.
    pub fn new(eta: f32) -> Self {
        Self {
            eta,
            internal_reflectance: fresnel::diffuse_reflectance(eta.recip()),
        }
    }
}

impl<R: Real> SmoothCoat<R> {
    /// The reflected fraction at the cosine `cos`.
    #[inline(always)]
    fn reflectance(&self, cos: R) -> R {
        fresnel::dielectric(cos, self.eta, DielectricModel::Exact).reflectance
    }
}

real_struct! {
    /// The base below a coat.
    pub struct CoatedBase<R> {
        /// The reflectance of the base, [0, 1].
        pub diffuse_reflectance: R::Vec3,
        /// Whether light takes up the base's colour again at each internal reflection.
        pub nonlinear: R::Mask,
        /// The factor on the coat's reflection; 1 is physical.
        pub specular_reflectance: R::Vec3,
    }
}

impl<R: Real> CoatedBase<R> {
    /// The fraction of light inside that escapes, per squared transmittance: albedo / (eta^2 (1 - a R_int)).
    #[inline(always)]
    pub(super) fn escaping(&self, eta: R, internal_reflectance: R) -> R::Vec3 {
        let color = R::Vec3::select(self.nonlinear, self.diffuse_reflectance, R::Vec3::even(R::ONE));
        let again = color * internal_reflectance;
        self.diffuse_reflectance / ((R::Vec3::even(R::ONE) - again) * (eta * eta))
    }

    /// The probability of sampling the coat, which reflects the fraction `reflected`.
    #[inline(always)]
    pub(super) fn coat_probability(&self, reflected: R) -> R {
        let coat = reflected * self.specular_reflectance.sum();
        let base = (R::ONE - reflected) * self.diffuse_reflectance.sum();
        // If both are black, either choice is right.
        R::select((coat + base).is_more(R::ZERO), coat / (coat + base), R::ONE)
    }
}

real_struct! {
    /// Smooth plastic.
    pub struct Plastic<R> {
        /// The interface on top.
        pub coat: SmoothCoat<R>,
        /// The base below the coat.
        pub base: CoatedBase<R>,
    }
}

impl<R: Real> Plastic<R> {
    /// The base's value towards a viewer for whom the coat reflects the fraction `reflected`, and its density.
    #[inline(always)]
    fn of_base(&self, reflected: R, wi: R::Vec3) -> (R::Vec3, R) {
        let cosine = warp::cosine_hemisphere_pdf(wi.z());
        let through = (R::ONE - reflected) * (R::ONE - self.coat.reflectance(wi.z()));
        let escaping = self.base.escaping(self.coat.eta, self.coat.internal_reflectance);
        let chance = R::ONE - self.base.coat_probability(reflected);
        (escaping * (through * cosine), chance * cosine)
    }
}

impl<R: Real> Model<R> for Plastic<R> {
    #[inline(always)]
    fn eval_and_pdf(&self, _: &ShadingTables, wo: R::Vec3, wi: R::Vec3, _: TransportMode) -> (R::Vec3, R) {
        let is_above = wo.z().is_more(R::ZERO);
        let (value, pdf) = self.of_base(self.coat.reflectance(wo.z()), wi);
        (value.only(is_above), pdf.only(is_above))
    }

    #[inline(always)]
    fn diffuse_lobe(&self, _: &ShadingTables, wo: R::Vec3) -> DiffuseLobe<R> {
        let coat = self.base.coat_probability(self.coat.reflectance(wo.z()));
        DiffuseLobe::below(coat, wo.z().is_more(R::ZERO))
    }

    #[inline(always)]
    fn sample(&self, _: &ShadingTables, wo: R::Vec3, u_lobe: R, u: [R; 2], _: TransportMode) -> BsdfSample<R> {
        let reflected = self.coat.reflectance(wo.z());
        let probability = self.base.coat_probability(reflected);
        let is_delta = u_lobe.is_less(probability);
        let wi = warp::cosine_hemisphere(u);
        let (value, pdf) = self.of_base(reflected, wi);
        let mirrored = self.base.specular_reflectance * (reflected / probability);
        BsdfSample {
            wi: R::Vec3::select(is_delta, wo.mirrored(), wi),
            weight: R::Vec3::select(is_delta, mirrored, value / pdf),
            pdf: R::select(is_delta, probability, pdf),
            is_delta,
            eta: R::ONE,
            is_returned: wo.z().is_more(R::ZERO) & (is_delta | pdf.is_more(R::ZERO)),
        }
    }
}
