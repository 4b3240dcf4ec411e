//! Phase functions: the directions into which media scatter light (PBR 4th ed., section 11.3). They depend only on the
//! angle between the old and the new direction, and are sampled exactly, so that the density of a sample equals the
//! value of the function.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::{TabulatedPhase, Volume};
use crate::math::{Frame, Mask, Real, cube_root, real_struct};
use crate::sampling::warp::{self, UNIFORM_SPHERE_PDF};

/// A distribution of scattered directions.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// Uniform over all directions.
    Isotropic,
    /// The function of Henyey and Greenstein (1941).
    HenyeyGreenstein {
        /// The mean cosine, in (-1, 1): above 0 light is scattered forwards.
        g: f32,
    },
    /// Scattering by particles that are much smaller than the wavelength.
    Rayleigh,
    /// A table over the cosine.
    Tabulated(Arc<TabulatedPhase>),
    /// A mixture of two.
    Blend(Box<BlendedPhase>),
}

/// Two phase functions mixed with weights that vary in space.
#[derive(Clone, Debug, PartialEq)]
pub struct BlendedPhase {
    /// The weight of the second one, in [0, 1]; only the volume's first component is used.
    pub weight: Volume,
    /// The mixed functions.
    pub of: [Phase; 2],
}

impl Phase {
    /// The density per solid angle with which light is scattered at the point `at` from direction `dir` to `wi`, both
    /// unit vectors along the path. The integral over all `wi` is 1.
    pub fn pdf(&self, at: Vec3, dir: Vec3, wi: Vec3) -> f32 {
        let cosine = dir.dot(wi).clamp(-1.0, 1.0);
        match self {
            Self::Isotropic => UNIFORM_SPHERE_PDF,
            Self::HenyeyGreenstein { g } => henyey_greenstein(*g, cosine),
            Self::Rayleigh => rayleigh(cosine),
            Self::Tabulated(table) => table.pdf(cosine),
            Self::Blend(blend) => {
                let [first, second] = blend.of.each_ref().map(|phase| phase.pdf(at, dir, wi));
                first + blend.share_of_second(at) * (second - first)
            }
        }
    }

    /// Samples a direction, and returns it with its density [`Self::pdf`].
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
        let local = warp::at_height([u.y, cosine]);
        let wi = Frame::from_normal(dir).to_world(local).normalize();
        (wi, self.pdf(at, dir, wi))
    }

    /// The function as a formula; None for tables and mixtures.
    pub(super) fn plain(&self) -> Option<PlainPhase> {
        match *self {
            Self::Isotropic => Some(PlainPhase::ISOTROPIC),
            Self::HenyeyGreenstein { g } => Some(PlainPhase {
                g,
                ..PlainPhase::ISOTROPIC
            }),
            Self::Rayleigh => Some(PlainPhase {
                is_rayleigh: true,
                ..PlainPhase::ISOTROPIC
            }),
            Self::Tabulated(_) | Self::Blend(_) => None,
        }
    }
}

impl BlendedPhase {
    fn share_of_second(&self, at: Vec3) -> f32 {
        self.weight.at(at).x.clamp(0.0, 1.0)
    }
}

real_struct! {
    /// A phase function with a formula, in frames whose z axis is the old direction of the path.
    pub(crate) struct PlainPhase<R> {
        /// The mean cosine of the function of Henyey and Greenstein; zero is isotropic.
        g: R,
        /// Whether it is the Rayleigh function instead.
        is_rayleigh: R::Mask,
    }
}

impl<R: Real> PlainPhase<R> {
    /// Uniform over all directions.
    pub const ISOTROPIC: Self = Self {
        g: R::ZERO,
        is_rayleigh: R::Mask::NEVER,
    };

    /// The density as [`Phase::pdf`], by the cosine of the angle between the old and the new direction.
    #[inline(always)]
    pub fn pdf(&self, cosine: R) -> R {
        self.either(|| rayleigh(cosine), henyey_greenstein(self.g, cosine))
    }

    /// A direction as of [`Phase::sample`], and its density.
    #[inline(always)]
    pub fn sample(&self, [u, v]: [R; 2]) -> (R::Vec3, R) {
        let cosine = self.either(|| sample_rayleigh(u), sample_henyey_greenstein(self.g, u));
        (warp::at_height([v, cosine]), self.pdf(cosine))
    }

    #[inline(always)]
    fn either(&self, of_rayleigh: impl Fn() -> R, other: R) -> R {
        match self.is_rayleigh.any() {
            true => R::select(self.is_rayleigh, of_rayleigh(), other),
            false => other,
        }
    }
}

#[inline(always)]
fn henyey_greenstein<R: Real>(g: R, cosine: R) -> R {
    // 1 + g^2 - 2 g cos without cancellation in the peak.
    let (size, rest) = (g.abs(), R::ONE - g.abs());
    let depth = (R::ONE - R::ONE.copy_sign(g) * cosine).max(R::ZERO);
    let squared = (size + size).mul_add(depth, rest * rest);
    R::splat(UNIFORM_SPHERE_PDF) * rest * (R::ONE + size) / (squared * squared.sqrt())
}

/// Samples the cosine by inversion (PBR 4th ed., equation 11.20, with the sign of forward scattering), solved for its
/// distance from the peak. That form does not cancel near the peak, and works for all `g`.
#[inline(always)]
fn sample_henyey_greenstein<R: Real>(g: R, u: R) -> R {
    let (size, rest, sign) = (g.abs(), R::ONE - g.abs(), R::ONE.copy_sign(g));
    let is_backward = sign.is_less(R::ZERO);
    let far = R::select(is_backward, u, R::ONE - u);
    let divisor = (size + size).mul_add(R::ONE - far, rest);
    let ratio = rest / divisor;
    let depth = ratio * ratio * far * (R::ONE + size + divisor);
    sign * (R::ONE - depth).max(-R::ONE)
}

#[inline(always)]
fn rayleigh<R: Real>(cosine: R) -> R {
    R::splat(0.75 * UNIFORM_SPHERE_PDF) * cosine.mul_add(cosine, R::ONE)
}

/// Samples the cosine: the real root of the cubic equation of inversion (Frisvad, Importance sampling the Rayleigh
/// phase function, JOSA A 28(12), 2011).
#[inline(always)]
fn sample_rayleigh<R: Real>(u: R) -> R {
    let half = R::splat(4.0) * u - R::splat(2.0);
    let root = cube_root(half.abs() + half.mul_add(half, R::ONE).sqrt());
    (root - R::ONE / root).min(R::ONE).copy_sign(half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::LanesOf;
    use crate::math::lanes::{LANES, Lanes};
    use crate::sampling::hash::pcg3d;
    use crate::sampling::unit_float;

    const MEAN_COSINES: [f32; 12] = [0.0, 0.5, -0.3, 0.95, 5e-4, -0.9, 0.7, 0.2, 0.999, -0.999, -5e-4, 1e-9];

    #[test]
    fn phases_in_lanes_are_those_of_one() {
        let phases: [Phase; LANES] = std::array::from_fn(|lane| match MEAN_COSINES.get(lane) {
            Some(0.0) => Phase::Isotropic,
            Some(&g) => Phase::HenyeyGreenstein { g },
            None => Phase::Rayleigh,
        });
        let mut lanes = PlainPhase::<Lanes>::ISOTROPIC;
        for (lane, phase) in phases.iter().enumerate() {
            lanes.set_lane(lane, phase.plain().expect("it has a formula"));
        }
        for number in 0..1000 {
            let [x, y, z] = match number {
                0 => [0.0; 3],
                1 => [1.0 - f32::EPSILON / 2.0; 3],
                _ => pcg3d([number, 3, 9]).map(unit_float),
            };
            let (wi, pdf) = lanes.sample([Lanes::splat(x), Lanes::splat(y)]);
            let cosine = 2.0 * z - 1.0;
            let values = lanes.pdf(Lanes::splat(cosine));
            for (lane, phase) in phases.iter().enumerate() {
                let (expected, _) = phase.sample(Vec3::ZERO, Vec3::Z, 0.0, Vec2::new(x, y));
                let found = wi.get(lane);
                assert!(found.is_normalized());
                assert!((found.z - expected.z).abs() < 1e-4, "{found} {expected}");
                let plain = phase.plain().expect("it has a formula");
                for (place, own) in [(found.z, pdf), (cosine, values)] {
                    let (density, own) = (plain.pdf(place), own.as_array()[lane]);
                    assert!((own - density).abs() < 1e-3 * density, "{phase:?}: {own} {density}");
                }
            }
        }
    }
}
