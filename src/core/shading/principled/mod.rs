//! The principled model: a diffuse base, metal and rough glass in any proportion, under sheen and a clear coat.
//!
//! Burley, Physically Based Shading at Disney, SIGGRAPH 2012 course notes, and Extending the Disney BRDF to a BSDF with
//! Integrated Subsurface Scattering, 2015 course notes; in Mitsuba 3's form, because its scenes must look the same
//! here:
//!
//! - Light scatters at the surface only: `flatness` imitates subsurface scattering.
//! - Masking is the separable Smith function of the lobe's own roughness, and dielectrics reflect by Fresnel's
//!   equations.
//! - The clear coat is darker than Burley's: f lacks the division by 4 cos wo cos wi. Its strength is 0.25 `clearcoat`.
//! - Sheen covers base and glass (in the thin model the base alone), and does not darken the layers below.
//! - Where `eta` is 1, metal reflects nothing either.
//! - From behind only the glass is visible, without metal or tint; without glass the surface is black.
//!
//! The layers do not conserve energy: over a white base, up to 1.1 times the incoming light leaves towards a viewer
//! overhead, and 1.5 times towards a grazing one. Such values are kept. Reflection is reciprocal; radiance refracted
//! one way is eta^2 times that the other way.

mod base;
mod clearcoat;
mod schlick;
mod sheen;
mod specular;
mod thin;

pub use thin::{PrincipledThin, ThinSamplingRates};

use super::fresnel::{self, DielectricFresnel, DielectricModel};
use super::{BsdfSample, DiffuseLobe, Model, ShadingTables, TransportMode};
use crate::math::{Mask, Real, Vector, real_struct};
use crate::sampling::warp;
use clearcoat::Clearcoat;
use specular::Facet;

/// The clear coat's strength relative to that of other lobes.
const CLEARCOAT_SHARE: f32 = 0.25;

/// The largest power of sheen relative to a white base, which decides how often it is sampled over glass.
const SHEEN_SHARE: f32 = 0.25;

real_struct! {
    /// A principled surface. Numbers are in [0, 1] unless stated.
    pub struct Principled<R> {
        /// The colour of base, metal, and (its root, for each of the two crossings) glass.
        pub base_color: R::Vec3,
        /// The perceptual roughness: that of GGX is its square.
        pub roughness: R,
        /// The stretch of highlights along the first tangent; 0 is isotropic.
        pub anisotropic: R,
        /// The weight of metal.
        pub metallic: R,
        /// The weight of glass in the part that is not metal; the rest is base.
        pub spec_trans: R,
        /// Refractive index inside over outside, above 0; not 1 if there is glass.
        pub eta: R,
        /// The share of the base colour's hue in the dielectric reflection.
        pub spec_tint: R,
        /// The strength of the grazing reflection of fabrics.
        pub sheen: R,
        /// The share of the base colour's hue in the sheen.
        pub sheen_tint: R,
        /// The blend from diffuse reflection to imitated subsurface scattering.
        pub flatness: R,
        /// The strength of a second specular lobe on top.
        pub clearcoat: R,
        /// The gloss of the coat, from satin to glossy.
        pub clearcoat_gloss: R,
        /// The rates at which lobes are sampled.
        pub rates: SamplingRates<R>,
    }
}

real_struct! {
    /// The rates at which lobes are sampled, relative to their strengths; not negative. They change noise, not the
    /// image.
    pub struct SamplingRates<R> {
        /// The rate of reflection and refraction at the base's own interface.
        pub main_specular: R,
        /// The rate of the clear coat.
        pub clearcoat: R,
        /// The rate of diffuse light and sheen.
        pub diffuse_reflectance: R,
    }
}

impl Default for SamplingRates {
    fn default() -> Self {
        Self {
            main_specular: 1.0,
            clearcoat: 1.0,
            diffuse_reflectance: 1.0,
        }
    }
}

/// The relative index whose reflectance at normal incidence is 0.08 `specular`: 1 for 0, 1.5 for 0.5, 1.79 for 1.
pub fn eta_from_specular(specular: f32) -> f32 {
    2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0
}

/// The value f |cos wi| and the solid angle density of one pair of directions.
#[derive(Clone, Copy)]
struct Evaluation<R: Real> {
    value: R::Vec3,
    pdf: R,
}

impl<R: Real> Evaluation<R> {
    /// The evaluation where `condition` holds, else zero.
    #[inline(always)]
    fn only(self, condition: R::Mask) -> Self {
        Self {
            value: self.value.only(condition),
            pdf: self.pdf.only(condition),
        }
    }

    /// The evaluation where `condition` holds, else `other`.
    #[inline(always)]
    fn or(self, condition: R::Mask, other: Self) -> Self {
        Self {
            value: R::Vec3::select(condition, self.value, other.value),
            pdf: R::select(condition, self.pdf, other.pdf),
        }
    }

    #[inline(always)]
    fn into_sample(self, wi: R::Vec3, eta: R, is_returned: R::Mask) -> BsdfSample<R> {
        BsdfSample {
            wi,
            weight: self.value / self.pdf,
            pdf: self.pdf,
            is_delta: R::Mask::NEVER,
            eta,
            is_returned: is_returned & self.pdf.is_more(R::ZERO),
        }
    }
}

/// The interface as seen by a viewer, and the probabilities of sampling each group of lobes.
struct Aspect<R: Real> {
    base: R,
    clearcoat: R,
    specular: R,
    /// The probability that light which facets transmit is sampled as refracted; otherwise it is sampled as reflected.
    refracted: R,
    is_outside: R::Mask,
    /// Index of the far side over that of the viewer's side.
    eta: R,
    /// Whether the viewer sees any light.
    is_seen: R::Mask,
}

impl<R: Real> Aspect<R> {
    #[inline(always)]
    fn fresnel(&self, cos: R) -> DielectricFresnel<R> {
        fresnel::dielectric(cos, self.eta, DielectricModel::Exact)
    }
}

impl<R: Real> Principled<R> {
    /// The weight of glass in the whole material.
    #[inline(always)]
    fn glass(&self) -> R {
        (R::ONE - self.metallic) * self.spec_trans
    }

    /// The interface for a viewer.
    #[inline(always)]
    fn aspect(&self, wo: R::Vec3) -> Aspect<R> {
        let (zero, one) = (R::ZERO, R::ONE);
        let (glass, rates) = (self.glass(), &self.rates);
        let is_outside = wo.z().is_more(zero);
        let is_inside = wo.z().is_less(zero) & glass.is_more(zero);
        let opaque = (one - self.spec_trans).max(R::splat(SHEEN_SHARE) * self.sheen);
        let base = rates.diffuse_reflectance * (one - self.metallic) * opaque;
        let clearcoat = rates.clearcoat * R::splat(CLEARCOAT_SHARE) * self.clearcoat;
        let total = base + clearcoat + rates.main_specular;
        Aspect {
            base: (base / total).only(is_outside),
            clearcoat: (clearcoat / total).only(is_outside),
            specular: R::select(is_outside, rates.main_specular / total, one),
            refracted: R::select(is_outside, glass, one),
            is_outside,
            eta: R::select(is_outside, self.eta, one / self.eta),
            is_seen: (is_outside & total.is_more(zero)) | is_inside,
        }
    }

    #[inline(always)]
    fn evaluate(&self, aspect: &Aspect<R>, wo: R::Vec3, wi: R::Vec3, mode: TransportMode) -> Evaluation<R> {
        let (wo, wi) = (upright::<R>(wo, wo), upright::<R>(wi, wo));
        let distribution = specular::microfacets(self.roughness, self.anisotropic);
        let facet = specular::reflecting(&distribution, wo, wi);
        let is_reflected = aspect.is_seen & wi.z().is_more(R::ZERO) & facet.is_there;
        let evaluation = self.reflected(aspect, wo, wi, &facet).only(is_reflected);
        let is_below = aspect.is_seen & wi.z().is_less(R::ZERO) & aspect.refracted.is_more(R::ZERO);
        if !is_below.any() {
            return evaluation;
        }
        let facet = specular::refracting(&distribution, aspect.eta, wo, wi);
        self.refracted(aspect, &facet, mode)
            .or(is_below & facet.is_there, evaluation)
    }

    #[inline(always)]
    fn refracted(&self, aspect: &Aspect<R>, facet: &Facet<R>, mode: TransportMode) -> Evaluation<R> {
        let transmittance = R::ONE - aspect.fresnel(facet.cos).reflectance;
        let strength = self.glass() * transmittance / mode.refraction_factor(aspect.eta);
        Evaluation {
            value: self.base_color.map(R::sqrt) * (strength * facet.unmasked * facet.pdf),
            pdf: aspect.specular * aspect.refracted * transmittance * facet.pdf,
        }
    }

    /// The reflected light. `facet` is the main lobe's; its angle and normal are those of all lobes.
    #[inline(always)]
    fn reflected(&self, aspect: &Aspect<R>, wo: R::Vec3, wi: R::Vec3, facet: &Facet<R>) -> Evaluation<R> {
        let (zero, one) = (R::ZERO, R::ONE);
        let fresnel = aspect.fresnel(facet.cos);
        let mut value = self.reflectance(aspect, facet.cos, &fresnel) * (facet.unmasked * facet.pdf);
        let mut pdf = aspect.specular * (one - aspect.refracted * (one - fresnel.reflectance)) * facet.pdf;

        let is_outside = aspect.is_outside;
        let base = (one - self.metallic) * (one - self.spec_trans);
        let diffuse = base::value(self.roughness, self.flatness, wo.z(), wi.z(), facet.cos);
        value += self.base_color * (base * diffuse).only(is_outside);
        pdf += aspect.base * warp::cosine_hemisphere_pdf(wi.z());
        let sheen = ((one - self.metallic) * self.sheen).only(is_outside);
        if sheen.is_more(zero).any() {
            let of_sheen = sheen::value(self.base_color, self.sheen_tint, wi.z(), facet.cos) * sheen;
            value += of_sheen.only(sheen.is_more(zero));
        }
        let is_coated = is_outside & self.clearcoat.is_more(zero);
        if is_coated.any() {
            let coat = Clearcoat::new(self.clearcoat_gloss);
            let of_coat = coat.value(wo, wi, facet.normal, facet.cos, &fresnel);
            let strength = R::splat(CLEARCOAT_SHARE) * self.clearcoat;
            value += R::Vec3::even((strength * of_coat).only(is_coated));
            pdf += (aspect.clearcoat * coat.pdf(facet.normal, facet.cos)).only(is_coated);
        }
        Evaluation { value, pdf }
    }

    /// Reflectance of the main lobe's facets, met with cosine `cos`.
    #[inline(always)]
    fn reflectance(&self, aspect: &Aspect<R>, cos: R, fresnel: &DielectricFresnel<R>) -> R::Vec3 {
        let exact = R::Vec3::even(fresnel.reflectance);
        let dielectric = exact.mix(schlick::tinted(self.base_color, self.eta, cos, fresnel), self.spec_tint);
        let outside = dielectric.mix(schlick::interpolated(self.base_color, cos, fresnel), self.metallic);
        let outside = outside.only(!fresnel.reflectance.equals(R::ZERO));
        R::Vec3::select(aspect.is_outside, outside, exact * self.glass())
    }
}

impl<R: Real> Model<R> for Principled<R> {
    #[inline(always)]
    fn diffuse_lobe(&self, _: &ShadingTables, wo: R::Vec3) -> DiffuseLobe<R> {
        let aspect = self.aspect(wo);
        let lobe = DiffuseLobe {
            start: R::ZERO,
            share: aspect.base,
        };
        lobe.or(aspect.is_seen & self.glass().equals(R::ZERO), DiffuseLobe::NONE)
    }

    #[inline(always)]
    fn eval_and_pdf(&self, _: &ShadingTables, wo: R::Vec3, wi: R::Vec3, mode: TransportMode) -> (R::Vec3, R) {
        let Evaluation { value, pdf } = self.evaluate(&self.aspect(wo), wo, wi, mode);
        (value, pdf)
    }

    #[inline(always)]
    fn sample(&self, _: &ShadingTables, wo: R::Vec3, u_lobe: R, u: [R; 2], mode: TransportMode) -> BsdfSample<R> {
        let zero = R::ZERO;
        let aspect = self.aspect(wo);
        let above = upright::<R>(wo, wo);
        let is_of_base = u_lobe.is_less(aspect.base);
        let is_of_coat = !is_of_base & u_lobe.is_less(aspect.base + aspect.clearcoat);
        let is_of_facets = !(is_of_base | is_of_coat);
        let mut wi = above;
        let mut is_refracted = R::Mask::NEVER;
        if is_of_base.any() {
            wi = warp::cosine_hemisphere(u);
        }
        if is_of_coat.any() {
            let normal = Clearcoat::new(self.clearcoat_gloss).sample_normal(u);
            wi = R::Vec3::select(is_of_coat, reflect::<R>(above, normal), wi);
        }
        if is_of_facets.any() {
            let normal = specular::microfacets(self.roughness, self.anisotropic).sample_visible(above, u);
            let fresnel = aspect.fresnel(above.dot(normal));
            let u_refract = (u_lobe - aspect.base - aspect.clearcoat) / aspect.specular;
            let passing = aspect.refracted * (R::ONE - fresnel.reflectance);
            is_refracted = is_of_facets & u_refract.is_less(passing);
            wi = R::Vec3::select(is_of_facets, reflect::<R>(above, normal), wi);
            if is_refracted.any() {
                wi = R::Vec3::select(is_refracted, refract(above, normal, &fresnel), wi);
            }
        }
        // A facet may send light to the wrong side, where it would meet another one: such light is lost.
        let is_right = (is_refracted & wi.z().is_less(zero)) | (!is_refracted & wi.z().is_more(zero));
        let eta = R::select(is_refracted, aspect.eta, R::ONE);
        let wi = upright::<R>(wi, wo);
        self.evaluate(&aspect, wo, wi, mode)
            .into_sample(wi, eta, aspect.is_seen & is_right)
    }
}

/// The vector `v` with the z axis turned to the viewer `wo`.
#[inline(always)]
fn upright<R: Real>(v: R::Vec3, wo: R::Vec3) -> R::Vec3 {
    v.with_third(R::select(wo.z().is_less(R::ZERO), -v.z(), v.z()))
}

#[inline(always)]
fn reflect<R: Real>(wo: R::Vec3, normal: R::Vec3) -> R::Vec3 {
    let cos = wo.dot(normal);
    normal * (cos + cos) - wo
}

/// The refracted direction. `fresnel` is that of `wo` meeting `normal` from its own side.
#[inline(always)]
fn refract<R: Real>(wo: R::Vec3, normal: R::Vec3, fresnel: &DielectricFresnel<R>) -> R::Vec3 {
    let wi = normal * (fresnel.eta_ti * wo.dot(normal) + fresnel.cos_t) - wo * fresnel.eta_ti;
    // Large indices magnify rounding.
    wi.normalize()
}
