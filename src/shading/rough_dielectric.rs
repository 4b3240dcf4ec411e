//! A rough interface between two transparent media: reflection and refraction by microfacets.
//!
//! Walter et al., Microfacet Models for Refraction through Rough Surfaces, EGSR 2007. The surface is the same from both sides;
//! f(wo, wi) / n_o^2 is symmetric for radiance, n_o being the index on the side of wo.

use super::{
    BsdfSample, Microfacet, TransportMode,
    fresnel::{self, DielectricModel},
};
use crate::color::Rgb;
use glam::{Vec2, Vec3};

/// Ground glass, ice, and the like; the normal points outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughDielectric {
    /// The refractive index inside over outside, above 0. With 1 there is no surface, and no density: the smooth dielectric is used then.
    pub eta: f32,
    /// The law of the Fresnel reflectance.
    pub model: DielectricModel,
    /// Roughness of the interface.
    pub distribution: Microfacet,
    /// Multiplies reflected light; 1 is physical.
    pub specular_reflectance: Rgb,
    /// Multiplies refracted light; 1 is physical.
    pub specular_transmittance: Rgb,
}

/// A pair of directions with `wo` above the surface, and the facet that connects them.
struct Facet {
    /// The facet's normal, z > 0.
    m: Vec3,
    /// The cosine of `wo` with it, positive.
    cos_o: f32,
    /// The Fresnel reflectance.
    reflectance: f32,
    /// The Jacobian d omega_m / d omega_i.
    jacobian: f32,
}

impl RoughDielectric {
    /// The index beyond the surface over that before it.
    fn eta_it(&self, wo: Vec3) -> f32 {
        if wo.z > 0.0 { self.eta } else { self.eta.recip() }
    }

    /// The facet that connects the directions; `None` if there is none, with each direction on its side of both facet and surface. `wo.z` is
    /// positive.
    fn facet(&self, wo: Vec3, wi: Vec3, eta_it: f32) -> Option<Facet> {
        let stretch = if wi.z > 0.0 { 1.0 } else { eta_it };
        let m = (wo + stretch * wi).try_normalize()?;
        let m = if m.z < 0.0 { -m } else { m };
        let (cos_o, cos_i) = (wo.dot(m), wi.dot(m));
        if cos_o <= 0.0 || cos_i * wi.z <= 0.0 {
            return None;
        }
        let jacobian = if wi.z > 0.0 {
            0.25 / cos_i
        } else {
            let path = cos_o + eta_it * cos_i;
            eta_it * eta_it * -cos_i / (path * path)
        };
        Some(Facet {
            m,
            cos_o,
            reflectance: fresnel::dielectric(cos_o, eta_it, self.model).reflectance,
            jacobian,
        })
    }

    pub(super) fn eval_and_pdf(&self, wo: Vec3, wi: Vec3, mode: TransportMode) -> (Rgb, f32) {
        if wo.z == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let eta_it = self.eta_it(wo);
        let (wo, wi) = (wo * wo.z.signum(), wi * wo.z.signum());
        let Some(facet) = self.facet(wo, wi, eta_it) else {
            return (Rgb::ZERO, 0.0);
        };
        let (color, lobe) = if wi.z > 0.0 {
            (self.specular_reflectance * facet.reflectance, facet.reflectance)
        } else {
            let passing = 1.0 - facet.reflectance;
            (
                self.specular_transmittance * (passing / mode.refraction_factor(eta_it)),
                passing,
            )
        };
        let facets = &self.distribution;
        let visible = 4.0 * facets.density(facet.m) * facets.g1_over_four_cos(wo) * facet.cos_o * facet.jacobian;
        (
            color * (visible * facets.g1(wi)),
            lobe * visible / facets.masking_ratio(wo),
        )
    }

    pub(super) fn sample(&self, wo: Vec3, u_lobe: f32, u: Vec2, mode: TransportMode) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let (side, facets) = (wo.z.signum(), &self.distribution);
        let wo = wo * side;
        let m = facets.sample_visible(wo, u);
        let cos_o = wo.dot(m);
        if cos_o <= 0.0 {
            return None;
        }
        let eta_it = if side > 0.0 { self.eta } else { self.eta.recip() };
        let fresnel = fresnel::dielectric(cos_o, eta_it, self.model);
        let reflected = u_lobe < fresnel.reflectance;
        let (wi, color, lobe, jacobian, eta) = if reflected {
            let wi = 2.0 * cos_o * m - wo;
            (wi, self.specular_reflectance, fresnel.reflectance, 0.25 / cos_o, 1.0)
        } else {
            let eta_ti = fresnel.eta_ti;
            // A large eta_ti scales rounding up.
            let wi = ((eta_ti * cos_o + fresnel.cos_t) * m - eta_ti * wo).normalize();
            let path = cos_o + eta_it * fresnel.cos_t;
            let jacobian = eta_it * eta_it * -fresnel.cos_t / (path * path);
            let color = self.specular_transmittance * mode.refraction_factor(eta_ti);
            (wi, color, 1.0 - fresnel.reflectance, jacobian, eta_it)
        };
        // Light on the wrong side of the surface would meet another facet, which this model leaves out.
        if (wi.z > 0.0) != reflected || wi.z == 0.0 {
            return None;
        }
        let pdf = 4.0 * lobe * facets.reflected_density(wo, m) * cos_o * jacobian;
        (pdf > 0.0 && pdf.is_finite()).then(|| BsdfSample {
            wi: wi * side,
            weight: color * (facets.masking_ratio(wo) * facets.g1(wi)),
            pdf,
            is_delta: false,
            eta,
        })
    }
}
