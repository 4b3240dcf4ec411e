//! The choice of a light for a sample.
//!
//! Lights at infinity have a fixed share of the samples, in which each has a part in proportion to the irradiance it can give.

use super::LightReference;
use crate::sampling::DiscreteDistribution;

/// What was chosen, as an index into the list it came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Chosen {
    /// A part of a finite light.
    Part(u32),
    Infinite(u32),
}

#[derive(Clone, Debug, Default)]
pub(super) struct LightChoice {
    finite: Option<DiscreteDistribution>,
    infinite: Option<DiscreteDistribution>,
    /// Probability of choosing among the lights at infinity.
    infinite_share: f32,
}

/// Share of the samples that go to lights at infinity where there are others: which kind matters differs from place to place.
const INFINITE_SHARE: f32 = 0.5;

impl LightChoice {
    /// From the weights of the parts of finite lights and of the infinite lights; what has weight 0 is never chosen.
    pub fn new(finite: &[f32], infinite: &[f32]) -> Self {
        let finite = DiscreteDistribution::new(finite);
        let infinite = DiscreteDistribution::new(infinite);
        let infinite_share = match (&finite, &infinite) {
            (Some(_), Some(_)) => INFINITE_SHARE,
            (None, Some(_)) => 1.0,
            (_, None) => 0.0,
        };
        Self {
            finite,
            infinite,
            infinite_share,
        }
    }

    /// The choice that `u` in [0, 1) stands for, with its probability; None if nothing shines.
    pub fn sample(&self, _reference: &LightReference, u: f32) -> Option<(Chosen, f32)> {
        if u < self.infinite_share {
            let sample = self.infinite.as_ref()?.sample(u / self.infinite_share);
            return Some((Chosen::Infinite(sample.index), self.infinite_share * sample.pmf));
        }
        let finite_share = 1.0 - self.infinite_share;
        let sample = self.finite.as_ref()?.sample((u - self.infinite_share) / finite_share);
        Some((Chosen::Part(sample.index), finite_share * sample.pmf))
    }

    /// The probability with which [`Self::sample`] makes this choice.
    pub fn pmf(&self, _reference: &LightReference, chosen: Chosen) -> f32 {
        let of = |choice: &Option<DiscreteDistribution>, index| choice.as_ref().map_or(0.0, |choice| choice.pmf(index));
        match chosen {
            Chosen::Part(part) => (1.0 - self.infinite_share) * of(&self.finite, part),
            Chosen::Infinite(index) => self.infinite_share * of(&self.infinite, index),
        }
    }
}
