//! The error of a pixel's mean, estimated from the difference of its halves.
//!
//! The samples of a pixel are points of one scrambled net, which complement each other: the mean of n of them is more
//! accurate than their spread suggests. The mean over the first half of 2^k samples and the mean over the second are
//! exchangeable, so half of their squared difference has the expectation V(n / 2) - V(n), where V is the variance of
//! the mean (Owen, Scrambled net variance for integrals of smooth functions, Annals of Statistics 25(4), 1997, on how V
//! falls). V(n) itself cannot be measured by the samples and is extrapolated: each doubling removes the same share `r`
//! of what the previous one removed, so that V(n) = D r / (1 - r), where D is the last such difference. `r` is 1/2 for
//! independent samples, for which the estimate is the usual one, and at least 1/8, for smooth integrands.
//!
//! The differences of single pixels are one number each, so they are summed over patches of [`PATCH`] x [`PATCH`]
//! pixels, and `r` is that of a tile. The [blocks](super::blocks) of a patch may have different numbers of samples: the
//! sums are then of ratios to the differences expected of independent samples. A pixel's own share of its patch's error
//! is that of its samples' spread, which is known far better. A rare bright sample enlarges the spread and the
//! difference alike, once it is found; light that no sample has found yet is in no estimate.

use bytemuck::{Pod, Zeroable};

use super::blocks::{BLOCK, PerBlock};
use crate::render::noise::DARK;
use crate::render::tile::TILE;

/// The edge in pixels of the patches over which the differences of halves are summed.
pub(in crate::render) const PATCH: u32 = 8;
/// The number of patches in a tile.
const PATCHES: usize = (TILE / PATCH * (TILE / PATCH)) as usize;

/// The bounds of the share of a doubling in the previous one.
const SHARES: [f32; 2] = [0.125, 0.5];

/// How the samples of a block's pixels differ, all of which have the same number of samples. Sums over pixels are of
/// squares relative to the pixels' luminances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(in crate::render) struct BlockError {
    /// The power of two of samples at which the means were noted last; 0 before that.
    pub noted: u32,
    /// The power of two of samples whose halves were compared last; 0 before that.
    pub level: u32,
    /// The sum of half the halves' difference squared.
    pub difference: f32,
    /// The same at half of `level`; negative if halves were not compared then.
    pub difference_before: f32,
    /// The sum of the mean squared deviations of single samples from their mean, at `level`.
    pub spread: f32,
    /// The mean magnitude of the luminance of its patch, at `level`.
    pub luminance: f32,
}

/// The sampling efficiency of a tile, from the differences of halves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::render) struct Efficiency {
    /// The share of a doubling in the previous one.
    share: f32,
    /// The ratio of each patch's squared differences to those of independent samples, converted to level 1 by
    /// [`Self::share`]; 0 while unknown.
    patches: [f32; PATCHES],
}

impl BlockError {
    /// Whether any of its numbers is none. They may be beyond all numbers.
    pub fn has_nan(&self) -> bool {
        let numbers = [self.difference, self.difference_before, self.spread, self.luminance];
        numbers.iter().any(|number| number.is_nan())
    }
}

impl Default for Efficiency {
    fn default() -> Self {
        Self {
            share: SHARES[1],
            patches: [0.0; PATCHES],
        }
    }
}

impl Efficiency {
    /// The efficiency of a tile with these blocks.
    pub fn of(blocks: &PerBlock<BlockError>) -> Self {
        let mut found = Self {
            share: share_of_doubling(blocks),
            ..Self::default()
        };
        let mut sums = [[0.0; 2]; PATCHES];
        for (error, place) in blocks.iter().zip(0..).filter(|(error, _)| error.level > 1) {
            let [differences, independent] = &mut sums[patch_of(place)];
            *differences += error.difference;
            *independent += error.spread / (error.level - 1) as f32 * found.gain(error.level);
        }
        let ratio = |[differences, independent]: [f32; 2]| match differences > 0.0 && independent > 0.0 {
            true => differences / independent,
            false => 0.0,
        };
        found.patches = sums.map(ratio);
        found
    }

    /// The ratio of squared differences to those of independent samples at a level, over the same ratio at level 1.
    fn gain(&self, level: u32) -> f32 {
        (2.0 * self.share).powi(level.ilog2() as i32)
    }

    /// The variance of the mean over `samples` of a pixel in a block, over the mean squared deviation of its samples.
    /// Halves of the block were compared at `level`.
    pub fn at(&self, block: usize, level: u32, samples: u32) -> f32 {
        let ratio = self.patches[patch_of(block)];
        if level < 2 || ratio <= 0.0 {
            return 1.0 / (samples.max(2) - 1) as f32;
        }
        let unit = ratio * self.gain(level) / (level - 1) as f32;
        unit * variance(samples, level, self.share, unit.recip())
    }
}

/// The patch that a block is in.
fn patch_of(block: usize) -> usize {
    let (columns, blocks) = ((TILE / BLOCK) as usize, (PATCH / BLOCK) as usize);
    let (row, column) = (block / columns / blocks, block % columns / blocks);
    row * (TILE / PATCH) as usize + column
}

/// The share of a doubling in the previous one, in a tile of these blocks. Dark blocks have less weight, as in the
/// noise of a picture.
fn share_of_doubling(blocks: &[BlockError]) -> f32 {
    let bright = blocks.iter().map(|block| block.luminance).sum::<f32>() / blocks.len() as f32;
    let known = blocks
        .iter()
        .filter(|block| block.level > 0 && block.difference_before >= 0.0);
    let [last, before] = known.fold([0.0; 2], |[last, before], block| {
        let weight = (block.luminance / block.luminance.max(DARK * bright).max(f32::MIN_POSITIVE)).powi(2);
        [
            last + weight * block.difference,
            before + weight * block.difference_before,
        ]
    });
    let [least, most] = SHARES;
    if before > 0.0 {
        (last / before).clamp(least, most)
    } else {
        most
    }
}

/// The variance of the mean of the first `samples` of a net, in units of the variance removed by the doubling to
/// `level`, where later doublings remove `share` of the previous one. `single` is the variance of one sample.
///
/// The mean over a node of the binary tree of samples differs from the means over its halves by independent amounts.
/// The variance is the sum of those of the amounts that do not cancel.
fn variance(samples: u32, level: u32, share: f32, single: f32) -> f32 {
    let (mut level, mut step) = (u64::from(level), 1.0);
    let samples = u64::from(samples);
    while samples >= 2 * level {
        level *= 2;
        step *= share;
    }
    let rest = |step: f32| step * share / (1.0 - share);
    if samples <= level {
        return rest(step);
    }
    // The next node is incomplete: its first half is complete.
    let next = step * share;
    let (count, more) = (samples as f32, (samples - level) as f32);
    let lack = (level as f32 - more) / count;
    rest(next) + next * lack * lack + (more / count).powi(2) * within(samples - level, level, step, share, single)
}

/// The variance of the mean of the first `samples` around that of their node of `size` samples, whose halves differ by
/// `step`.
fn within(samples: u64, size: u64, step: f32, share: f32, single: f32) -> f32 {
    let (mut samples, mut size, mut step) = (samples, size, step);
    let (mut sum, mut factor) = (0.0, 1.0);
    let most = single / samples as f32;
    while samples < size && sum < most {
        let half = size / 2;
        if samples <= half {
            sum += factor * step;
        } else {
            let more = samples - half;
            let (lack, all) = ((half - more) as f32, samples as f32);
            sum += factor * step * (lack / all).powi(2);
            factor *= (more as f32 / all).powi(2);
            samples = more;
        }
        (size, step) = (half, step / share);
    }
    sum.min(most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Sampler, SequenceKind};
    use glam::UVec2;

    #[test]
    fn independent_samples_have_the_variance_of_the_textbook() {
        // Each doubling removes half of what the previous one removed, and a single sample has 16 times the variance of
        // a mean of 16.
        for samples in [16, 17, 20, 24, 31, 32, 48, 63, 64, 100] {
            let found = variance(samples, 16, 0.5, 16.0);
            assert!(
                (found / (16.0 / samples as f32) - 1.0).abs() < 1e-4,
                "{samples}: {found}"
            );
        }
    }

    #[test]
    fn the_error_between_powers_of_two_is_above_that_at_the_next() {
        for share in [0.125, 0.25, 0.4] {
            let [at, between, next] = [16, 24, 32].map(|samples| variance(samples, 16, share, 1e3));
            assert!((next / at - share).abs() < 1e-5, "{share}");
            assert!(between > next && between < 1.5 * at, "{share}: {at} {between} {next}");
        }
        // One sample more than a good net adds its whole spread.
        let one_more = variance(257, 256, 0.125, 1e4);
        assert!(one_more > 0.1 && one_more < 1.0, "{one_more}");
    }

    /// The estimated and the true variance of means of `f` over `samples`, over many pixels.
    fn compared(kind: SequenceKind, samples: u32, f: impl Fn(glam::Vec2) -> f32, truth: f32) -> [f32; 2] {
        let mut block = BlockError::default();
        let places: Vec<UVec2> = (0..64).flat_map(|y| (0..64).map(move |x| UVec2::new(x, y))).collect();
        let (mut sums, mut squares) = (vec![0.0; places.len()], vec![0.0; places.len()]);
        let mut noted = vec![[0.0; 2]; places.len()];
        for sample in 0..samples {
            for (place, (sum, square)) in places.iter().zip(sums.iter_mut().zip(&mut squares)) {
                let value = f(Sampler::new(kind, *place, sample, 1).at_2d(20));
                *sum += value;
                *square += value * value;
            }
            let count = sample + 1;
            if !count.is_power_of_two() {
                continue;
            }
            let means: Vec<f32> = sums.iter().map(|sum| sum / count as f32).collect();
            let squared = |steps: &mut dyn Iterator<Item = f32>| steps.map(|step| step * step).sum::<f32>();
            if count > 1 {
                let spread = means.iter().zip(&squares);
                block = BlockError {
                    noted: count,
                    level: count,
                    difference: squared(&mut means.iter().zip(&noted).map(|(mean, [half, _])| mean - half)),
                    difference_before: squared(&mut noted.iter().map(|[half, quarter]| half - quarter)),
                    spread: spread.map(|(mean, square)| square / count as f32 - mean * mean).sum(),
                    luminance: 1.0,
                };
            }
            noted = means
                .iter()
                .zip(&noted)
                .map(|(&mean, &[half, _])| [mean, half])
                .collect();
        }
        let spread: f32 = sums
            .iter()
            .zip(&squares)
            .map(|(sum, square)| {
                let mean = sum / samples as f32;
                square / samples as f32 - mean * mean
            })
            .sum();
        let mut blocks = [BlockError::default(); _];
        blocks[0] = block;
        let estimated = spread * Efficiency::of(&blocks).at(0, block.level, samples);
        let error = sums.iter().map(|sum| (sum / samples as f32 - truth).powi(2)).sum();
        [estimated, error].map(|sum: f32| sum / places.len() as f32)
    }

    #[test]
    fn estimates_agree_with_true_errors() {
        let inside_circle = |p: glam::Vec2| f32::from(u8::from(p.length() < 1.0));
        let quarter = std::f32::consts::FRAC_PI_4;
        for kind in [SequenceKind::Independent, SequenceKind::Sobol] {
            for samples in [16, 24, 64, 96, 256] {
                let [estimated, error] = compared(kind, samples, inside_circle, quarter);
                let ratio = (estimated / error).sqrt();
                // The error of an edge falls differently at each doubling.
                assert!((ratio - 1.0).abs() < 0.25, "{kind:?}, {samples}: {ratio}");
            }
        }
        // Without extrapolation the estimate of the second would be far too high.
        let [estimated, error] = compared(SequenceKind::Sobol, 64, |p| p.x + p.y, 1.0);
        let ratio = (estimated / error).sqrt();
        assert!((ratio - 1.0).abs() < 0.25, "{ratio}");
    }

    #[test]
    fn blocks_of_a_patch_may_have_different_numbers_of_samples() {
        // All pixels have half the error of independent samples at 16, which each doubling halves; blocks without
        // samples are ignored.
        let mut blocks = [BlockError::default(); _];
        let columns = (TILE / BLOCK) as usize;
        for (place, level) in [(0, 16), (1, 64), (columns, 16), (columns + 1, 64)] {
            blocks[place] = BlockError {
                noted: level,
                level,
                difference: 8.0 / level as f32 * 3.0 / (level - 1) as f32,
                difference_before: 4.0 * 8.0 / level as f32 * 3.0 / (level - 1) as f32,
                spread: 3.0,
                luminance: 1.0,
            };
        }
        let efficiency = Efficiency::of(&blocks);
        for (place, level) in [(0, 16), (1, 64)] {
            // The differences are three times the remaining error.
            let found = 3.0 * efficiency.at(place, level, level) * (level - 1) as f32;
            assert!((found - 8.0 / level as f32).abs() < 1e-4, "{level}: {found}");
        }
        // Blocks without comparisons have the error of independent samples, in this patch and in others.
        assert_eq!(efficiency.at(2, 0, 10), 1.0 / 9.0);
        assert_eq!(efficiency.at(100, 16, 16), 1.0 / 15.0);
    }
}
