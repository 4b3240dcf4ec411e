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
use crate::math::{Real, Vector, atan2, sin_cos};
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
        let (uv, pdf) = self.sample_uv(asked, u);
        let radiance = |uv: [f32; 2]| (self.scale * self.map.radiance(uv.into())).to_array();
        let [red, green, blue] = R::each(asked, uv, radiance);
        let (wi, sin_theta) = self.towards(uv);
        LightSample {
            wi,
            target: Target::Infinity,
            radiance: R::Vec3::of(red, green, blue),
            pdf: pdf * uv_density(sin_theta),
            is_delta: false,
        }
    }

    /// The directions of [`Self::sample`]; undefined where their density is zero.
    #[inline(always)]
    pub fn direction<R: Real>(&self, asked: R::Mask, u: [R; 2]) -> R::Vec3 {
        self.towards(self.sample_uv(asked, u).0).0
    }

    /// Samples places of the picture where `asked` is set, with their densities there.
    #[inline(always)]
    fn sample_uv<R: Real>(&self, asked: R::Mask, u: [R; 2]) -> ([R; 2], R) {
        let Some(density) = &self.map.density else {
            return ([R::ZERO; 2], R::ZERO);
        };
        let SquareSample {
            position: [x, y],
            pdf: of_picture,
        } = density.sample(u);
        let half_pixel = R::splat(0.5 / self.map.image.width() as f32);
        ([x + half_pixel, y], of_picture.only(asked))
    }

    /// The direction of a place of the picture, and the sine of its angle from the pole.
    #[inline(always)]
    fn towards<R: Real>(&self, uv: [R; 2]) -> (R::Vec3, R) {
        let (sin_phi, cos_phi) = sin_cos(R::splat(TAU) * uv[0]);
        let (sin_theta, cos_theta) = sin_cos(R::splat(PI) * uv[1]);
        let local = R::Vec3::of(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta);
        let Mat3 { x_axis, y_axis, z_axis } = self.world_from_local;
        (local.along([x_axis, y_axis, z_axis]), sin_theta)
    }

    pub fn radiance(&self, wi: Vec3) -> Rgb {
        let [x, y] = uv::<f32>(self.world_from_local.transpose() * wi).place;
        self.scale * self.map.radiance(Vec2::new(x, y))
    }

    /// The radiance as [`Self::radiance`] where `asked` is set, and the density per solid angle of [`Self::sample`].
    #[inline(always)]
    pub fn radiance_and_pdf<R: Real>(&self, asked: R::Mask, wi: R::Vec3) -> (R::Vec3, R) {
        let Mat3 { x_axis, y_axis, z_axis } = self.world_from_local;
        let uv = uv::<R>(wi.coordinates([x_axis, y_axis, z_axis]));
        let [x, y] = uv.place;
        let moved = x - R::splat(0.5 / self.map.image.width() as f32);
        let mut pdf = R::ZERO;
        if let Some(density) = &self.map.density {
            pdf = (density.pdf([moved - moved.floor(), y]) * uv_density(uv.sin_theta)).only(asked);
        }
        let radiance = |uv: [f32; 2]| (self.scale * self.map.radiance(uv.into())).to_array();
        let [red, green, blue] = R::each(asked, uv.place, radiance);
        (R::Vec3::of(red, green, blue), pdf)
    }

    /// The average luminance over all directions.
    pub fn mean_luminance(&self) -> f32 {
        self.scale * self.map.mean
    }
}

/// A direction in the picture.
struct Uv<R> {
    /// Longitude and latitude as fractions of the image's size.
    place: [R; 2],
    /// The sine of the angle from the pole.
    sin_theta: R,
}

/// The place of a unit vector in the picture.
#[inline(always)]
fn uv<R: Real>(local: R::Vec3) -> Uv<R> {
    let turn = atan2(local.x(), -local.z()) * R::splat(1.0 / TAU);
    let sin_theta = local.x().mul_add(local.x(), local.z().squared()).sqrt();
    // The arc cosine loses all digits near the poles.
    let theta = atan2(sin_theta, local.y());
    Uv {
        place: [turn - turn.floor(), (theta * R::splat(FRAC_1_PI)).min(R::ONE)],
        sin_theta,
    }
}

/// The density per solid angle of a density of 1 over the image.
fn uv_density<R: Real>(sin_theta: R) -> R {
    R::ONE / (R::splat(TAU * PI) * sin_theta.abs().max(R::splat(LEAST_SINE)))
}

pub(super) fn usable(radiance: Rgb) -> Rgb {
    let channel = |value: f32| if value.is_finite() { value.max(0.0) } else { 0.0 };
    Rgb::new(channel(radiance.x), channel(radiance.y), channel(radiance.z))
}
