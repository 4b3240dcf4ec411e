//! The choice of the light that a path starts from. The points that it will light are unknown, so lights are chosen by
//! their power.

use std::f32::consts::PI;

use super::bounds::LightBounds;
use super::choice::Chosen;
use super::emission::SceneSphere;
use crate::sampling::DiscreteDistribution;

#[derive(Clone, Debug, Default)]
pub(super) struct EmissionChoice {
    parts: Option<DiscreteDistribution>,
    /// The approximate power of all parts (luminance, W).
    power: f32,
    infinite: Option<DiscreteDistribution>,
    /// The irradiance of all lights at infinity.
    irradiance: f32,
}

/// The least share of the paths from lights at infinity if there are others, and of paths from those others.
const LEAST_SHARE: f32 = 0.1;

impl EmissionChoice {
    /// Bounds of the parts of finite lights, and weights of the lights at infinity.
    pub fn new(parts: &[Option<LightBounds>], infinite: &[f32]) -> Self {
        let powers: Vec<f32> = parts
            .iter()
            .map(|bounds| bounds.as_ref().map_or(0.0, LightBounds::power))
            .collect();
        Self {
            parts: DiscreteDistribution::new(&powers),
            power: powers.iter().sum(),
            infinite: DiscreteDistribution::new(infinite),
            irradiance: infinite.iter().sum(),
        }
    }

    /// The share of the paths that start at infinity.
    fn infinite_share(&self, sphere: &SceneSphere) -> f32 {
        match (&self.parts, &self.infinite) {
            (_, None) => 0.0,
            (None, Some(_)) => 1.0,
            (Some(_), Some(_)) => {
                let infinite = self.irradiance * sphere.cross_section();
                let share = infinite / (infinite + self.power);
                let share = if share.is_finite() { share } else { 0.5 };
                share.clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)
            }
        }
    }

    /// The choice for `u` in [0, 1), with its probability.
    pub fn sample(&self, sphere: &SceneSphere, u: f32) -> Option<(Chosen, f32)> {
        let share = self.infinite_share(sphere);
        let below_one = |u: f32| u.clamp(0.0, 1.0 - f32::EPSILON);
        if u < share {
            let sample = self.infinite.as_ref()?.sample(below_one(u / share));
            return Some((Chosen::Infinite(sample.index), share * sample.pmf));
        }
        let sample = self.parts.as_ref()?.sample(below_one((u - share) / (1.0 - share)));
        Some((Chosen::Part(sample.index), (1.0 - share) * sample.pmf))
    }

    /// The probability with which [`Self::sample`] makes this choice.
    pub fn pmf(&self, sphere: &SceneSphere, chosen: Chosen) -> f32 {
        let share = self.infinite_share(sphere);
        let pmf_of =
            |choice: &Option<DiscreteDistribution>, index| choice.as_ref().map_or(0.0, |choice| choice.pmf(index));
        match chosen {
            Chosen::Part(part) => (1.0 - share) * pmf_of(&self.parts, part),
            Chosen::Infinite(index) => share * pmf_of(&self.infinite, index),
        }
    }
}

impl LightBounds {
    /// The approximate power that it emits (luminance, W).
    fn power(&self) -> f32 {
        let solid_angle = if self.cone.cos_angle <= -1.0 {
            4.0 * PI
        } else if self.cos_emission == 0.0 {
            PI
        } else {
            2.0 * PI * (1.0 - self.cos_emission)
        };
        self.intensity * solid_angle
    }
}
