//! Dispatch over the kinds of emitters at infinity.
//!
//! Densities here are for a given light; the light table multiplies them by the probability of the light.

use std::f32::consts::PI;

use glam::Vec3;

use super::constant::ConstantLight;
use super::directional::DirectionalLight;
use super::environment::EnvironmentLight;
use super::reference::Reference;
use super::sun_sky::SunSkyLight;
use super::{LightReference, LightSample};
use crate::color::{Rgb, luminance};
use crate::math::Real;

#[derive(Clone, Debug)]
pub(super) enum InfiniteLight {
    Directional(DirectionalLight),
    Constant(ConstantLight),
    Environment(EnvironmentLight),
    SunSky(Box<SunSkyLight>),
}

impl InfiniteLight {
    /// The approximate irradiance (luminance, W/m^2) on a surface that faces the light: its weight among the lights at
    /// infinity.
    pub fn irradiance(&self) -> f32 {
        match self {
            Self::Directional(light) => luminance(light.irradiance),
            Self::Constant(light) => PI * luminance(light.radiance),
            Self::Environment(light) => PI * light.mean_luminance(),
            Self::SunSky(light) => light.irradiance(),
        }
    }

    /// Whether rays that leave the scene see it.
    pub fn is_seen(&self) -> bool {
        match self {
            Self::Directional(_) => false,
            Self::Constant(_) | Self::Environment(_) | Self::SunSky(_) => true,
        }
    }

    /// Samples a direction; the density is zero where the light is black, or on the horizon of the reference.
    #[inline(always)]
    pub fn sample<R: Real>(&self, from: &Reference<R>, u: [R; 2]) -> LightSample<R> {
        match self {
            Self::Directional(light) => light.sample(),
            Self::Constant(light) => light.sample(from, u),
            Self::Environment(light) => light.sample(from.asked, u),
            Self::SunSky(light) => light.sample(from.asked, u),
        }
    }

    /// The radiance as [`Self::radiance`], and the density per solid angle of [`Self::sample`].
    #[inline]
    pub fn radiance_and_pdf(&self, reference: &LightReference, wi: Vec3) -> (Rgb, f32) {
        match self {
            Self::Directional(_) => (Rgb::ZERO, 0.0),
            Self::Constant(light) => (light.radiance, light.pdf(reference, wi)),
            Self::Environment(light) => light.radiance_and_pdf(wi),
            Self::SunSky(light) => light.radiance_and_pdf(wi),
        }
    }

    /// Whether the direction `wi` leads to the sun of a sky.
    pub fn is_sun(&self, wi: Vec3) -> bool {
        match self {
            Self::Directional(_) | Self::Constant(_) | Self::Environment(_) => false,
            Self::SunSky(light) => light.is_sun(wi),
        }
    }

    /// Radiance arriving against the direction `wi`.
    pub fn radiance(&self, wi: Vec3) -> Rgb {
        match self {
            Self::Directional(_) => Rgb::ZERO,
            Self::Constant(light) => light.radiance,
            Self::Environment(light) => light.radiance(wi),
            Self::SunSky(light) => light.radiance(wi),
        }
    }
}
