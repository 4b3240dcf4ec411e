//! A hierarchy over emitters that chooses one of them with about the probability of its contribution to a reference
//! point.
//!
//! Conty Estevez and Kulla, Importance Sampling of Many Lights with Adaptive Tree Splitting, 2018, without the
//! splitting; PBR 4th ed., section 12.6.3. One random number goes down the tree and is stretched at every step.
//! `node.rs` estimates importances, `build.rs` decides on the splits. The tree knows bounds alone, not lights.

mod build;
mod node;

use arrayvec::ArrayVec;

use self::node::{Content, Node};
use super::LightReference;
use super::reference::Reference;
use crate::math::Real;
use crate::math::lanes::Lanes;

#[derive(Clone, Debug)]
pub(super) struct LightTree {
    /// Pairs of siblings. The first pair is the root's, absent if there is only one emitter.
    pairs: Vec<[Node; 2]>,
    /// The parent node of each pair; the root's is not used.
    parents: Vec<Place>,
    /// The leaf of each emitter; None for those without bounds.
    leaves: Vec<Option<Place>>,
    /// The only emitter, if there is just one.
    only: Option<u32>,
}

/// The index of a node: twice its pair's index, plus one for the second sibling.
#[derive(Clone, Copy, Debug, Default)]
struct Place(u32);

impl Place {
    fn new(pair: u32, side: usize) -> Self {
        Self(2 * pair + side as u32)
    }

    fn pair(self) -> u32 {
        self.0 / 2
    }

    fn side(self) -> usize {
        self.0 as usize % 2
    }
}

impl LightTree {
    /// The only emitter, if there is just one.
    pub fn only(&self) -> Option<u32> {
        self.only
    }

    /// The emitter for `u` in [0, 1), with its probability. None if the walk ends at bounds that send no light to
    /// `reference`.
    pub fn sample(&self, reference: &LightReference, u: f64) -> Option<(u32, f32)> {
        let from = Reference::from(reference);
        self.descend(u, |pair| share_of_first(&self.pairs[pair as usize], &from))
    }

    /// The probabilities by which [`Self::sample_lane`] chooses; None for a large tree, where lanes take different
    /// paths.
    pub fn shares(&self, from: &Reference<Lanes>) -> Option<Shares> {
        let is_small = self.only.is_none() && self.pairs.len() <= MOST_SHARED;
        is_small.then(|| self.pairs.iter().map(|pair| share_of_first(pair, from)).collect())
    }

    /// [`Self::sample`] for the reference of one lane.
    pub fn sample_lane(&self, lane: usize, shares: &Shares, u: f64) -> Option<(u32, f32)> {
        self.descend(u, |pair| shares[pair as usize].as_array()[lane])
    }

    /// `share` gives the value of [`share_of_first`] for a pair.
    #[inline(always)]
    fn descend(&self, mut u: f64, share: impl Fn(u32) -> f32) -> Option<(u32, f32)> {
        if let Some(only) = self.only {
            return Some((only, 1.0));
        }
        let (mut pair, mut pmf) = (0, 1.0);
        loop {
            let first = f64::from(share(pair));
            if first < 0.0 {
                return None;
            }
            let side = usize::from(u >= first);
            let (start, share) = if side == 0 { (0.0, first) } else { (first, 1.0 - first) };
            u = ((u - start) / share).min(BELOW_ONE);
            pmf *= share;
            match self.pairs[pair as usize][side].content() {
                Content::Emitter(emitter) => return Some((emitter, pmf as f32)),
                Content::Pair(child) => pair = child,
            }
        }
    }

    /// The probability with which [`Self::sample`] gives `emitter`.
    pub fn pmf(&self, reference: &LightReference, emitter: u32) -> f32 {
        let Some(mut place) = self.leaves[emitter as usize] else {
            return 0.0;
        };
        if self.only.is_some() {
            return 1.0;
        }
        let from = Reference::from(reference);
        let mut pmf = 1.0;
        loop {
            let pair = place.pair();
            let first = f64::from(share_of_first::<f32>(&self.pairs[pair as usize], &from));
            if first < 0.0 {
                return 0.0;
            }
            pmf *= if place.side() == 0 { first } else { 1.0 - first };
            if pair == 0 || pmf == 0.0 {
                return pmf as f32;
            }
            place = self.parents[pair as usize];
        }
    }
}

/// The largest `f64` below one.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// The least probability of a node that sends light at all: estimates ignore occluders.
const LEAST_SHARE: f32 = 1e-3;

/// The most pairs whose probabilities are computed for all lanes at once, whether or not a lane reaches them.
const MOST_SHARED: usize = 7;

/// The value of [`share_of_first`] for each pair.
pub(super) type Shares = ArrayVec<Lanes, MOST_SHARED>;

/// The probability of the first of two siblings, or -1 if neither sends light to the reference.
#[inline(always)]
fn share_of_first<R: Real>(nodes: &[Node; 2], from: &Reference<R>) -> R {
    let (first, second) = (nodes[0].seen_from(from), nodes[1].seen_from(from));
    let (of_first, of_second) = (first.is_lit(), second.is_lit());
    let share = R::ONE / (R::ONE + second.over(&first));
    let share = share.max(R::splat(LEAST_SHARE)).min(R::splat(1.0 - LEAST_SHARE));
    let of_one = R::select(of_first, R::ONE, R::select(of_second, R::ZERO, -R::ONE));
    R::select(of_first & of_second, share, of_one)
}

#[cfg(test)]
mod tests;
