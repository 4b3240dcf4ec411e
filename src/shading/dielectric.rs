//! A smooth interface between two transparent media: reflection and refraction, chosen by the Fresnel reflectance.

use super::{
    BsdfSample, TransportMode,
    fresnel::{self, DielectricModel},
    mirrored,
};
use crate::color::Rgb;
use glam::Vec3;

/// Smooth glass, water, and the like; the normal points outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Refractive index inside over outside, above 0.
    pub eta: f32,
    /// How the Fresnel reflectance is computed.
    pub model: DielectricModel,
    /// Multiplies reflected light; 1 is physical.
    pub specular_reflectance: Rgb,
    /// Multiplies refracted light; 1 is physical.
    pub specular_transmittance: Rgb,
}

impl Dielectric {
    pub(super) fn sample(&self, wo: Vec3, u_lobe: f32, mode: TransportMode) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let fresnel = fresnel::dielectric(wo.z, self.eta, self.model);
        let (eta_it, eta_ti) = (fresnel.eta_it, fresnel.eta_ti);
        Some(if u_lobe < fresnel.reflectance {
            BsdfSample {
                wi: mirrored(wo),
                weight: self.specular_reflectance,
                pdf: fresnel.reflectance,
                is_delta: true,
                eta: 1.0,
            }
        } else {
            BsdfSample {
                wi: Vec3::new(-eta_ti * wo.x, -eta_ti * wo.y, fresnel.cos_t),
                weight: self.specular_transmittance * mode.refraction_factor(eta_ti),
                pdf: 1.0 - fresnel.reflectance,
                is_delta: true,
                eta: eta_it,
            }
        })
    }
}
