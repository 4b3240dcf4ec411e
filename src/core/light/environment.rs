//! An image of all directions, infinitely far away.
//!
//! The mapping is Mitsuba 3's (since 3.9), by latitude and longitude: +y is up, the top row of the image is the pole,
//! the bottom row its opposite; columns have their centres half a column inside, the middle of the image is at +z, and
//! the columns continue towards -x. Between pixels radiance is bilinear, and directions are sampled by the bilinear
//! interpolation of luminance times the solid angle of its pixel, which is nowhere zero where radiance is not.

use std::f32::consts::{FRAC_1_PI, PI, TAU};
use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3};

use super::{LightSample, Target};
use crate::color::{Rgb, luminance};
use crate::math::{Real, Vector, sin_cos};
use crate::sampling::{PiecewiseBilinear2d, SquareSample};
use crate::texture::Image;

/// An image of all directions with its sampling density, which depends on neither rotation nor scale.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    image: Arc<Image>,
    /// The density by columns (from the first pixel's centre once around) and rows; None for a black picture.
    density: Option<PiecewiseBilinear2d>,
    /// Average luminance over the sphere.
    mean: f32,
}

/// The least number of rows. A picture with fewer gets more by repeating the last one, as in Mitsuba 3.
pub(super) const LEAST_ROWS: u32 = 3;

/// The share of the density that is kept where compensation would leave zero, so that the estimator stays unbiased
/// where no other technique samples.
const COMPENSATION_FLOOR: f32 = 0.05;

/// The least sine of theta. Closer to the poles, the density per solid angle, which is infinite there, stays constant.
const LEAST_SINE: f32 = 1e-7;

impl EnvironmentMap {
    /// Prepares an environment. Negative and NaN pixels count as black. `compensated` sharpens the density by
    /// subtracting the mean: directions that BSDF sampling finds well need not be sampled twice (Karlik et al., MIS
    /// Compensation, SIGGRAPH Asia 2019).
    pub fn new(image: Arc<Image>, compensated: bool) -> Self {
        let (width, height) = (image.width(), image.height());
        let rows = height.max(LEAST_ROWS);
        let step = PI / (rows - 1) as f32;
        // The average of the sine over the hat function around the row: positive at the poles, too.
        let sine = |row: u32| match row {
            _ if row == 0 || row == rows - 1 => 2.0 * (1.0 - step.sin() / step) / step,
            _ => (row as f32 * step).sin() * (2.0 * (0.5 * step).sin() / step).powi(2),
        };
        let pixel = |column: u32, row: u32| luminance(usable(image.pixel(column % width, row.min(height - 1))));
        let (mut sum, mut weights) = (0.0f64, 0.0f64);
        let mut values = Vec::with_capacity((width as usize + 1) * rows as usize);
        for row in 0..rows {
            let weight = f64::from(sine(row)) * if row == 0 || row == rows - 1 { 0.5 } else { 1.0 };
            let start = values.len();
            values.extend((0..=width).map(|column| pixel(column, row)));
            sum += weight
                * values[start..start + width as usize]
                    .iter()
                    .map(|&value| f64::from(value))
                    .sum::<f64>();
            weights += weight * f64::from(width);
        }
        let mean = (sum / weights) as f32;
        for (row, values) in values.chunks_exact_mut(width as usize + 1).enumerate() {
            let sine = sine(row as u32);
            for value in values {
                let sharpened = if compensated {
                    (*value - mean).max(COMPENSATION_FLOOR * *value)
                } else {
                    *value
                };
                *value = sharpened * sine;
            }
        }
        Self {
            density: PiecewiseBilinear2d::new(width as usize + 1, rows as usize, &values),
            image,
            mean,
        }
    }

    /// The number of columns.
    pub(super) fn width(&self) -> u32 {
        self.image.width()
    }

    /// The number of rows; the first is at one pole, the last at the other.
    pub(super) fn rows(&self) -> u32 {
        self.image.height().max(LEAST_ROWS)
    }

    /// The greatest luminance, and the number of black rows at the top.
    pub(super) fn peak_and_dark_rows(&self) -> (f32, u32) {
        let brightest = |row: u32| {
            let pixels = (0..self.width()).map(|column| luminance(usable(self.image.pixel(column, row))));
            pixels.fold(0.0, f32::max)
        };
        let rows = (0..self.image.height()).map(brightest);
        let dark = rows.clone().take_while(|brightest| *brightest == 0.0).count();
        (rows.fold(0.0, f32::max), dark as u32)
    }

    /// The average luminance over all directions.
    pub fn mean_luminance(&self) -> f32 {
        self.mean
    }

    /// Radiance from the direction with these coordinates of [`uv`].
    fn radiance(&self, uv: Vec2) -> Rgb {
        let (width, height) = (self.image.width(), self.image.height());
        let x = uv.x * width as f32 - 0.5;
        let y = uv.y * (height.max(LEAST_ROWS) - 1) as f32;
        let (column, row) = (x.floor(), (y as u32).min(height - 1));
        let (s, t) = (x - column, y - row as f32);
        let column = column.rem_euclid(width as f32) as u32 % width;
        let beside = (column + 1) % width;
        let below = (row + 1).min(height - 1);
        let pixel = |column, row| usable(self.image.pixel(column, row));
        let upper = pixel(column, row).lerp(pixel(beside, row), s);
        let lower = pixel(column, below).lerp(pixel(beside, below), s);
        upper.lerp(lower, t.min(1.0))
    }
}

/// Two lights with the same image are the same, without comparing pixels.
impl PartialEq for EnvironmentMap {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

/// An [`EnvironmentMap`] in the world.
#[derive(Clone, Debug)]
pub(super) struct EnvironmentLight {
    pub map: Arc<EnvironmentMap>,
    /// The orthonormal map from local space; it may mirror.
    pub world_from_local: Mat3,
    pub scale: f32,
}

impl EnvironmentLight {
    /// Samples a direction where `asked` is set; the density is zero if the image is black.
    #[inline(always)]
    pub fn sample<R: Real>(&self, asked: R::Mask, u: [R; 2]) -> LightSample<R> {
        let (mut uv, mut pdf) = ([R::ZERO; 2], R::ZERO);
        if let Some(density) = &self.map.density {
            let SquareSample {
                position: [x, y],
                pdf: of_picture,
            } = density.sample(u);
            uv = [x + R::splat(0.5 / self.map.image.width() as f32), y];
            pdf = of_picture.only(asked);
        }
        let radiance = |uv: [f32; 2]| (self.scale * self.map.radiance(uv.into())).to_array();
        let [red, green, blue] = R::each(asked, uv, radiance);
        let (sin_phi, cos_phi) = sin_cos(R::splat(TAU) * uv[0]);
        let (sin_theta, cos_theta) = sin_cos(R::splat(PI) * uv[1]);
        let local = R::Vec3::of(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta);
        let Mat3 { x_axis, y_axis, z_axis } = self.world_from_local;
        LightSample {
            wi: local.along([x_axis, y_axis, z_axis]),
            target: Target::Infinity,
            radiance: R::Vec3::of(red, green, blue),
            pdf: pdf * uv_density(sin_theta),
            is_delta: false,
        }
    }

    pub fn radiance(&self, wi: Vec3) -> Rgb {
        self.scale * self.map.radiance(uv(self.world_from_local.transpose() * wi))
    }

    /// The radiance as [`Self::radiance`], and the density per solid angle of [`Self::sample`].
    pub fn radiance_and_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        let local = self.world_from_local.transpose() * wi;
        let uv = uv(local);
        let x = uv.x - 0.5 / self.map.image.width() as f32;
        let sin_theta = local.x.hypot(local.z);
        let density = self.map.density.as_ref();
        let pdf = density.map_or(0.0, |density| {
            density.pdf([x - x.floor(), uv.y]) * uv_density(sin_theta)
        });
        (self.scale * self.map.radiance(uv), pdf)
    }

    /// The average luminance over all directions.
    pub fn mean_luminance(&self) -> f32 {
        self.scale * self.map.mean
    }
}

/// The longitude and latitude of a unit vector as fractions of the image's size.
fn uv(local: Vec3) -> Vec2 {
    let turn = local.x.atan2(-local.z) / TAU;
    // The arc cosine loses all digits near the poles.
    let theta = local.x.hypot(local.z).atan2(local.y);
    Vec2::new(turn - turn.floor(), (theta * FRAC_1_PI).min(1.0))
}

/// The density per solid angle of a density of 1 over the image.
fn uv_density<R: Real>(sin_theta: R) -> R {
    R::ONE / (R::splat(TAU * PI) * sin_theta.abs().max(R::splat(LEAST_SINE)))
}

pub(super) fn usable(radiance: Rgb) -> Rgb {
    let channel = |value: f32| if value.is_finite() { value.max(0.0) } else { 0.0 };
    Rgb::new(channel(radiance.x), channel(radiance.y), channel(radiance.z))
}
