//! The clear sky and the sun: the analytic model of Hosek and Wilkie.
//!
//! "An Analytic Model for Full Spectral Sky-Dome Radiance", SIGGRAPH 2012, in its Rec. 709 fit, and "Adding a Solar
//! Radiance Function to the Hosek Skylight Model", IEEE CG&A 33(3), 2013. The local frame has z up. Below the horizon,
//! and with the sun there, all is black.

use std::f32::consts::{FRAC_PI_2, TAU};
use std::sync::LazyLock;

use glam::Vec3;

use crate::color::Rgb;
use crate::math::{Mask, Real, Vector, asin_positive, exp};

/// The parameters of the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Atmosphere {
    /// Haziness, from 1 (arctic) to 10 (humid and warm).
    pub turbidity: f32,
    /// Reflectance of the ground, in [0, 1].
    pub albedo: Rgb,
    /// Unit vector to the sun, in the local frame.
    pub sun_direction: Vec3,
    /// The factor on the radiance of the sky, not negative.
    pub sky_scale: f32,
    /// The factor on the radiance of the sun, not negative.
    pub sun_scale: f32,
    /// The apparent diameter of the sun in radians, in (0, pi); its irradiance does not depend on it.
    pub sun_aperture: f32,
    /// Whether the sun is darker towards its rim.
    pub limb_darkening: bool,
}

const TURBIDITIES: usize = 10;
const CONTROL_POINTS: usize = 6;
const COEFFICIENTS: usize = 9;
/// The number of elevations at which the irradiance of the sun is tabulated, and the lowest of them in degrees.
const ELEVATIONS: usize = 30;
const FIRST_ELEVATION: f32 = 2.0;
const ELEVATION_STEP: f32 = 3.0;

/// Radiance of the sun's disk relative to its centre, per channel a polynomial in the cosine between the sun's surface
/// normal and the view: the limb darkening at Hosek and Wilkie's wavelengths, weighted by the response to a sun at 32
/// degrees.
const LIMB_DARKENING: [[f32; 6]; 3] = [
    [0.332_252, 1.356_991, -1.929_078, 2.568_054, -1.892_76, 0.564_551],
    [0.253_793, 1.329_39, -1.462_089, 1.688_674, -1.113_452, 0.303_686],
    [0.156_870, 1.245_044, -0.919_983, 0.956_002, -0.588_128, 0.150_177],
];

struct Tables {
    /// The coefficients by [channel][albedo][turbidity][control point][coefficient].
    shape: Vec<f32>,
    /// The radiance by [channel][albedo][turbidity][control point], in W/(m^2 sr).
    radiance: Vec<f32>,
    /// The sun's irradiance by [turbidity][elevation][channel], in W/m^2.
    sun: Vec<f32>,
}

static TABLES: LazyLock<Tables> = LazyLock::new(|| {
    let text = include_str!("../../../assets/sky/hosek-wilkie-rgb.txt");
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let mut numbers = lines
        .flat_map(str::split_whitespace)
        .filter_map(|word| word.parse().ok());
    let mut table = |length| numbers.by_ref().take(length).collect();
    let curves = 3 * 2 * TURBIDITIES * CONTROL_POINTS;
    Tables {
        shape: table(curves * COEFFICIENTS),
        radiance: table(curves),
        sun: table(TURBIDITIES * ELEVATIONS * 3),
    }
});

impl Atmosphere {
    /// The irradiance by the sun on a surface that faces it, in W/m^2; zero while it is below the horizon.
    pub fn sun_irradiance(&self) -> Rgb {
        SkyModel::new(*self).sun_irradiance()
    }
}

/// The model with all terms that do not depend on the direction precomputed.
#[derive(Clone, Debug)]
pub(super) struct SkyModel {
    atmosphere: Atmosphere,
    /// The coefficients, each for the three channels at once.
    shape: [Rgb; COEFFICIENTS],
    radiance: Rgb,
    /// Average radiance of the sun's disk.
    sun_radiance: Rgb,
}

impl SkyModel {
    pub fn new(atmosphere: Atmosphere) -> Self {
        let mut model = Self {
            atmosphere,
            shape: [Rgb::ZERO; COEFFICIENTS],
            radiance: Rgb::ZERO,
            sun_radiance: Rgb::ZERO,
        };
        let up = atmosphere.sun_direction.z;
        if up < 0.0 {
            return model;
        }
        let elevation = up.min(1.0).asin();
        for (index, coefficient) in model.shape.iter_mut().enumerate() {
            *coefficient = interpolate(&TABLES.shape, COEFFICIENTS, index, &atmosphere, elevation);
        }
        model.radiance = atmosphere.sky_scale * interpolate(&TABLES.radiance, 1, 0, &atmosphere, elevation);
        let solid_angle = TAU * one_minus_cos(0.5 * atmosphere.sun_aperture);
        let radiance = atmosphere.sun_scale * sun_irradiance(atmosphere.turbidity, elevation) / solid_angle;
        // The red sun at the horizon lies outside of Rec. 709.
        model.sun_radiance = radiance.max(Rgb::ZERO);
        model
    }

    /// 1 - cos of the angle from the sun's centre to its rim.
    pub fn sun_one_minus_cos(&self) -> f32 {
        one_minus_cos(0.5 * self.atmosphere.sun_aperture)
    }

    /// The irradiance on a surface that faces the sun, in W/m^2.
    pub fn sun_irradiance(&self) -> Rgb {
        self.sun_radiance * TAU * self.sun_one_minus_cos()
    }

    /// Radiance of the sky without the sun from a unit direction. Negative components, of colours outside Rec. 709,
    /// count as zero.
    #[inline(always)]
    pub fn sky<R: Real>(&self, direction: R::Vec3) -> R::Vec3 {
        let one = R::Vec3::even(R::ONE);
        let [a, b, c, d, e, f, g, h, i] = self.shape.map(R::Vec3::same);
        let up = direction.z().max(R::ZERO);
        let one_minus_cos: R = self.one_minus_cos_to_sun(direction);
        let (from_sun, cos) = (angle_to(one_minus_cos), R::ONE - one_minus_cos);
        let cos_squared = cos * cos;
        let horizon = one + a * (b / (up + R::splat(0.01))).map(exp);
        let spread = one + i * i - i * (cos + cos);
        // The exponent is 3 / 2.
        let mie = R::Vec3::even(R::ONE + cos_squared) / (spread * spread.map(R::sqrt));
        let glow = c + d * (e * from_sun).map(exp) + f * cos_squared + g * mie + h * up.sqrt();
        let radiance = horizon * glow * R::Vec3::same(self.radiance);
        radiance.map(|x| x.max(R::ZERO)).only(!direction.z().is_less(R::ZERO))
    }

    /// Radiance of the sun from a unit direction; zero beside it.
    #[inline(always)]
    pub fn sun<R: Real>(&self, direction: R::Vec3) -> R::Vec3 {
        let (rim, here) = (self.sun_one_minus_cos(), self.one_minus_cos_to_sun::<R>(direction));
        let is_there = !(direction.z().is_less(R::ZERO) | R::is_above(here, rim));
        let whole = R::Vec3::same(self.sun_radiance).only(is_there);
        if !self.atmosphere.limb_darkening || !is_there.any() {
            return whole;
        }
        // The disk is a distant sphere: the sine of the angle from its centre is proportional to the sine on the sun's
        // surface.
        let sine_squared = here * (R::splat(2.0) - here);
        let cos = (R::ONE - sine_squared / R::splat(rim * (2.0 - rim)))
            .max(R::ZERO)
            .sqrt();
        let [red, green, blue] = LIMB_DARKENING.map(|polynomial| {
            let value =
                (polynomial.iter().rev()).fold(R::ZERO, |sum, &coefficient| sum.mul_add(cos, R::splat(coefficient)));
            // The mean over the disk of the n-th power of the cosine is 2 / (n + 2).
            let powers = polynomial.iter().zip(2..);
            let mean: f32 = powers.map(|(coefficient, n)| 2.0 * coefficient / n as f32).sum();
            value / R::splat(mean)
        });
        whole * R::Vec3::of(red, green, blue)
    }

    /// 1 - cos of the angle to the sun. It is exact for small angles, unlike the dot product.
    #[inline(always)]
    fn one_minus_cos_to_sun<R: Real>(&self, direction: R::Vec3) -> R {
        R::HALF * (direction - R::Vec3::same(self.atmosphere.sun_direction)).length_squared()
    }
}

fn one_minus_cos(angle: f32) -> f32 {
    2.0 * (0.5 * angle).sin().powi(2)
}

#[inline(always)]
fn angle_to<R: Real>(one_minus_cos: R) -> R {
    let half = asin_positive((R::HALF * one_minus_cos).min(R::ONE).sqrt());
    half + half
}

/// The two neighbours of a position among `count` entries and the share of the second.
fn neighbours(position: f32, count: usize) -> (usize, usize, f32) {
    let position = position.clamp(0.0, (count - 1) as f32);
    let first = (position as usize).min(count - 2);
    (first, first + 1, position - first as f32)
}

/// Interpolates the entry `index` of `length` per control point: linear in turbidity and albedo, a quintic Bezier curve
/// in the cube root of the elevation.
fn interpolate(table: &[f32], length: usize, index: usize, atmosphere: &Atmosphere, elevation: f32) -> Rgb {
    let (low, high, hazier) = neighbours(atmosphere.turbidity - 1.0, TURBIDITIES);
    let t = (elevation / FRAC_PI_2).clamp(0.0, 1.0).cbrt();
    let bernstein = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];
    let curve = |channel: usize, albedo: usize, turbidity: usize| -> f32 {
        let first = ((channel * 2 + albedo) * TURBIDITIES + turbidity) * CONTROL_POINTS;
        let term = |k: usize| bernstein[k] * t.powi(k as i32) * (1.0 - t).powi(5 - k as i32);
        (0..CONTROL_POINTS)
            .map(|k| term(k) * table[(first + k) * length + index])
            .sum()
    };
    let channel = |channel: usize| {
        let at = |albedo| curve(channel, albedo, low) * (1.0 - hazier) + curve(channel, albedo, high) * hazier;
        let reflected = atmosphere.albedo[channel];
        at(0) * (1.0 - reflected) + at(1) * reflected
    };
    Rgb::new(channel(0), channel(1), channel(2))
}

fn sun_irradiance(turbidity: f32, elevation: f32) -> Rgb {
    let (low, high, hazier) = neighbours(turbidity - 1.0, TURBIDITIES);
    let (below, above, higher) = neighbours((elevation.to_degrees() - FIRST_ELEVATION) / ELEVATION_STEP, ELEVATIONS);
    let at =
        |turbidity: usize, elevation: usize| Rgb::from_slice(&TABLES.sun[(turbidity * ELEVATIONS + elevation) * 3..]);
    let of = |turbidity| at(turbidity, below).lerp(at(turbidity, above), higher);
    of(low).lerp(of(high), hazier)
}
