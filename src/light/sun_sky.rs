//! The sky of Hosek and Wilkie with its sun as a light.
//!
//! The sky is sampled by a table of its luminance over azimuth and height, the sun by its cone; the density is that of the mixture.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::{Mat3, Vec2, Vec3};

use super::hosek_wilkie::{Atmosphere, SkyModel};
use super::{LightSample, Target};
use crate::color::{Rgb, luminance};
use crate::math::Frame;
use crate::sampling::{ONE_MINUS_EPSILON, PiecewiseBilinear2d, warp};

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

/// The density is nowhere less than this times the average, for the table is coarser than the sky.
const DENSITY_FLOOR: f32 = 0.05;

/// The least share of the samples for the sun, and for the sky: there are shadows and roofs.
const LEAST_SHARE: f32 = 0.2;

/// The density per solid angle of a density that is uniform over the table.
const TABLE_DENSITY: f32 = 0.5 * FRAC_1_PI;

impl SunSkyLight {
    pub fn new(atmosphere: Atmosphere, world_from_local: Mat3) -> Self {
        let model = SkyModel::new(atmosphere);
        let mut values: Vec<f32> = (0..COLUMNS * ROWS)
            .map(|node| {
                let (column, row) = (node % COLUMNS, node / COLUMNS);
                let position = Vec2::new(column as f32 / (COLUMNS - 1) as f32, row as f32 / (ROWS - 1) as f32);
                luminance(model.sky(direction(position))).max(0.0)
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

    /// Samples the light; None below the horizon and at night.
    pub fn sample(&self, u: Vec2) -> Option<LightSample> {
        let (local, sky_pdf) = if u.x < self.sky_share {
            let u = Vec2::new((u.x / self.sky_share).min(ONE_MINUS_EPSILON), u.y);
            let sample = self.density.as_ref()?.sample(u);
            (direction(sample.position), sample.pdf * TABLE_DENSITY)
        } else {
            let x = (u.x - self.sky_share) / (1.0 - self.sky_share);
            let u = Vec2::new(x.min(ONE_MINUS_EPSILON), u.y);
            let local = self.sun.to_world(warp::uniform_cone(u, self.model.sun_one_minus_cos()));
            (local, self.sky_pdf(local))
        };
        let pdf = self.mixed(sky_pdf, local);
        (pdf > 0.0).then(|| LightSample {
            wi: self.world_from_local * local,
            target: Target::Infinity,
            radiance: self.model.sky(local) + self.model.sun(local),
            pdf,
            is_delta: false,
        })
    }

    /// Density per solid angle of [`Self::sample`].
    pub fn pdf(&self, wi: Vec3) -> f32 {
        let local = self.world_from_local.transpose() * wi;
        self.mixed(self.sky_pdf(local), local)
    }

    pub fn radiance(&self, wi: Vec3) -> Rgb {
        let local = self.world_from_local.transpose() * wi;
        self.model.sky(local) + self.model.sun(local)
    }

    /// The approximate irradiance (luminance) on a surface that faces sun and sky.
    pub fn irradiance(&self) -> f32 {
        self.irradiance
    }

    /// The density with which the sky is sampled in a direction in local space.
    fn sky_pdf(&self, local: Vec3) -> f32 {
        if local.z < 0.0 {
            return 0.0;
        }
        let turn = local.y.atan2(local.x) / TAU;
        let position = Vec2::new(turn - turn.floor(), local.z.min(1.0));
        let density = self.density.as_ref();
        density.map_or(0.0, |density| density.pdf(position)) * TABLE_DENSITY
    }

    /// The density of sky and sun together, where that of the sky is `sky_pdf`. The sun below the horizon is not seen.
    fn mixed(&self, sky_pdf: f32, local: Vec3) -> f32 {
        let rim = self.model.sun_one_minus_cos();
        let inside = local.z >= 0.0 && 0.5 * local.distance_squared(self.sun.n) <= rim;
        let sun = if inside { warp::uniform_cone_pdf(rim) } else { 0.0 };
        self.sky_share * sky_pdf + (1.0 - self.sky_share) * sun
    }
}

/// The direction at a position of the table.
fn direction(position: Vec2) -> Vec3 {
    let (sin, cos) = (TAU * position.x).sin_cos();
    let radius = ((1.0 - position.y) * (1.0 + position.y)).max(0.0).sqrt();
    Vec3::new(radius * cos, radius * sin, position.y)
}
