//! Parallel light from infinity.

use glam::Vec3;

use super::{LightSample, Target};
use crate::color::Rgb;

#[derive(Clone, Copy, Debug)]
pub(super) struct DirectionalLight {
    /// Unit vector, where the light goes.
    pub direction: Vec3,
    /// The irradiance in W/m^2 on a surface that faces it.
    pub irradiance: Rgb,
}

impl DirectionalLight {
    pub fn sample(&self) -> LightSample {
        LightSample {
            wi: -self.direction,
            target: Target::Infinity,
            radiance: self.irradiance,
            pdf: 1.0,
            is_delta: true,
        }
    }
}
