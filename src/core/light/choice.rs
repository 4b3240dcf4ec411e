//! The choice of a light for a sample.
//!
//! Lights at infinity get a fixed share of the samples, divided in proportion to the irradiance that each can give. The
//! others are chosen for each reference point by a tree.

use super::LightReference;
use super::bounds::LightBounds;
use super::reference::Reference;
use super::tree::{LightTree, Shares};
use crate::math::lanes::Lanes;
use crate::sampling::DiscreteDistribution;

/// The light that was chosen, as an index into the list it came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Chosen {
    /// A part of a finite light.
    Part(u32),
    Infinite(u32),
}

#[derive(Clone, Debug, Default)]
pub(super) struct LightChoice {
    finite: Option<LightTree>,
    infinite: Option<DiscreteDistribution>,
    /// Probability of choosing among the lights at infinity.
    infinite_share: f32,
}

/// The share of the samples for lights at infinity if there are others: which kind matters differs from point to point.
const INFINITE_SHARE: f32 = 0.5;

impl LightChoice {
    /// Builds the choice from the bounds of the parts of finite lights and the weights of the infinite lights. A part
    /// without bounds, or a light of weight 0, is never chosen.
    pub fn new(finite: &[Option<LightBounds>], infinite: &[f32]) -> Self {
        let finite = LightTree::build(finite);
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

    /// Whether there is only one part or light to choose.
    pub fn is_certain(&self) -> bool {
        self.certain().is_some()
    }

    fn certain(&self) -> Option<Chosen> {
        match (&self.finite, &self.infinite) {
            (Some(finite), None) => finite.only().map(Chosen::Part),
            (None, Some(infinite)) if infinite.len() == 1 => Some(Chosen::Infinite(0)),
            _ => None,
        }
    }

    /// The choice for `u` in [0, 1), with its probability; None if no light reaches `reference`. If there is only one
    /// light, `u` is not used.
    #[inline]
    pub fn sample(&self, reference: &LightReference, u: impl FnOnce() -> f64) -> Option<(Chosen, f32)> {
        self.sample_by(u, |tree, u| tree.sample(reference, u))
    }

    /// The probabilities by which [`Self::sample_lane`] chooses among finite lights; None where each lane has to
    /// descend the tree on its own.
    pub fn shares(&self, from: &Reference<Lanes>) -> Option<Shares> {
        self.finite.as_ref()?.shares(from)
    }

    /// [`Self::sample`] for the reference point of one lane.
    pub fn sample_lane(&self, lane: usize, shares: &Shares, u: impl FnOnce() -> f64) -> Option<(Chosen, f32)> {
        self.sample_by(u, |tree, u| tree.sample_lane(lane, shares, u))
    }

    /// `of_finite` chooses among the finite lights.
    #[inline(always)]
    fn sample_by(
        &self,
        u: impl FnOnce() -> f64,
        of_finite: impl FnOnce(&LightTree, f64) -> Option<(u32, f32)>,
    ) -> Option<(Chosen, f32)> {
        if let Some(only) = self.certain() {
            return Some((only, 1.0));
        }
        let u = u();
        let infinite_share = f64::from(self.infinite_share);
        if u < infinite_share {
            let sample = self.infinite.as_ref()?.sample((u / infinite_share) as f32);
            return Some((Chosen::Infinite(sample.index), self.infinite_share * sample.pmf));
        }
        let u = (u - infinite_share) / (1.0 - infinite_share);
        let (part, pmf) = of_finite(self.finite.as_ref()?, u)?;
        Some((Chosen::Part(part), (1.0 - self.infinite_share) * pmf))
    }

    /// The probability with which [`Self::sample`] makes this choice.
    #[inline]
    pub fn pmf(&self, reference: &LightReference, chosen: Chosen) -> f32 {
        match chosen {
            Chosen::Part(part) => {
                let pmf = self.finite.as_ref().map_or(0.0, |tree| tree.pmf(reference, part));
                (1.0 - self.infinite_share) * pmf
            }
            Chosen::Infinite(index) => {
                let pmf = self.infinite.as_ref().map_or(0.0, |choice| choice.pmf(index));
                self.infinite_share * pmf
            }
        }
    }
}
