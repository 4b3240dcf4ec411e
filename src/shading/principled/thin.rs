//! The thin principled model: a sheet that scatters diffusely and specularly to both sides, and looks the same from either.
//!
//! Burley 2015 (thin surfaces), in the form in which Mitsuba 3 knows it:
//!
//! - There is no metal and no coat. All specular light, also what is reflected, comes with the share `spec_trans`.
//! - What passes is reflected by facets and mirrored to the other side; they are rougher or smoother by 0.65 `eta` - 0.35. Paths are not
//!   bent, nor do they bounce between the sheet's two faces. Facets that the light does not leave from behind pass none: a part of
//!   what grazes is lost, and not reciprocally.
//! - Sheen can make the sheet reflect more than arrives.

use glam::{Vec2, Vec3};

use super::{Evaluation, base, reflect, schlick, sheen, specular, upright};
use crate::color::Rgb;
use crate::sampling::warp;
use crate::shading::fresnel::{self, DielectricModel};
use crate::shading::{BsdfSample, Ggx};

/// A thin principled sheet. Numbers are in [0, 1] unless stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipledThin {
    /// The colour of diffuse and of transmitted light.
    pub base_color: Rgb,
    /// The perceptual roughness: that of GGX is its square.
    pub roughness: f32,
    /// The stretch of highlights along the first tangent; 0 is isotropic.
    pub anisotropic: f32,
    /// The share of specular light; the rest is diffuse.
    pub spec_trans: f32,
    /// Twice the share of diffuse light that is transmitted, in [0, 2]; the rest is reflected.
    pub diff_trans: f32,
    /// Refractive index of the sheet over that around it, above 0.
    pub eta: f32,
    /// The share of the base colour's hue in the specular reflection.
    pub spec_tint: f32,
    /// The strength of the grazing reflection of fabrics.
    pub sheen: f32,
    /// The share of the base colour's hue in the sheen.
    pub sheen_tint: f32,
    /// The blend from diffuse reflection to imitated subsurface scattering.
    pub flatness: f32,
    /// The rates at which lobes are sampled.
    pub rates: ThinSamplingRates,
}

/// The rates at which lobes are sampled, relative to their shares; not negative. Changes noise, not the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinSamplingRates {
    /// The rate of mirror-like reflection.
    pub specular_reflectance: f32,
    /// The rate of light that passes with the specular lobe.
    pub specular_transmittance: f32,
    /// The rate of diffuse reflection and sheen.
    pub diffuse_reflectance: f32,
    /// The rate of light that passes diffusely.
    pub diffuse_transmittance: f32,
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
struct Lobes {
    specular_reflection: f32,
    specular_transmission: f32,
    diffuse_reflection: f32,
    diffuse_transmission: f32,
}

impl PrincipledThin {
    /// The shares of specular light, of diffusely reflected and of diffusely passing light.
    fn shares(&self) -> (f32, f32, f32) {
        let diffuse = 1.0 - self.spec_trans;
        let passing = 0.5 * self.diff_trans;
        (self.spec_trans, diffuse * (1.0 - passing), diffuse * passing)
    }

    /// The probabilities of sampling; `None` if nothing is reflected or transmitted.
    fn chances(&self) -> Option<Lobes> {
        let (specular, reflected, passing) = self.shares();
        let specular_reflection = 0.5 * specular * self.rates.specular_reflectance;
        let specular_transmission = 0.5 * specular * self.rates.specular_transmittance;
        let diffuse_reflection = reflected * self.rates.diffuse_reflectance;
        let diffuse_transmission = passing * self.rates.diffuse_transmittance;
        let total = specular_reflection + specular_transmission + diffuse_reflection + diffuse_transmission;
        (total > 0.0).then(|| Lobes {
            specular_reflection: specular_reflection / total,
            specular_transmission: specular_transmission / total,
            diffuse_reflection: diffuse_reflection / total,
            diffuse_transmission: diffuse_transmission / total,
        })
    }

    fn reflecting_facets(&self) -> Ggx {
        specular::microfacets(self.roughness, self.anisotropic)
    }

    fn transmitting_facets(&self) -> Ggx {
        specular::microfacets((0.65 * self.eta - 0.35) * self.roughness, self.anisotropic)
    }

    pub(in crate::shading) fn eval_and_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let Evaluation { value, pdf } = self.evaluate(wo, wi);
        (value, pdf)
    }

    fn evaluate(&self, wo: Vec3, wi: Vec3) -> Evaluation {
        let (above, wi) = (upright(wo, wo), upright(wi, wo));
        let evaluation = self.chances().and_then(|chances| {
            if above.z == 0.0 || wi.z == 0.0 {
                None
            } else if wi.z > 0.0 {
                self.reflected(&chances, above, wi)
            } else {
                self.transmitted(&chances, above, wi)
            }
        });
        evaluation.unwrap_or_default()
    }

    fn reflected(&self, chances: &Lobes, wo: Vec3, wi: Vec3) -> Option<Evaluation> {
        let (specular, diffuse, _) = self.shares();
        let facet = specular::reflecting(&self.reflecting_facets(), wo, wi)?;
        let fresnel = fresnel::dielectric(facet.cos, self.eta, DielectricModel::Exact);
        let tinted = schlick::tinted(self.base_color, self.eta, facet.cos, &fresnel);
        let reflectance = Rgb::splat(fresnel.reflectance).lerp(tinted, self.spec_tint);
        let base = base::value(self.roughness, self.flatness, wo.z, wi.z, facet.cos);
        let sheen = self.sheen * sheen::value(self.base_color, self.sheen_tint, wi.z, facet.cos);
        Some(Evaluation {
            value: reflectance * (specular * facet.unmasked * facet.pdf) + diffuse * (self.base_color * base + sheen),
            pdf: chances.specular_reflection * facet.pdf
                + chances.diffuse_reflection * warp::cosine_hemisphere_pdf(wi.z),
        })
    }

    fn transmitted(&self, chances: &Lobes, wo: Vec3, wi: Vec3) -> Option<Evaluation> {
        let (specular, _, diffuse) = self.shares();
        let facet = specular::reflecting(&self.transmitting_facets(), wo, wi.with_z(-wi.z))?;
        let cosine = warp::cosine_hemisphere_pdf(-wi.z);
        let mut value = diffuse * cosine;
        let mut pdf = chances.diffuse_transmission * cosine;
        if wi.dot(facet.normal) < 0.0 {
            let fresnel = fresnel::dielectric(facet.cos, self.eta, DielectricModel::Exact);
            value += specular * (1.0 - fresnel.reflectance) * facet.unmasked * facet.pdf;
            pdf += chances.specular_transmission * facet.pdf;
        }
        Some(Evaluation {
            value: self.base_color * value,
            pdf,
        })
    }

    pub(in crate::shading) fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let chances = self.chances()?;
        let above = upright(wo, wo);
        if above.z == 0.0 {
            return None;
        }
        let below = |v: Vec3| v.with_z(-v.z);
        let specular = chances.specular_reflection + chances.specular_transmission;
        let wi = if u_lobe < specular {
            let passes = u_lobe >= chances.specular_reflection;
            let facets = if passes {
                self.transmitting_facets()
            } else {
                self.reflecting_facets()
            };
            let normal = facets.sample_visible(above, u);
            let reflected = reflect(above, normal);
            if reflected.z <= 0.0 || (passes && below(reflected).dot(normal) >= 0.0) {
                return None;
            }
            if passes { below(reflected) } else { reflected }
        } else {
            let reflected = warp::cosine_hemisphere(u);
            let passes = u_lobe >= specular + chances.diffuse_reflection;
            if passes { below(reflected) } else { reflected }
        };
        let wi = upright(wi, wo);
        self.evaluate(wo, wi).into_sample(wi, 1.0)
    }
}
