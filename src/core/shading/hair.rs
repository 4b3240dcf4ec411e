//! A hair or a strand of fur: a rough dielectric cylinder that absorbs light inside.
//!
//! Chiang, Bitterli, Tappan and Burley, A Practical and Controllable Hair and Fur Model for Production Path Tracing,
//! 2016, with the longitudinal function of d'Eon et al., An Energy-Conserving Hair Reflectance Model, 2011, and the
//! conventions of Mitsuba 3 and of Pharr, The Implementation of a Hair Scattering Model, 2016.
//!
//! The fibre runs along y. One evaluation covers the whole path of light through the fibre: p = 0 is reflected (R), p =
//! 1 crosses it (TT), p = 2 is reflected once inside (TRT), the last lobe is all light that is reflected more often.
//! Each lobe is the product of the attenuation A_p, a function of the inclinations to the cross-section, M_p, and one
//! of the azimuths around the fibre, N_p. f |cos wi| = sum A_p M_p N_p, and M_p N_p is a density of directions, so that
//! a lobe is chosen by its luminance and then sampled exactly.
//!
//! The offset of the hit from the fibre's axis follows from the direction to the viewer in the frame of the surface,
//! not from texture coordinates: h is the sine of the azimuth of `wo` about the normal. So the surface must have a
//! round cross-section, as cylinders have. From behind, that is from within the fibre, light passes straight through
//! the surface: light that leaves on the far side was scattered when it came in.
//!
//! The model is not reciprocal, because A_p and the tilt of the scales depend on `wo` alone. Importance is scattered as
//! radiance is.

use std::f32::consts::{FRAC_PI_8, PI, TAU};

use glam::{Vec2, Vec3};

use super::fresnel::{self, DielectricModel};
use super::{BsdfSample, Model, ShadingTables, TransportMode};
use crate::color::{Rgb, luminance};
use crate::math::scaled_bessel_i0;

const LOBES: usize = 4;

/// The longitudinal variances of the lobes, over that of the first.
const VARIANCES: [f32; LOBES] = [1.0, 0.25, 4.0, 4.0];

/// A smaller roughness is raised to this, where lobes are some tenths of a degree wide.
const LEAST_ROUGHNESS: f32 = 0.01;

/// A fibre's shape and surface, without its colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fiber {
    /// Refractive index inside over outside, above 0.
    eta: f32,
    /// The variance of the inclinations of mirrored light.
    variance: f32,
    /// The scale of the logistic distribution of azimuths.
    azimuthal_scale: f32,
    /// Sine and cosine of the angle by which the scales turn each lobe along the fibre.
    tilts: [Vec2; LOBES],
    /// Minus the logarithm of the albedo of many fibres, over the root of the absorption.
    darkening: f32,
}

/// A fibre with its colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hair {
    /// The fibre's shape and surface.
    pub fiber: Fiber,
    /// The absorption coefficient inside, per radius of the fibre, at least 0.
    pub sigma_a: Rgb,
}

/// The absorption coefficient, per radius, of these concentrations of the pigments in human hair (d'Eon et al. 2011):
/// 0.3 of eumelanin is blond, 1.3 brown, 8 black; pheomelanin makes hair red.
pub fn melanin_absorption(eumelanin: f32, pheomelanin: f32) -> Rgb {
    eumelanin * Rgb::new(0.419, 0.697, 1.37) + pheomelanin * Rgb::new(0.187, 0.4, 1.05)
}

impl Fiber {
    /// The roughnesses along the fibre and around it are in [0, 1], and roughly linear to the eye. `scale_tilt` is the
    /// angle of the scales on the surface, in radians; above 0, it turns mirrored light by twice as much towards +y.
    pub fn new(eta: f32, longitudinal_roughness: f32, azimuthal_roughness: f32, scale_tilt: f32) -> Self {
        let [along, around] =
            [longitudinal_roughness, azimuthal_roughness].map(|beta| beta.clamp(LEAST_ROUGHNESS, 1.0));
        // These are the fits of the paper.
        let width = 0.726 * along + 0.812 * along.powi(2) + 3.7 * along.powi(20);
        let spread = 0.265 * around + 1.194 * around.powi(2) + 5.372 * around.powi(22);
        let darkening = [0.245, 5.574, -10.73, 2.532, -0.215, 5.969];
        Self {
            eta,
            variance: width * width,
            azimuthal_scale: FRAC_PI_8.sqrt() * spread,
            tilts: [-2.0, 1.0, 4.0, 0.0].map(|times| Vec2::from(f32::sin_cos(times * scale_tilt))),
            darkening: darkening.into_iter().fold(0.0, |sum, c| sum * around + c),
        }
    }
}

/// One lobe as seen by a viewer.
struct Lobe {
    /// The attenuation A_p: the share of the light that leaves in this lobe.
    attenuation: Rgb,
    /// Sine and cosine of the viewer's inclination, turned by the scales.
    inclination: Vec2,
    variance: f32,
    /// The azimuth of the lobe's centre about the normal, and its scale; None if azimuths are uniform.
    azimuth: Option<(f32, f32)>,
}

/// The azimuth about the normal, seen along the fibre.
fn azimuth(v: Vec3) -> f32 {
    (-v.x).atan2(v.z)
}

/// Sine and cosine of the angle to the cross-section.
fn inclination(v: Vec3) -> Vec2 {
    Vec2::new(v.y, v.x.hypot(v.z))
}

impl Lobe {
    /// The longitudinal function M_p: the density of inclinations, per unit of their sine.
    fn longitudinal(&self, wi: Vec3) -> f32 {
        let v = self.variance;
        let (o, i) = (self.inclination, inclination(wi));
        // This is d'Eon's csch(1 / v) / (2 v) exp(-sin sin / v) I0(cos cos / v), in which large factors cancel.
        let distance_squared = (o.x + i.x).powi(2) + (o.y - i.y).powi(2);
        let peak = scaled_bessel_i0(o.y * i.y / v) / (-v * (-2.0 / v).exp_m1());
        peak * (-0.5 * distance_squared / v).exp()
    }

    /// The azimuthal function N_p: the density of azimuths, per radian.
    fn azimuthal(&self, wi: Vec3) -> f32 {
        let Some((middle, scale)) = self.azimuth else {
            return TAU.recip();
        };
        let off = azimuth(wi) - middle;
        let off = off - TAU * (off / TAU).round();
        let falloff = (-off.abs() / scale).exp();
        falloff / (scale * (1.0 + falloff).powi(2) * inside(scale))
    }

    /// A direction with the density M_p N_p.
    fn sample(&self, u_azimuth: f32, u: Vec2) -> Vec3 {
        let v = self.variance;
        // The distribution is centred on the mirror image of the viewer, as in d'Eon, Marschner and Hanika, A Fiber
        // Scattering Model with Non-Separable Lobes, 2014.
        let depth = -v * (u.x * (-2.0 / v).exp_m1()).ln_1p();
        let (cos, sin) = (1.0 - depth, (depth * (2.0 - depth)).max(0.0).sqrt());
        let (sin_around, cos_around) = (TAU * u.y).sin_cos();
        let Vec2 { x: sin_o, y: cos_o } = self.inclination;
        let along = sin * cos_around * cos_o - cos * sin_o;
        let across = (sin * cos_around * sin_o + cos * cos_o).hypot(sin * sin_around);
        let azimuth = match self.azimuth {
            Some((middle, scale)) => middle + sample_trimmed_logistic(scale, u_azimuth),
            None => TAU * u_azimuth,
        };
        let (sin_azimuth, cos_azimuth) = azimuth.sin_cos();
        Vec3::new(-across * sin_azimuth, along, across * cos_azimuth).normalize()
    }
}

/// The share of the logistic distribution in [-pi, pi].
fn inside(scale: f32) -> f32 {
    (0.5 * PI / scale).tanh()
}

/// Samples the logistic distribution, cut off at -pi and pi.
fn sample_trimmed_logistic(scale: f32, u: f32) -> f32 {
    let inside = inside(scale);
    let below = 0.5 * (1.0 - inside) + u * inside;
    (scale * (below / (1.0 - below)).ln()).clamp(-PI, PI)
}

impl Hair {
    fn lobes(&self, wo: Vec3) -> [Lobe; LOBES] {
        let fiber = &self.fiber;
        let attenuations = self.attenuations(wo);
        let Vec2 { x: sin, y: cos } = inclination(wo);
        // In the cross-section light is refracted as if by the index sqrt(eta^2 - sin^2) / cos (Marschner et al. 2003).
        let index_squared = (fiber.eta.powi(2) - sin * sin).max(f32::MIN_POSITIVE);
        let refracted = (-wo.x / index_squared.sqrt()).clamp(-1.0, 1.0).asin();
        std::array::from_fn(|p| {
            let tilt = fiber.tilts[p];
            let tilted = Vec2::new(sin * tilt.y + cos * tilt.x, (cos * tilt.y - sin * tilt.x).abs());
            let middle = p as f32 * (PI + 2.0 * refracted) - azimuth(wo);
            Lobe {
                attenuation: attenuations[p],
                inclination: tilted,
                variance: VARIANCES[p] * fiber.variance,
                azimuth: (p + 1 < LOBES).then_some((middle, fiber.azimuthal_scale)),
            }
        })
    }

    /// The attenuations A_p, by reflection and absorption along the path.
    fn attenuations(&self, wo: Vec3) -> [Rgb; LOBES] {
        let eta_squared = self.fiber.eta.powi(2);
        let reflected = fresnel::dielectric(wo.z, self.fiber.eta, DielectricModel::Exact).reflectance;
        // The length of one crossing of the fibre, in radii, is 2 cos gamma_t / cos theta_t.
        let index_squared = (eta_squared - wo.y * wo.y).max(f32::MIN_POSITIVE);
        let length = 2.0 * self.fiber.eta * (index_squared - wo.x * wo.x).max(0.0).sqrt() / index_squared;
        let transmittance = (-length * self.sigma_a).exp();
        let again = reflected * transmittance;
        let crossed = (1.0 - reflected).powi(2) * transmittance;
        // Under total reflection no light is inside to be reflected again.
        let rest = crossed * again * again / (Rgb::ONE - again).max(Rgb::splat(f32::EPSILON));
        [Rgb::splat(reflected), crossed, crossed * again, rest]
    }

    /// The share of the light that passes straight through to `wo`.
    pub(super) fn transmittance(&self, wo: Vec3) -> Rgb {
        if wo.z < 0.0 { Rgb::ONE } else { Rgb::ZERO }
    }

    /// The colour of many such fibres (section 4.2 of the paper).
    pub(super) fn albedo(&self) -> Rgb {
        self.sigma_a
            .map(|sigma_a| (-self.fiber.darkening * sigma_a.sqrt()).exp())
    }
}

impl Model<f32> for Hair {
    fn eval_and_pdf(&self, _: &ShadingTables, wo: Vec3, wi: Vec3, _: TransportMode) -> (Rgb, f32) {
        if wo.z < 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        value_and_density(&self.lobes(wo), wi)
    }

    fn sample(&self, _: &ShadingTables, wo: Vec3, u_lobe: f32, u: [f32; 2], _: TransportMode) -> BsdfSample {
        if wo.z < 0.0 {
            return BsdfSample {
                wi: -wo,
                weight: Rgb::ONE,
                pdf: 1.0,
                is_delta: true,
                eta: 1.0,
                is_returned: true,
            };
        }
        let lobes = self.lobes(wo);
        // The rest of the number, within the share of the chosen lobe, is uniform again.
        let mut left = u_lobe * total(&lobes);
        let mut chosen = 0;
        let mut share = luminance(lobes[0].attenuation);
        while left >= share && chosen + 1 < LOBES {
            left -= share;
            chosen += 1;
            share = luminance(lobes[chosen].attenuation);
        }
        let u_azimuth = (left / share.max(f32::MIN_POSITIVE)).clamp(0.0, 1.0 - f32::EPSILON);
        let wi = lobes[chosen].sample(u_azimuth, Vec2::from(u));
        let (value, pdf) = value_and_density(&lobes, wi);
        BsdfSample {
            wi,
            weight: value / pdf,
            pdf,
            is_delta: false,
            eta: 1.0,
            is_returned: pdf > 0.0,
        }
    }
}

/// The luminance of all light that leaves.
fn total(lobes: &[Lobe; LOBES]) -> f32 {
    lobes.iter().map(|lobe| luminance(lobe.attenuation)).sum()
}

fn value_and_density(lobes: &[Lobe; LOBES], wi: Vec3) -> (Rgb, f32) {
    let value: Rgb = lobes
        .iter()
        .map(|lobe| lobe.attenuation * (lobe.longitudinal(wi) * lobe.azimuthal(wi)))
        .sum();
    // Lobes are chosen by luminance, so the density is in proportion to the value's luminance.
    let total = total(lobes);
    (value, if total > 0.0 { luminance(value) / total } else { 0.0 })
}
