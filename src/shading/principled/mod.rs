//! The principled model: a diffuse base, metal and rough glass in any proportion, under sheen and a clear coat.
//!
//! Burley, Physically Based Shading at Disney, SIGGRAPH 2012 course notes, and Extending the Disney BRDF to a BSDF with Integrated
//! Subsurface Scattering, 2015 course notes; in the form in which Mitsuba 3 knows it, because its scenes must look the same here:
//!
//! - Light scatters at the surface only: `flatness` imitates what happens below.
//! - Masking is the separable Smith function of the lobe's own roughness, and dielectrics reflect by Fresnel's equations.
//! - The clear coat is darker than Burley's: f lacks the division by 4 cos wo cos wi. Its strength is 0.25 `clearcoat`.
//! - Sheen lies over base and glass (the thin model's over the base alone), and nothing below is darkened for it.
//! - Where `eta` is 1, metal reflects nothing either.
//! - From behind only the glass is seen, without metal or tint, and black if there is none.
//!
//! The layers do not share energy: over a white base, up to 1.1 times what arrives leaves towards a viewer overhead, and 1.5 times towards
//! a grazing one. Such values are kept. Reflection is reciprocal; radiance refracted one way is eta^2 times that the other way.

mod base;
mod clearcoat;
mod schlick;
mod sheen;
mod specular;
mod thin;

pub use thin::{PrincipledThin, ThinSamplingRates};

use glam::{Vec2, Vec3};

use super::fresnel::{self, DielectricFresnel, DielectricModel};
use super::{BsdfSample, DiffuseLobe, TransportMode};
use crate::color::Rgb;
use crate::sampling::warp;
use clearcoat::Clearcoat;
use specular::Facet;

/// The clear coat's strength relative to that of other lobes.
const CLEARCOAT_SHARE: f32 = 0.25;

/// The power of full sheen relative to a white base, at most: how often it is sampled over glass.
const SHEEN_SHARE: f32 = 0.25;

/// A principled surface. Numbers are in [0, 1] unless stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    /// The colour of base, metal, and (its root, for each of the two crossings) glass.
    pub base_color: Rgb,
    /// The perceptual roughness: that of GGX is its square.
    pub roughness: f32,
    /// The stretch of highlights along the first tangent; 0 is isotropic.
    pub anisotropic: f32,
    /// The share of metal.
    pub metallic: f32,
    /// The share of glass in what is not metal; the rest is base.
    pub spec_trans: f32,
    /// Refractive index inside over outside, above 0; not 1 if there is glass.
    pub eta: f32,
    /// The share of the base colour's hue in the dielectric reflection.
    pub spec_tint: f32,
    /// The strength of the grazing reflection of fabrics.
    pub sheen: f32,
    /// The share of the base colour's hue in the sheen.
    pub sheen_tint: f32,
    /// The blend from diffuse reflection to imitated subsurface scattering.
    pub flatness: f32,
    /// The strength of a second specular lobe on top.
    pub clearcoat: f32,
    /// The gloss of the coat, from satin to glossy.
    pub clearcoat_gloss: f32,
    /// The rates at which lobes are sampled.
    pub rates: SamplingRates,
}

/// The rates at which lobes are sampled, relative to what their strengths suggest; not negative. Changes noise, not the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplingRates {
    /// The rate of reflection and refraction at the base's own interface.
    pub main_specular: f32,
    /// The rate of the clear coat.
    pub clearcoat: f32,
    /// The rate of diffuse light and sheen.
    pub diffuse_reflectance: f32,
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
#[derive(Clone, Copy, Default)]
struct Evaluation {
    value: Rgb,
    pdf: f32,
}

impl Evaluation {
    fn into_sample(self, wi: Vec3, eta: f32) -> Option<BsdfSample> {
        (self.pdf > 0.0).then(|| BsdfSample {
            wi,
            weight: self.value / self.pdf,
            pdf: self.pdf,
            is_delta: false,
            eta,
        })
    }
}

/// The interface as a viewer meets it, and the probabilities of sampling each group of lobes.
struct Aspect {
    base: f32,
    clearcoat: f32,
    specular: f32,
    /// The probability that light that facets do not reflect is sampled as refracted; otherwise it is sampled as reflected.
    refracted: f32,
    outside: bool,
    /// Index of the far side over that of the viewer's.
    eta: f32,
}

impl Aspect {
    fn fresnel(&self, cos: f32) -> DielectricFresnel {
        fresnel::dielectric(cos, self.eta, DielectricModel::Exact)
    }
}

impl Principled {
    /// The share of glass in all.
    fn glass(&self) -> f32 {
        (1.0 - self.metallic) * self.spec_trans
    }

    /// The interface for a viewer; `None` if nothing is seen.
    fn aspect(&self, wo: Vec3) -> Option<Aspect> {
        let glass = self.glass();
        if wo.z < 0.0 && glass > 0.0 {
            return Some(Aspect {
                base: 0.0,
                clearcoat: 0.0,
                specular: 1.0,
                refracted: 1.0,
                outside: false,
                eta: self.eta.recip(),
            });
        }
        let rates = &self.rates;
        let diffuse = (1.0 - self.metallic) * (1.0 - self.spec_trans).max(SHEEN_SHARE * self.sheen);
        let base = rates.diffuse_reflectance * diffuse;
        let clearcoat = rates.clearcoat * CLEARCOAT_SHARE * self.clearcoat;
        let total = base + clearcoat + rates.main_specular;
        (wo.z > 0.0 && total > 0.0).then(|| Aspect {
            base: base / total,
            clearcoat: clearcoat / total,
            specular: rates.main_specular / total,
            refracted: glass,
            outside: true,
            eta: self.eta,
        })
    }

    pub(super) fn diffuse_lobe(&self, wo: Vec3) -> DiffuseLobe {
        match self.aspect(wo).filter(|_| self.glass() == 0.0) {
            Some(aspect) => DiffuseLobe {
                start: 0.0,
                share: aspect.base,
            },
            None => DiffuseLobe::NONE,
        }
    }

    pub(super) fn eval_and_pdf(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> (Rgb, f32) {
        let Evaluation { value, pdf } = self.evaluate(wo, wi, mode);
        (value, pdf)
    }

    fn evaluate(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> Evaluation {
        let Some(aspect) = self.aspect(wo) else {
            return Evaluation::default();
        };
        let (wo, wi) = (upright(wo, wo), upright(wi, wo));
        let distribution = specular::microfacets(self.roughness, self.anisotropic);
        let evaluation = if wi.z > 0.0 {
            specular::reflecting(&distribution, wo, wi).map(|facet| self.reflected(&aspect, wo, wi, &facet))
        } else if wi.z < 0.0 && aspect.refracted > 0.0 {
            specular::refracting(&distribution, aspect.eta, wo, wi).map(|facet| self.refracted(&aspect, &facet, mode))
        } else {
            None
        };
        evaluation.unwrap_or_default()
    }

    fn refracted(&self, aspect: &Aspect, facet: &Facet, mode: TransportMode) -> Evaluation {
        let transmittance = 1.0 - aspect.fresnel(facet.cos).reflectance;
        let strength = self.glass() * transmittance / mode.refraction_factor(aspect.eta);
        Evaluation {
            value: self.base_color.map(f32::sqrt) * (strength * facet.unmasked * facet.pdf),
            pdf: aspect.specular * aspect.refracted * transmittance * facet.pdf,
        }
    }

    /// The reflected light. `facet` is the main lobe's; its angle and normal are those of all lobes.
    fn reflected(&self, aspect: &Aspect, wo: Vec3, wi: Vec3, facet: &Facet) -> Evaluation {
        let fresnel = aspect.fresnel(facet.cos);
        let mut evaluation = Evaluation {
            value: self.reflectance(aspect, facet.cos, &fresnel) * (facet.unmasked * facet.pdf),
            pdf: aspect.specular * (1.0 - aspect.refracted * (1.0 - fresnel.reflectance)) * facet.pdf,
        };
        if !aspect.outside {
            return evaluation;
        }

        let base = (1.0 - self.metallic) * (1.0 - self.spec_trans);
        let sheen = (1.0 - self.metallic) * self.sheen;
        evaluation.value +=
            self.base_color * (base * base::value(self.roughness, self.flatness, wo.z, wi.z, facet.cos));
        evaluation.pdf += aspect.base * warp::cosine_hemisphere_pdf(wi.z);
        if sheen > 0.0 {
            evaluation.value += sheen * sheen::value(self.base_color, self.sheen_tint, wi.z, facet.cos);
        }
        if self.clearcoat > 0.0 {
            let coat = Clearcoat::new(self.clearcoat_gloss);
            let value = coat.value(wo, wi, facet.normal, facet.cos, &fresnel);
            evaluation.value += CLEARCOAT_SHARE * self.clearcoat * value;
            evaluation.pdf += aspect.clearcoat * coat.pdf(facet.normal, facet.cos);
        }
        evaluation
    }

    /// Reflectance of the main lobe's facets, met with cosine `cos`.
    fn reflectance(&self, aspect: &Aspect, cos: f32, fresnel: &DielectricFresnel) -> Rgb {
        let exact = Rgb::splat(fresnel.reflectance);
        if !aspect.outside {
            return self.glass() * exact;
        }
        if fresnel.reflectance == 0.0 {
            return Rgb::ZERO;
        }
        let dielectric = exact.lerp(schlick::tinted(self.base_color, self.eta, cos, fresnel), self.spec_tint);
        dielectric.lerp(schlick::interpolated(self.base_color, cos, fresnel), self.metallic)
    }

    pub(super) fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2, mode: TransportMode) -> Option<BsdfSample> {
        let aspect = self.aspect(wo)?;
        let above = upright(wo, wo);
        let (wi, refracted) = if u_lobe < aspect.base {
            (warp::cosine_hemisphere(u), false)
        } else if u_lobe < aspect.base + aspect.clearcoat {
            (
                reflect(above, Clearcoat::new(self.clearcoat_gloss).sample_normal(u)),
                false,
            )
        } else {
            let normal = specular::microfacets(self.roughness, self.anisotropic).sample_visible(above, u);
            let fresnel = aspect.fresnel(above.dot(normal));
            let u_refract = (u_lobe - aspect.base - aspect.clearcoat) / aspect.specular;
            if u_refract < aspect.refracted * (1.0 - fresnel.reflectance) {
                (refract(above, normal, &fresnel), true)
            } else {
                (reflect(above, normal), false)
            }
        };
        // A facet may send light to the wrong side, where another would catch it: lost here.
        if wi.z == 0.0 || refracted != (wi.z < 0.0) {
            return None;
        }
        let eta = if refracted { aspect.eta } else { 1.0 };
        let wi = upright(wi, wo);
        self.evaluate(wo, wi, mode).into_sample(wi, eta)
    }
}

/// The vector `v` with the z axis turned to the viewer `wo`.
fn upright(v: Vec3, wo: Vec3) -> Vec3 {
    if wo.z < 0.0 { v.with_z(-v.z) } else { v }
}

fn reflect(wo: Vec3, normal: Vec3) -> Vec3 {
    2.0 * wo.dot(normal) * normal - wo
}

/// The refracted direction. `fresnel` is that of `wo` meeting `normal` from its own side.
fn refract(wo: Vec3, normal: Vec3, fresnel: &DielectricFresnel) -> Vec3 {
    let wi = (fresnel.eta_ti * wo.dot(normal) + fresnel.cos_t) * normal - fresnel.eta_ti * wo;
    // Large indices magnify rounding.
    wi.normalize()
}
