//! The same radiance from all directions.

use glam::Vec2;

use super::{LightSample, Target};
use crate::color::Rgb;
use crate::sampling::warp;

#[derive(Clone, Copy, Debug)]
pub(super) struct ConstantLight {
    pub radiance: Rgb,
}

impl ConstantLight {
    pub fn sample(&self, u: Vec2) -> LightSample {
        LightSample {
            wi: warp::uniform_sphere(u),
            target: Target::Infinity,
            radiance: self.radiance,
            pdf: warp::UNIFORM_SPHERE_PDF,
            is_delta: false,
        }
    }
}
