//! The sky of Hosek and Wilkie with its sun as a light.
//!
//! The sky is sampled by a table of its luminance over azimuth and height, the sun by its cone; densities are those of
//! the mixture.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::{Mat3, Vec3};

use super::hosek_wilkie::{Atmosphere, SkyModel};
use super::{LightSample, Target};
use crate::color::{Rgb, luminance};
use crate::math::{Frame, Mask, Real, Vector, atan2};
use crate::sampling::{ONE_MINUS_EPSILON, PiecewiseBilinear2d, SquareSample, warp};

#[derive(Clone, Debug)]
pub(super) struct SunSkyLight {
    model: SkyModel,
    /// The orthonormal map from local space; it may mirror.
    world_from_local: Mat3,
    sun: Frame,
    /// The density over azimuth (once around) and the cosine from the zenith, 0 at the horizon.
    density: Option<PiecewiseBilinear2d>,
    /// Probability of sampling the sky.
    sky_share: f32,
    irradiance: f32,
}

/// The nodes of the table along azimuth, and below along height.
const COLUMNS: usize = 129;
const ROWS: usize = 97;

/// The density is nowhere less than this times the average, because the table is coarser than the sky.
const DENSITY_FLOOR: f32 = 0.05;

/// The least share of the samples for the sun, and for the sky: shadows hide the one, roofs the other.
const LEAST_SHARE: f32 = 0.2;

/// The density per solid angle of a density of 1 over the table.
const TABLE_DENSITY: f32 = 0.5 * FRAC_1_PI;

impl SunSkyLight {
    pub fn new(atmosphere: Atmosphere, world_from_local: Mat3) -> Self {
        let model = SkyModel::new(atmosphere);
        let mut values: Vec<f32> = (0..COLUMNS * ROWS)
            .map(|node| {
                let (column, row) = (node % COLUMNS, node / COLUMNS);
                let position = [column as f32 / (COLUMNS - 1) as f32, row as f32 / (ROWS - 1) as f32];
                luminance(model.sky::<f32>(warp::at_height(position))).max(0.0)
            })
            .collect();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        values
            .iter_mut()
            .for_each(|value| *value = value.max(DENSITY_FLOOR * mean));
        let (sky, sun) = (TAU * mean, luminance(model.sun_irradiance()).max(0.0));
        let sky_share = match (sky > 0.0, sun > 0.0) {
            (true, true) => (sky / (sky + sun)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE),
            (true, false) => 1.0,
            (false, _) => 0.0,
        };
        Self {
            model,
            world_from_local,
            sun: Frame::from_normal(atmosphere.sun_direction),
            density: PiecewiseBilinear2d::new(COLUMNS, ROWS, &values),
            sky_share,
            irradiance: 0.5 * sky + sun,
        }
    }

    /// Samples the light where `asked` is set; the density is zero below the horizon and at night.
    #[inline(always)]
    pub fn sample<R: Real>(&self, asked: R::Mask, u: [R; 2]) -> LightSample<R> {
        let (local, mut sky_pdf, is_of_sun) = self.sample_local(asked, u);
        if is_of_sun.any() {
            sky_pdf = R::select(is_of_sun, self.sky_pdf::<R>(local, is_of_sun), sky_pdf);
        }
        let pdf = self.mixed(sky_pdf, local);
        LightSample {
            wi: self.to_world::<R>(local),
            target: Target::Infinity,
            radiance: self.model.sky::<R>(local) + self.model.sun::<R>(local),
            pdf: pdf.only(asked),
            is_delta: false,
        }
    }

    /// The directions of [`Self::sample`]; undefined where their density is zero.
    #[inline(always)]
    pub fn direction<R: Real>(&self, asked: R::Mask, u: [R; 2]) -> R::Vec3 {
        self.to_world::<R>(self.sample_local(asked, u).0)
    }

    #[inline(always)]
    fn to_world<R: Real>(&self, local: R::Vec3) -> R::Vec3 {
        let Mat3 { x_axis, y_axis, z_axis } = self.world_from_local;
        local.along([x_axis, y_axis, z_axis])
    }

    /// Directions in local space, the densities of those of the sky, and a mask of those of the sun.
    #[inline(always)]
    fn sample_local<R: Real>(&self, asked: R::Mask, [u, v]: [R; 2]) -> (R::Vec3, R, R::Mask) {
        let is_of_sky = asked & u.is_less(R::splat(self.sky_share));
        let is_of_sun = asked & !is_of_sky;
        let (mut local, mut sky_pdf) = (R::Vec3::even(R::ZERO), R::ZERO);
        if let Some(density) = self.density.as_ref().filter(|_| is_of_sky.any()) {
            let within = (u / R::splat(self.sky_share)).min(R::splat(ONE_MINUS_EPSILON));
            let SquareSample { position, pdf } = density.sample([within, v]);
            (local, sky_pdf) = (
                warp::at_height(position),
                (pdf * R::splat(TABLE_DENSITY)).only(is_of_sky),
            );
        }
        if is_of_sun.any() {
            let across = (u - R::splat(self.sky_share)) / R::splat(1.0 - self.sky_share);
            let u = [across.min(R::splat(ONE_MINUS_EPSILON)), v];
            let in_cone = warp::uniform_cone(u, R::splat(self.model.sun_one_minus_cos()));
            let of_sun = in_cone.along([self.sun.s, self.sun.t, self.sun.n]);
            local = R::Vec3::select(is_of_sky, local, of_sun);
        }
        (local, sky_pdf, is_of_sun)
    }

    /// The radiance from a direction where `asked` is set, and the densities per solid angle with which
    /// [`Self::sample`] finds it as a part of the sky and of the sun. Their sum is its density.
    #[inline(always)]
    pub fn radiance_and_pdfs<R: Real>(&self, asked: R::Mask, wi: R::Vec3) -> (R::Vec3, [R; 2]) {
        let Mat3 { x_axis, y_axis, z_axis } = self.world_from_local;
        let local = wi.coordinates([x_axis, y_axis, z_axis]);
        let radiance = self.model.sky::<R>(local) + self.model.sun::<R>(local);
        let sky = self.sky_pdf::<R>(local, asked) * R::splat(self.sky_share);
        (radiance, [sky, self.sun_pdf::<R>(local)])
    }

    /// The probability of sampling the sky, which is done with the first number below it.
    pub fn sky_share(&self) -> f32 {
        self.sky_share
    }

    /// The radiance of the sky alone.
    pub fn sky_radiance(&self, wi: Vec3) -> Rgb {
        self.model.sky::<f32>(self.world_from_local.transpose() * wi)
    }

    pub fn radiance(&self, wi: Vec3) -> Rgb {
        let local = self.world_from_local.transpose() * wi;
        self.model.sky::<f32>(local) + self.model.sun::<f32>(local)
    }

    /// Whether the direction `wi` leads to the sun.
    pub fn is_sun(&self, wi: Vec3) -> bool {
        let local = self.world_from_local.transpose() * wi;
        self.model.sun::<f32>(local) != Rgb::ZERO
    }

    /// The approximate irradiance (luminance) on a surface that faces sun and sky.
    pub fn irradiance(&self) -> f32 {
        self.irradiance
    }

    /// The density with which the sky is sampled in a direction in local space, where `condition` holds.
    #[inline(always)]
    fn sky_pdf<R: Real>(&self, local: R::Vec3, condition: R::Mask) -> R {
        let is_above = condition & !local.z().is_less(R::ZERO);
        let turn = atan2(local.y(), local.x()) * R::splat(1.0 / TAU);
        let place = [turn - turn.floor(), local.z().min(R::ONE)];
        let pdf = self.density.as_ref().map_or(R::ZERO, |density| density.pdf(place));
        (pdf * R::splat(TABLE_DENSITY)).only(is_above)
    }

    /// The density of sky and sun together, given the sky's density `sky_pdf`. The sun below the horizon is invisible.
    #[inline(always)]
    fn mixed<R: Real>(&self, sky_pdf: R, local: R::Vec3) -> R {
        sky_pdf.mul_add(R::splat(self.sky_share), self.sun_pdf(local))
    }

    /// The density with which the sun is sampled, times the probability of sampling it.
    #[inline(always)]
    fn sun_pdf<R: Real>(&self, local: R::Vec3) -> R {
        let rim = self.model.sun_one_minus_cos();
        let here = R::HALF * (local - R::Vec3::same(self.sun.n)).length_squared();
        let is_in_sun = !(local.z().is_less(R::ZERO) | R::is_above(here, rim));
        R::splat((1.0 - self.sky_share) * warp::uniform_cone_pdf(rim)).only(is_in_sun)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::{LANES, Lanes, lanes_of};

    #[test]
    fn directions_in_lanes_are_those_of_one() {
        let number = |k: usize, factor: f32| (k as f32 * factor).fract();
        for (height, sky_scale, sun_scale) in [(0.8, 1.0, 1.0), (0.05, 1.0, 0.0), (0.3, 0.0, 1.0), (-0.2, 1.0, 1.0)] {
            let light = SunSkyLight::new(
                Atmosphere {
                    turbidity: 3.0,
                    albedo: Rgb::splat(0.3),
                    sun_direction: Vec3::new(0.6, -0.2, height).normalize(),
                    sky_scale,
                    sun_scale,
                    sun_aperture: 0.009,
                    limb_darkening: height > 0.5,
                },
                Mat3::from_rotation_x(0.4),
            );
            let mut found = 0;
            for start in (0..100_000).step_by(LANES) {
                let [u, v] =
                    [0.618_034, 0.414_214].map(|factor| std::array::from_fn(|lane| number(start + lane, factor)));
                let asked = 0xfffd;
                let lanes = light.sample(lanes_of(asked), [Lanes::new(u), Lanes::new(v)]);
                let is_there = lanes.pdf.simd_gt(Lanes::ZERO).to_bitmask();
                assert_eq!(is_there & !asked, 0);
                for lane in (0..LANES).filter(|lane| asked >> lane & 1 == 1) {
                    let one = light.sample(true, [u[lane], v[lane]]);
                    assert_eq!(is_there >> lane & 1 == 1, one.pdf > 0.0);
                    if one.pdf <= 0.0 {
                        continue;
                    }
                    found += 1;
                    // A full turn of azimuth counts as a rounding difference in the table.
                    assert!(
                        lanes.wi.get(lane).abs_diff_eq(one.wi, 4e-6),
                        "{} {}",
                        lanes.wi.get(lane),
                        one.wi
                    );
                    let (radiance, pdf) = (lanes.radiance.get(lane), lanes.pdf.as_array()[lane]);
                    // Rounding decides on directions at the rim of the sun.
                    let is_rim =
                        (1.0 - one.radiance.dot(light.radiance(one.wi)) / one.radiance.length_squared()).abs() > 1e-3;
                    assert!(
                        is_rim || radiance.abs_diff_eq(one.radiance, 1e-3 * one.radiance.max_element()),
                        "{radiance} {}",
                        one.radiance
                    );
                    assert!(is_rim || (pdf - one.pdf).abs() <= 1e-3 * one.pdf, "{pdf} {}", one.pdf);
                    let (_, [sky, sun]) = light.radiance_and_pdfs::<f32>(true, one.wi);
                    let again = sky + sun;
                    assert!(
                        is_rim || (again - one.pdf).abs() <= 2e-3 * one.pdf,
                        "{again} {}",
                        one.pdf
                    );
                }
            }
            assert_eq!(found > 50_000, height > 0.0, "{found}");
        }
    }
}
