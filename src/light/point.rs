//! A point that sends the same intensity in all directions.

use glam::Vec3;

use super::{LightSample, Target};
use crate::color::Rgb;

#[derive(Clone, Copy, Debug)]
pub(super) struct PointLight {
    pub position: Vec3,
    /// Radiant intensity, W/sr.
    pub intensity: Rgb,
}

impl PointLight {
    /// None at the very point.
    pub fn sample(&self, reference: Vec3) -> Option<LightSample> {
        let to_light = self.position - reference;
        Some(LightSample {
            wi: to_light.try_normalize()?,
            target: Target::Point(self.position),
            radiance: self.intensity / to_light.length_squared(),
            pdf: 1.0,
            is_delta: true,
        })
    }
}
