//! A hierarchy over emitters that chooses one of them with about the probability of its contribution to a reference point.
//!
//! Conty Estevez and Kulla, Importance Sampling of Many Lights with Adaptive Tree Splitting, 2018, without the splitting; PBR 4th ed.,
//! section 12.6.3. One random number goes down the tree and is stretched at every step. `node.rs` estimates importances, `build.rs`
//! decides what belongs together. Nothing here knows what a light is.

mod build;
mod node;

use self::node::{Content, Node};
use super::LightReference;

#[derive(Clone, Debug)]
pub(super) struct LightTree {
    /// Siblings lie together. The first pair is the root's, empty if there is but one emitter.
    pairs: Vec<[Node; 2]>,
    /// The place of the node that each pair belongs to; the root's is not used.
    parents: Vec<Place>,
    /// The place of each emitter's leaf; None for those without bounds.
    leaves: Vec<Option<Place>>,
    /// The emitter, if there is but one.
    only: Option<u32>,
}

/// A node: twice its pair's index, plus one for the second of the two.
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
    /// The emitter, if there is but one.
    pub fn only(&self) -> Option<u32> {
        self.only
    }

    /// The emitter for `u` in [0, 1), with its probability. None if the bounds turn out to hold nothing that sends light to `reference`.
    pub fn sample(&self, reference: &LightReference, u: f64) -> Option<(u32, f32)> {
        if let Some(only) = self.only {
            return Some((only, 1.0));
        }
        let (mut pair, mut u, mut pmf) = (0, u, 1.0);
        loop {
            let nodes = &self.pairs[pair as usize];
            let first = share_of_first(nodes, reference)?;
            let side = usize::from(u >= first);
            let (start, share) = if side == 0 { (0.0, first) } else { (first, 1.0 - first) };
            u = ((u - start) / share).min(BELOW_ONE);
            pmf *= share;
            match nodes[side].content() {
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
        let mut pmf = 1.0;
        loop {
            let pair = place.pair();
            let Some(first) = share_of_first(&self.pairs[pair as usize], reference) else {
                return 0.0;
            };
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

/// The least probability of a node that sends light at all: estimates do not know of occluders.
const LEAST_SHARE: f64 = 1e-3;

/// Probability of going to the first of two; None if neither sends light to `reference`.
fn share_of_first(nodes: &[Node; 2], reference: &LightReference) -> Option<f64> {
    let [first, second] = [0, 1].map(|side: usize| nodes[side].importance(reference));
    match (first > 0.0, second > 0.0) {
        (true, true) => Some((first / (first + second)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)),
        (true, false) => Some(1.0),
        (false, true) => Some(0.0),
        (false, false) => None,
    }
}

#[cfg(test)]
mod tests;
