//! A smooth metal: mirror reflection with the Fresnel reflectance of a complex index; black from behind.

use super::{BsdfSample, fresnel, mirrored};
use crate::color::Rgb;
use glam::Vec3;

/// The optical constants of a metal, and a tint without physical meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConductorSpecular {
    /// Real part of the refractive index relative to the outside.
    pub eta: Rgb,
    /// Imaginary part (extinction), positive.
    pub k: Rgb,
    /// Multiplies the reflection; 1 is physical.
    pub specular_reflectance: Rgb,
}

impl ConductorSpecular {
    /// Reflectance at the cosine `cos_i` between direction and (micro)normal.
    pub fn reflectance(&self, cos_i: f32) -> Rgb {
        self.specular_reflectance * fresnel::conductor(cos_i, self.eta, self.k)
    }
}

/// A smooth metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// The optical constants.
    pub specular: ConductorSpecular,
}

impl Conductor {
    pub(super) fn sample(&self, wo: Vec3) -> Option<BsdfSample> {
        (wo.z > 0.0).then(|| BsdfSample {
            wi: mirrored(wo),
            weight: self.specular.reflectance(wo.z),
            pdf: 1.0,
            is_delta: true,
            eta: 1.0,
        })
    }
}
