//! The distribution of a picture's samples among its blocks, for [`super`].

/// The least and the most samples of a block, as shares of the mean number.
pub(super) const LEAST: f64 = 0.25;
const MOST: f64 = 8.0;
/// The approximate number of blocks by which the total cost is estimated.
const ENOUGH: usize = 1 << 16;
/// The halvings in the search for the factor between noise and samples, which narrow it to a hundred thousandth.
const HALVINGS: u32 = 21;

/// A block in a round.
pub(super) struct Candidate {
    pub place: u32,
    /// The noise as predicted by neighbours.
    pub noise: f32,
    pub cost: f32,
    pub least: f32,
}

/// Rounds to a number of samples that suits nets: powers of two and those half way between, or in a round that does not
/// double, multiples of an eighth of it.
pub(super) fn rounded(samples: f64, from: u32, to: u32) -> u32 {
    if to == 2 * from && from.is_power_of_two() {
        let below = samples.log2().floor().exp2();
        let share = samples / below;
        // The geometric means of 1, 1.5 and 2.
        let share = if share < 1.225 {
            1.0
        } else if share < 1.732 {
            1.5
        } else {
            2.0
        };
        (below * share) as u32
    } else {
        let step = f64::from(((to - from) / 8).max(1));
        ((samples / step).round() * step) as u32
    }
}

/// The samples of each block that cost about as much in total as `mean` samples of every block: the optimum for
/// independent samples, the root of noise over cost, to the power `power`, but at least `least`. `round` gives the
/// nearest allowed number.
pub(super) fn shares(blocks: &[Candidate], power: f64, mean: f64, round: impl Fn(f64) -> f64) -> Vec<f64> {
    let weights: Vec<f64> = blocks
        .iter()
        .map(|block| {
            let ratio = f64::from(block.noise / block.cost.max(1.0));
            ratio.powf(0.5 * power)
        })
        .collect();
    let at = |factor: f64, place: usize| {
        let wanted = (factor * weights[place]).clamp(LEAST * mean, MOST * mean);
        round(wanted).max(f64::from(blocks[place].least))
    };
    // Of many blocks, some are used to estimate the total cost.
    let some = || (0..blocks.len()).step_by(stride(blocks.len(), ENOUGH));
    let cost_of = |place: usize| f64::from(blocks[place].cost);
    let budget: f64 = mean * some().map(cost_of).sum::<f64>();
    let cost = |factor: f64| -> f64 { some().map(|place| cost_of(place) * at(factor, place)).sum() };
    let typical = weights.iter().sum::<f64>() / weights.len().max(1) as f64;
    if !(typical > 0.0 && typical.is_finite()) {
        return vec![mean; blocks.len()];
    }
    let (mut low, mut high) = (1e-3 * mean / typical, 1e3 * mean / typical);
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        if cost(middle) <= budget {
            low = middle;
        } else {
            high = middle;
        }
    }
    (0..blocks.len()).map(|place| at(low, place)).collect()
}

/// The step that visits about `enough` of `count` blocks; odd, because rows of blocks are even.
pub(super) fn stride(count: usize, enough: usize) -> usize {
    (count / enough + 1) | 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidates(noise: &[f32], cost: f32) -> Vec<Candidate> {
        let block = |(place, &noise): (u32, &f32)| Candidate {
            place,
            noise,
            cost,
            least: 0.0,
        };
        (0..).zip(noise).map(block).collect()
    }

    #[test]
    fn numbers_suit_nets() {
        let doubling = [60.0, 70.0, 90.0, 120.0, 900.0].map(|samples| rounded(samples, 64, 128));
        assert_eq!(doubling, [64, 64, 96, 128, 1024]);
        assert_eq!([101.0, 110.0].map(|samples| rounded(samples, 80, 96)), [102, 110]);
    }

    #[test]
    fn samples_follow_the_root_of_noise_over_cost_and_cost_as_much() {
        let shares_of =
            |noise: &[f32], power: f64| shares(&candidates(noise, 3.0), power, 100.0, std::convert::identity);
        let found = shares_of(&[1.0, 4.0, 4.0, 9.0], 1.0);
        for (samples, expected) in found.iter().zip([50.0, 100.0, 100.0, 150.0]) {
            assert!((samples / expected - 1.0).abs() < 1e-3, "{found:?}");
        }
        // Clamped without noise and with very much of it.
        let far = shares_of(&[0.0, 1.0, 1.0, 1e12], 1.0);
        assert!(
            far[0] == 25.0 && far[3] <= 800.0 && far.iter().sum::<f64>() <= 400.01,
            "{far:?}"
        );
        assert_eq!(shares_of(&[0.0; 3], 1.0), [100.0; 3]);
        assert_eq!(shares_of(&[], 1.0), [0.0; 0]);
        // A block with four times the cost gets half the samples.
        let mut blocks = candidates(&[1.0, 1.0], 1.0);
        blocks[1].cost = 4.0;
        let found = shares(&blocks, 1.0, 100.0, std::convert::identity);
        assert!((found[0] / found[1] - 2.0).abs() < 1e-3, "{found:?}");
    }
}
