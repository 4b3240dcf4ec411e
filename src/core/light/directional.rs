//! Parallel light from infinity.

use glam::Vec3;

use super::{LightSample, Target};
use crate::color::Rgb;
use crate::math::{Real, Vector};

#[derive(Clone, Copy, Debug)]
pub(super) struct DirectionalLight {
    /// Unit vector in which the light travels.
    pub direction: Vec3,
    /// The irradiance in W/m^2 on a surface that faces it.
    pub irradiance: Rgb,
}

impl DirectionalLight {
    pub fn sample<R: Real>(&self) -> LightSample<R> {
        LightSample {
            wi: R::Vec3::same(-self.direction),
            target: Target::Infinity,
            radiance: R::Vec3::same(self.irradiance),
            pdf: R::ONE,
            is_delta: true,
        }
    }
}
