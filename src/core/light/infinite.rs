//! Dispatch over the kinds of emitters at infinity.
//!
//! Densities here are for a given light; the light table multiplies them by the probability of the light.

use std::f32::consts::PI;

use glam::Vec3;

use super::constant::ConstantLight;
use super::directional::DirectionalLight;
use super::environment::EnvironmentLight;
use super::portal::{Portals, Seen};
use super::reference::Reference;
use super::sun_sky::SunSkyLight;
use super::{LightReference, LightSample, Target};
use crate::color::{Rgb, luminance};
use crate::math::{Mask, Real, Vector};
use crate::sampling::ONE_MINUS_EPSILON;

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

    /// The directions of [`Self::sample`]; undefined where their density is zero.
    #[inline(always)]
    pub fn direction<R: Real>(&self, from: &Reference<R>, u: [R; 2]) -> R::Vec3 {
        match self {
            Self::Directional(light) => light.sample::<R>().wi,
            Self::Constant(light) => light.sample(from, u).wi,
            Self::Environment(light) => light.direction(from.asked, u),
            Self::SunSky(light) => light.direction(from.asked, u),
        }
    }

    /// The radiance as [`Self::radiance`], and the density per solid angle of [`Self::sample`].
    #[inline]
    pub fn radiance_and_pdf(&self, reference: &LightReference, wi: Vec3) -> (Rgb, f32) {
        let (radiance, [sky, sun]) = self.radiance_and_pdfs::<f32>(&reference.into(), wi);
        (radiance, sky + sun)
    }

    /// The radiance as [`Self::radiance`], and the densities per solid angle with which [`Self::sample`] gives these
    /// directions as those of the sky, which may be sampled through portals instead, and of the sun.
    #[inline(always)]
    pub(super) fn radiance_and_pdfs<R: Real>(&self, from: &Reference<R>, wi: R::Vec3) -> (R::Vec3, [R; 2]) {
        match self {
            Self::Directional(_) => (R::Vec3::even(R::ZERO), [R::ZERO; 2]),
            Self::Constant(light) => (R::Vec3::same(light.radiance), [light.pdf(from, wi), R::ZERO]),
            Self::Environment(light) => {
                let (radiance, pdf) = light.radiance_and_pdf(from.asked, wi);
                (radiance, [pdf, R::ZERO])
            }
            Self::SunSky(light) => light.radiance_and_pdfs(from.asked, wi),
        }
    }

    /// The probability of sampling the sky, which [`Self::sample`] does where the first number is below it.
    pub(super) fn sky_share(&self) -> f32 {
        match self {
            Self::Directional(_) => 0.0,
            Self::Constant(_) | Self::Environment(_) => 1.0,
            Self::SunSky(light) => light.sky_share(),
        }
    }

    /// [`Self::sample`], or [`Self::sample_through`] where there are portals.
    #[inline(always)]
    pub fn sample_with<R: Real>(&self, portals: Option<&Portals>, from: &Reference<R>, u: [R; 2]) -> LightSample<R> {
        match portals {
            None => self.sample(from, u),
            Some(portals) => self.sample_through(portals, from, u),
        }
    }

    /// [`Self::sample`], with a share of the directions to the sky through portals.
    #[inline(never)]
    pub fn sample_through<R: Real>(&self, portals: &Portals, from: &Reference<R>, [u, v]: [R; 2]) -> LightSample<R> {
        let sky_share = R::splat(self.sky_share());
        let is_of_sky = from.asked & u.is_less(sky_share);
        let seen = portals.seen_from(from);
        let through = seen.sample([(u / sky_share).min(R::splat(ONE_MINUS_EPSILON)), v]);
        let is_chosen = is_of_sky & through.is_chosen;
        let others = from.asked & !is_chosen;
        let mut wi = through.wi;
        if others.any() {
            // What is left of the numbers is as well spread as they were.
            let u = R::select(is_of_sky, through.rest * sky_share, u);
            let from = Reference { asked: others, ..*from };
            wi = R::Vec3::select(is_chosen, wi, self.direction(&from, [u, v]));
        }
        let (radiance, pdfs) = self.radiance_and_pdfs(from, wi);
        LightSample {
            wi,
            target: Target::Infinity,
            radiance,
            pdf: self.mixed(&seen, pdfs, wi).only(from.asked),
            is_delta: false,
        }
    }

    /// The radiance as [`Self::radiance`], and the density per solid angle of [`Self::sample_through`].
    #[inline(never)]
    pub fn radiance_and_pdf_through(&self, portals: &Portals, reference: &LightReference, wi: Vec3) -> (Rgb, f32) {
        let from = Reference::from(reference);
        let (radiance, pdfs) = self.radiance_and_pdfs::<f32>(&from, wi);
        (radiance, self.mixed(&portals.seen_from(&from), pdfs, wi))
    }

    /// The density of directions through portals and others together, given those of [`Self::radiance_and_pdfs`].
    #[inline(always)]
    fn mixed<R: Real>(&self, seen: &Seen<R>, [sky, sun]: [R; 2], wi: R::Vec3) -> R {
        let through = R::splat(self.sky_share()) * seen.pdf(wi);
        (R::ONE - seen.share()).mul_add(sky, through + sun)
    }

    /// Whether the direction `wi` leads to the sun of a sky.
    pub fn is_sun(&self, wi: Vec3) -> bool {
        match self {
            Self::Directional(_) | Self::Constant(_) | Self::Environment(_) => false,
            Self::SunSky(light) => light.is_sun(wi),
        }
    }

    /// Radiance of the sky, without a sun of its own, arriving against the direction `wi`.
    pub(super) fn sky_radiance(&self, wi: Vec3) -> Rgb {
        match self {
            Self::SunSky(light) => light.sky_radiance(wi),
            Self::Directional(_) | Self::Constant(_) | Self::Environment(_) => self.radiance(wi),
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
