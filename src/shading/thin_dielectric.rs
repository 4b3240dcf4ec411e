//! A thin pane of glass: both its interfaces and all reflections between them as one surface, through which light goes straight.

use super::{
    BsdfSample,
    fresnel::{self, DielectricModel},
    mirrored,
};
use crate::color::Rgb;
use glam::Vec3;

/// A window pane, or a bubble; the same from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinDielectric {
    /// Refractive index of the pane over that around it, above 0.
    pub eta: f32,
    /// The law of the Fresnel reflectance.
    pub model: DielectricModel,
    /// Multiplies reflected light; 1 is physical.
    pub specular_reflectance: Rgb,
    /// Multiplies the light that goes through; 1 is physical.
    pub specular_transmittance: Rgb,
}

impl ThinDielectric {
    /// The reflected fraction: r + t r t + t r^3 t + ... = 2 r / (1 + r).
    fn reflectance(&self, wo: Vec3) -> f32 {
        let once = fresnel::dielectric(wo.z.abs(), self.eta, self.model).reflectance;
        2.0 * once / (1.0 + once)
    }

    /// The share of the light that goes through to `wo`.
    pub(super) fn transmittance(&self, wo: Vec3) -> Rgb {
        (1.0 - self.reflectance(wo)) * self.specular_transmittance
    }

    pub(super) fn sample(&self, wo: Vec3, u_lobe: f32) -> BsdfSample {
        let reflectance = self.reflectance(wo);
        let (wi, weight, pdf) = if u_lobe < reflectance {
            (mirrored(wo), self.specular_reflectance, reflectance)
        } else {
            (-wo, self.specular_transmittance, 1.0 - reflectance)
        };
        BsdfSample {
            wi,
            weight,
            pdf,
            is_delta: true,
            eta: 1.0,
        }
    }
}
