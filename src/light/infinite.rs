//! Emitters at infinity: dispatch over their kinds.
//!
//! Densities are given the light; the probability of the light is the table's.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::LightSample;
use super::constant::ConstantLight;
use super::directional::DirectionalLight;
use crate::color::{Rgb, luminance};
use crate::sampling::warp;

#[derive(Clone, Debug)]
pub(super) enum InfiniteLight {
    Directional(DirectionalLight),
    Constant(ConstantLight),
}

impl InfiniteLight {
    /// Irradiance (luminance, W/m^2) on a surface that faces the light, about: its weight among the lights at infinity.
    pub fn irradiance(&self) -> f32 {
        match self {
            Self::Directional(light) => luminance(light.irradiance),
            Self::Constant(light) => PI * luminance(light.radiance),
        }
    }

    /// Whether rays that leave the scene meet it.
    pub fn is_seen(&self) -> bool {
        match self {
            Self::Directional(_) => false,
            Self::Constant(_) => true,
        }
    }

    pub fn sample(&self, u: Vec2) -> LightSample {
        match self {
            Self::Directional(light) => light.sample(),
            Self::Constant(light) => light.sample(u),
        }
    }

    /// Density per solid angle of [`Self::sample`].
    pub fn pdf(&self, _wi: Vec3) -> f32 {
        match self {
            Self::Directional(_) => 0.0,
            Self::Constant(_) => warp::UNIFORM_SPHERE_PDF,
        }
    }

    /// Radiance arriving against the direction `wi`.
    pub fn radiance(&self, _wi: Vec3) -> Rgb {
        match self {
            Self::Directional(_) => Rgb::ZERO,
            Self::Constant(light) => light.radiance,
        }
    }
}
