//! How much light lamps give for their strength: the solid angles and areas between intensity, irradiance and power.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::hosek_wilkie::{Atmosphere, SkyModel};
use super::{Projector, Spot};
use crate::color::luminance;
use crate::sampling::warp;
use crate::texture::Image;

/// The steps of an integral along each axis.
const STEPS: usize = 192;

/// The largest deviation of a map from one that only turns and scales, relative to its scale.
const UNEVEN: f64 = 1e-6;

impl Spot {
    /// The solid angle over which the intensity along the axis would give the power of the light, in steradians: the
    /// integral of the falloff, without the texture. Of a falloff that is linear in the angle it is
    /// 2 pi (1 - (sin c - sin b) / (c - b)) with the angles c of the cutoff and b of the beam. A transform that shears
    /// stretches the cone.
    pub fn solid_angle(&self) -> f64 {
        let (cutoff, beam) = (f64::from(self.cutoff_angle), f64::from(self.beam_angle));
        let matrix = self.world_from_local.matrix3.as_dmat3();
        let scale = matrix.z_axis.length();
        let product = matrix.transpose() * matrix;
        let turned = product * (scale * scale).recip();
        if turned.abs_diff_eq(glam::DMat3::IDENTITY, UNEVEN) {
            let chord = match cutoff > beam {
                true => (cutoff.sin() - beam.sin()) / (cutoff - beam),
                false => cutoff.cos(),
            };
            return TAU * (1.0 - chord);
        }
        // A local solid angle at the direction l is |det M| / |M l|^3 times as large in the world.
        let determinant = matrix.determinant().abs();
        let ring = |theta: f64| {
            let (sin, cos) = theta.sin_cos();
            let at = |index: usize| {
                let (sin_phi, cos_phi) = (TAU * index as f64 / STEPS as f64).sin_cos();
                let local = DVec3::new(sin * cos_phi, sin * sin_phi, cos);
                determinant / (matrix * local).length().powi(3)
            };
            sin * TAU / STEPS as f64 * (0..STEPS).map(at).sum::<f64>()
        };
        let fading = |theta: f64| ring(theta) * (cutoff - theta) / (cutoff - beam);
        let rim = if cutoff > beam {
            integral(beam, cutoff, fading)
        } else {
            0.0
        };
        integral(0.0, beam, ring) + rim
    }
}

impl Projector {
    /// The power of the light for an irradiance and a scale of 1 all over the image, in units of area: pi times the
    /// lit area of the plane z = 1. A transform that shears changes it.
    pub fn power_of_one(&self) -> f64 {
        let matrix = self.world_from_local.matrix3.as_dmat3();
        let half = self.half_size.as_dvec2();
        let scaled_normal = matrix.x_axis.cross(matrix.y_axis);
        let share = |x: f64, y: f64| {
            let place = matrix * DVec3::new(x, y, 1.0);
            (scaled_normal.dot(place) / matrix.z_axis.dot(place)).abs()
        };
        let column = |x: f64| integral(-half.y, half.y, |y| share(x, y));
        PI * integral(-half.x, half.x, column)
    }

    /// The intensity along the axis in W/sr for an irradiance and a scale of 1.
    pub fn intensity_of_one(&self) -> f64 {
        PI * self.world_from_local.matrix3.as_dmat3().z_axis.length()
    }
}

/// The integral from `from` to `to` by the midpoints of equal steps.
fn integral(from: f64, to: f64, value: impl Fn(f64) -> f64) -> f64 {
    let step = (to - from) / STEPS as f64;
    step * (0..STEPS)
        .map(|index| value(from + (index as f64 + 0.5) * step))
        .sum::<f64>()
}

impl Atmosphere {
    /// The luminance of the irradiance by the sky alone, without the sun, on a surface that lies flat, in W/m².
    pub fn sky_irradiance(&self) -> f32 {
        const SIDE: usize = 256;
        let model = SkyModel::new(*self);
        let at = |index: usize| {
            let u = [index % SIDE, index / SIDE].map(|cell| (cell as f32 + 0.5) / SIDE as f32);
            luminance(model.sky::<f32>(warp::cosine_hemisphere(u))).max(0.0)
        };
        // The density of the directions is the cosine over pi.
        std::f32::consts::PI * (0..SIDE * SIDE).map(at).sum::<f32>() / (SIDE * SIDE) as f32
    }
}

/// What a picture of all directions gives: averages of its luminance as [`super::EnvironmentMap`] shows it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PictureLight {
    /// The average over all directions.
    pub mean: f32,
    /// The greatest value.
    pub peak: f32,
    /// The irradiance on a surface that lies flat, with the top of the picture above it.
    pub irradiance: f32,
}

impl PictureLight {
    /// Reads every pixel once.
    pub fn new(image: &Image) -> Self {
        let rows = image.height().max(super::environment::LEAST_ROWS);
        let mut light = Self::default();
        let (mut sum, mut irradiance) = (0.0, 0.0);
        for row in 0..rows {
            let pixels = (0..image.width()).map(|column| {
                let pixel = image.pixel(column, row.min(image.height() - 1));
                luminance(super::environment::usable(pixel))
            });
            let (total, peak) = pixels.fold((0.0, 0.0f32), |(total, peak), value| {
                (total + f64::from(value), peak.max(value))
            });
            let mean = total / f64::from(image.width());
            light.peak = light.peak.max(peak);
            sum += mean * crate::photometry::solid_angle_of_row(row, rows);
            irradiance += mean * facing(row, rows);
        }
        light.mean = (0.5 * sum) as f32;
        light.irradiance = (TAU * irradiance) as f32;
        light
    }
}

/// The integral of the hat function of a row times the cosine from the top over its directions of the upper half,
/// divided by 2 pi.
fn facing(row: u32, rows: u32) -> f64 {
    const PARTS: u32 = 64;
    let step = PI / f64::from(rows - 1);
    let part = |index: u32| {
        let offset = (f64::from(index) + 0.5) / f64::from(PARTS) - 1.0;
        let theta = (f64::from(row) + offset) * step;
        let is_above = (0.0..0.5 * PI).contains(&theta);
        let hat = 1.0 - offset.abs();
        if is_above { hat * theta.sin() * theta.cos() } else { 0.0 }
    };
    (0..2 * PARTS).map(part).sum::<f64>() * step / f64::from(PARTS)
}
