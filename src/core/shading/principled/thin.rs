//! The thin principled model: a sheet that scatters diffusely and specularly to both sides, and looks the same from
//! either side.
//!
//! Burley 2015 (thin surfaces), in Mitsuba 3's form:
//!
//! - There is no metal and no coat. All specular light, reflected light included, has the weight `spec_trans`.
//! - Transmitted light is reflected by facets and mirrored to the other side; these facets are rougher or smoother by
//!   0.65 `eta` - 0.35. Paths are not bent, nor do they bounce between the sheet's two faces. Facets that light leaves
//!   on the wrong side transmit none, so part of the grazing light is lost, and not reciprocally.
//! - Sheen can make the sheet reflect more light than arrives.

use super::{Evaluation, base, reflect, schlick, sheen, specular, upright};
use crate::math::{Mask, Real, Vector, real_struct};
use crate::sampling::warp;
use crate::shading::fresnel::{self, DielectricModel};
use crate::shading::{BsdfSample, Ggx, Model, ShadingTables, TransportMode};

real_struct! {
    /// A thin principled sheet. Numbers are in [0, 1] unless stated.
    pub struct PrincipledThin<R> {
        /// The colour of diffuse and of transmitted light.
        pub base_color: R::Vec3,
        /// The perceptual roughness: that of GGX is its square.
        pub roughness: R,
        /// The stretch of highlights along the first tangent; 0 is isotropic.
        pub anisotropic: R,
        /// The weight of specular light; the rest is diffuse.
        pub spec_trans: R,
        /// Twice the share of diffuse light that is transmitted, in [0, 2]; the rest is reflected.
        pub diff_trans: R,
        /// Refractive index of the sheet over that around it, above 0.
        pub eta: R,
        /// The share of the base colour's hue in the specular reflection.
        pub spec_tint: R,
        /// The strength of the grazing reflection of fabrics.
        pub sheen: R,
        /// The share of the base colour's hue in the sheen.
        pub sheen_tint: R,
        /// The blend from diffuse reflection to imitated subsurface scattering.
        pub flatness: R,
        /// The rates at which lobes are sampled.
        pub rates: ThinSamplingRates<R>,
    }
}

real_struct! {
    /// The rates at which lobes are sampled, relative to their weights; not negative. They change noise, not the image.
    pub struct ThinSamplingRates<R> {
        /// The rate of mirror-like reflection.
        pub specular_reflectance: R,
        /// The rate of specular transmission.
        pub specular_transmittance: R,
        /// The rate of diffuse reflection and sheen.
        pub diffuse_reflectance: R,
        /// The rate of diffuse transmission.
        pub diffuse_transmittance: R,
    }
}

impl Default for ThinSamplingRates {
    fn default() -> Self {
        Self {
            specular_reflectance: 1.0,
            specular_transmittance: 1.0,
            diffuse_reflectance: 1.0,
            diffuse_transmittance: 1.0,
        }
    }
}

/// One number for each lobe.
struct Lobes<R> {
    specular_reflection: R,
    specular_transmission: R,
    diffuse_reflection: R,
    diffuse_transmission: R,
}

impl<R: Real> PrincipledThin<R> {
    /// The weights of specular light, of diffuse reflection and of diffuse transmission.
    #[inline(always)]
    fn shares(&self) -> (R, R, R) {
        let diffuse = R::ONE - self.spec_trans;
        let passing = R::HALF * self.diff_trans;
        (self.spec_trans, diffuse * (R::ONE - passing), diffuse * passing)
    }

    /// The sampling probabilities, and whether the sheet reflects or transmits any light.
    #[inline(always)]
    fn chances(&self) -> (Lobes<R>, R::Mask) {
        let (specular, reflected, passing) = self.shares();
        let specular_reflection = R::HALF * specular * self.rates.specular_reflectance;
        let specular_transmission = R::HALF * specular * self.rates.specular_transmittance;
        let diffuse_reflection = reflected * self.rates.diffuse_reflectance;
        let diffuse_transmission = passing * self.rates.diffuse_transmittance;
        let total = specular_reflection + specular_transmission + diffuse_reflection + diffuse_transmission;
        let chances = Lobes {
            specular_reflection: specular_reflection / total,
            specular_transmission: specular_transmission / total,
            diffuse_reflection: diffuse_reflection / total,
            diffuse_transmission: diffuse_transmission / total,
        };
        (chances, total.is_more(R::ZERO))
    }

    #[inline(always)]
    fn reflecting_facets(&self) -> Ggx<R> {
        specular::microfacets(self.roughness, self.anisotropic)
    }

    #[inline(always)]
    fn transmitting_facets(&self) -> Ggx<R> {
        let factor = R::splat(0.65) * self.eta - R::splat(0.35);
        specular::microfacets(factor * self.roughness, self.anisotropic)
    }

    #[inline(always)]
    fn evaluate(&self, wo: R::Vec3, wi: R::Vec3) -> Evaluation<R> {
        let zero = R::ZERO;
        let (wo, wi) = (upright::<R>(wo, wo), upright::<R>(wi, wo));
        let (chances, is_there) = self.chances();
        let is_seen = is_there & wo.z().is_more(zero);
        let evaluation = self.reflected(&chances, wo, wi).only(is_seen & wi.z().is_more(zero));
        let is_below = is_seen & wi.z().is_less(zero);
        match is_below.any() {
            true => self.transmitted(&chances, wo, wi).or(is_below, evaluation),
            false => evaluation,
        }
    }

    #[inline(always)]
    fn reflected(&self, chances: &Lobes<R>, wo: R::Vec3, wi: R::Vec3) -> Evaluation<R> {
        let (specular, diffuse, _) = self.shares();
        let facet = specular::reflecting(&self.reflecting_facets(), wo, wi);
        let fresnel = fresnel::dielectric(facet.cos, self.eta, DielectricModel::Exact);
        let tinted = schlick::tinted(self.base_color, self.eta, facet.cos, &fresnel);
        let reflectance = R::Vec3::even(fresnel.reflectance).mix(tinted, self.spec_tint);
        let base = base::value(self.roughness, self.flatness, wo.z(), wi.z(), facet.cos);
        let sheen = sheen::value(self.base_color, self.sheen_tint, wi.z(), facet.cos) * self.sheen;
        let evaluation = Evaluation {
            value: reflectance * (specular * facet.unmasked * facet.pdf) + (self.base_color * base + sheen) * diffuse,
            pdf: chances.specular_reflection * facet.pdf
                + chances.diffuse_reflection * warp::cosine_hemisphere_pdf(wi.z()),
        };
        evaluation.only(facet.is_there)
    }

    #[inline(always)]
    fn transmitted(&self, chances: &Lobes<R>, wo: R::Vec3, wi: R::Vec3) -> Evaluation<R> {
        let (specular, _, diffuse) = self.shares();
        let facet = specular::reflecting(&self.transmitting_facets(), wo, wi.with_third(-wi.z()));
        let cosine = warp::cosine_hemisphere_pdf(-wi.z());
        let fresnel = fresnel::dielectric(facet.cos, self.eta, DielectricModel::Exact);
        let passes = wi.dot(facet.normal).is_less(R::ZERO);
        let through = specular * (R::ONE - fresnel.reflectance) * facet.unmasked * facet.pdf;
        let evaluation = Evaluation {
            value: self.base_color * (diffuse * cosine + through.only(passes)),
            pdf: chances.diffuse_transmission * cosine + (chances.specular_transmission * facet.pdf).only(passes),
        };
        evaluation.only(facet.is_there)
    }
}

impl<R: Real> Model<R> for PrincipledThin<R> {
    #[inline(always)]
    fn eval_and_pdf(&self, _: &ShadingTables, wo: R::Vec3, wi: R::Vec3, _: TransportMode) -> (R::Vec3, R) {
        let Evaluation { value, pdf } = self.evaluate(wo, wi);
        (value, pdf)
    }

    #[inline(always)]
    fn sample(&self, _: &ShadingTables, wo: R::Vec3, u_lobe: R, u: [R; 2], _: TransportMode) -> BsdfSample<R> {
        let zero = R::ZERO;
        let (chances, is_there) = self.chances();
        let above = upright::<R>(wo, wo);
        let specular = chances.specular_reflection + chances.specular_transmission;
        let is_specular = u_lobe.is_less(specular);
        let passes = (is_specular & !u_lobe.is_less(chances.specular_reflection))
            | (!is_specular & !u_lobe.is_less(specular + chances.diffuse_reflection));
        let mut wi = warp::cosine_hemisphere(u);
        let mut is_right = R::Mask::ALWAYS;
        if is_specular.any() {
            let (reflecting, passing) = (self.reflecting_facets(), self.transmitting_facets());
            let normal = reflecting.or(!passes, passing).sample_visible(above, u);
            let reflected = reflect::<R>(above, normal);
            let is_met = !passes | reflected.with_third(-reflected.z()).dot(normal).is_less(zero);
            is_right = !is_specular | (reflected.z().is_more(zero) & is_met);
            wi = R::Vec3::select(is_specular, reflected, wi);
        }
        let wi = wi.with_third(R::select(passes, -wi.z(), wi.z()));
        let wi = upright::<R>(wi, wo);
        let is_returned = is_there & above.z().is_more(zero) & is_right;
        self.evaluate(wo, wi).into_sample(wi, R::ONE, is_returned)
    }
}
