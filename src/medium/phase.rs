//! Phase functions: the directions into which media scatter light (PBR 4th ed., section 11.3). Those here depend only on the angle between
//! the old and the new direction, and are sampled exactly, so that the density of a sample is the value of the function.

use std::f32::consts::{FRAC_1_PI, TAU};
use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::{TabulatedPhase, Volume};
use crate::math::Frame;

/// The value of the isotropic function.
pub(super) const UNIFORM: f32 = 0.25 * FRAC_1_PI;

/// A distribution of scattered directions.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// All directions alike.
    Isotropic,
    /// The function of Henyey and Greenstein (1941).
    HenyeyGreenstein {
        /// The mean cosine, in (-1, 1): above 0 light goes on forwards.
        g: f32,
    },
    /// Scattering by particles that are much smaller than the wavelength.
    Rayleigh,
    /// A table over the cosine.
    Tabulated(Arc<TabulatedPhase>),
    /// A mixture of two.
    Blend(Box<BlendedPhase>),
}

/// Two phase functions of which each has a share that depends on the place.
#[derive(Clone, Debug, PartialEq)]
pub struct BlendedPhase {
    /// The share of the second one, in [0, 1]; the first component counts.
    pub weight: Volume,
    /// The functions.
    pub of: [Phase; 2],
}

impl Phase {
    /// The density per solid angle at the place `at` with which light that goes in direction `dir` is scattered to `wi`, both unit vectors in the
    /// direction in which the path goes. The integral over all `wi` is 1.
    pub fn pdf(&self, at: Vec3, dir: Vec3, wi: Vec3) -> f32 {
        let cosine = dir.dot(wi).clamp(-1.0, 1.0);
        match self {
            Self::Isotropic => UNIFORM,
            Self::HenyeyGreenstein { g } => henyey_greenstein(*g, cosine),
            Self::Rayleigh => 0.75 * UNIFORM * (1.0 + cosine * cosine),
            Self::Tabulated(table) => table.pdf(cosine),
            Self::Blend(blend) => {
                let [first, second] = blend.of.each_ref().map(|phase| phase.pdf(at, dir, wi));
                first + blend.share_of_second(at) * (second - first)
            }
        }
    }

    /// A direction with the density of [`Self::pdf`], and that density.
    pub fn sample(&self, at: Vec3, dir: Vec3, u_choice: f32, u: Vec2) -> (Vec3, f32) {
        let cosine = match self {
            Self::Isotropic => 2.0 * u.x - 1.0,
            Self::HenyeyGreenstein { g } => sample_henyey_greenstein(*g, u.x),
            Self::Rayleigh => sample_rayleigh(u.x),
            Self::Tabulated(table) => table.sample(u.x),
            Self::Blend(blend) => {
                let share = blend.share_of_second(at);
                let (phase, u_choice) = match u_choice < share {
                    true => (&blend.of[1], u_choice / share),
                    false => (&blend.of[0], (u_choice - share) / (1.0 - share)),
                };
                let (wi, _) = phase.sample(at, dir, u_choice, u);
                return (wi, self.pdf(at, dir, wi));
            }
        };
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
        let local = Vec3::new(sine * cos_phi, sine * sin_phi, cosine);
        let wi = Frame::from_normal(dir).to_world(local).normalize();
        (wi, self.pdf(at, dir, wi))
    }
}

impl BlendedPhase {
    fn share_of_second(&self, at: Vec3) -> f32 {
        self.weight.at(at).x.clamp(0.0, 1.0)
    }
}

/// Below this a mean cosine counts as zero, where the sampling formula divides by it.
pub(super) const NEARLY_ISOTROPIC: f32 = 1e-3;

fn henyey_greenstein(g: f32, cosine: f32) -> f32 {
    let squared = 1.0 + g * g - 2.0 * g * cosine;
    UNIFORM * (1.0 - g * g) / (squared * squared.max(0.0).sqrt())
}

/// The cosine by inversion (PBR 4th ed., equation 11.20, with the sign of forward scattering).
fn sample_henyey_greenstein(g: f32, u: f32) -> f32 {
    if g.abs() < NEARLY_ISOTROPIC {
        // To the first order in g.
        let even = 2.0 * u - 1.0;
        return (even + 1.5 * g * (1.0 - even * even)).clamp(-1.0, 1.0);
    }
    let ratio = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
    ((1.0 + g * g - ratio * ratio) / (2.0 * g)).clamp(-1.0, 1.0)
}

/// The real root of the cubic equation of inversion (Frisvad, Importance sampling the Rayleigh phase function, JOSA A 28(12), 2011).
fn sample_rayleigh(u: f32) -> f32 {
    let half = 2.0 * (2.0 * u - 1.0);
    let root = (half + (half * half + 1.0).sqrt()).cbrt();
    (root - 1.0 / root).clamp(-1.0, 1.0)
}
