//! The counter-based sampler: numbers as a pure function of (pixel, sample index, dimension, seed).
//!
//! `Independent` is white noise. `Sobol` is the first two dimensions of the Sobol sequence with hashed Owen scrambling, padded: every
//! draw is a differently scrambled and differently shuffled copy of the same good 2D sequence (Burley, Practical Hash-based Owen
//! Scrambling, JCGT 9(4), 2020), so there is no limit on dimensions and no correlation between draws. Within one draw the first 2^k
//! samples of a pixel form a (0, k, 2)-net. Not blue noise: pixels are decorrelated, not dithered against their neighbours.

use super::{
    hash::{pcg3d, pcg4d},
    unit_float,
};
use glam::{UVec2, Vec2};

/// Which numbers a [`Sampler`] hands out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SequenceKind {
    /// White noise.
    Independent,
    /// Owen-scrambled Sobol points, padded and shuffled per draw: less noise for the same count.
    #[default]
    Sobol,
}

/// The numbers of one sample of one pixel.
///
/// A "dimension" is one draw, 1D or 2D; each draw advances it by one. Draws of different dimensions are independent of each other.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    kind: SequenceKind,
    /// A hash of pixel and seed.
    key: [u32; 2],
    /// The sample index; with its bits reversed for `Sobol`, as the shuffle needs it.
    index: u32,
    dimension: u32,
}

impl Sampler {
    /// The sampler of sample `sample_index` of `pixel`, at dimension 0. Any seed is as good as any other.
    pub fn new(kind: SequenceKind, pixel: UVec2, sample_index: u32, seed: u32) -> Self {
        let [a, b, _] = pcg3d([pixel.x, pixel.y, seed]);
        Self {
            kind,
            key: [a, b],
            index: match kind {
                SequenceKind::Independent => sample_index,
                SequenceKind::Sobol => sample_index.reverse_bits(),
            },
            dimension: 0,
        }
    }

    /// Jumps to dimension `dimension`, so that each bounce has its own fixed dimensions however many the one before it used.
    pub fn start_dimension(&mut self, dimension: u32) {
        self.dimension = dimension;
    }

    /// The next number, in [0, 1).
    pub fn next_1d(&mut self) -> f32 {
        let dimension = self.advance();
        unit_float(match self.kind {
            SequenceKind::Independent => pcg4d([self.key[0], self.key[1], self.index, dimension])[0],
            SequenceKind::Sobol => {
                let [shuffle_seed, seed, _] = pcg3d([self.key[0], self.key[1], dimension]);
                let index = scramble_reversed(self.index, shuffle_seed).reverse_bits();
                scramble_reversed(index, seed).reverse_bits()
            }
        })
    }

    /// The next pair of numbers, each in [0, 1).
    pub fn next_2d(&mut self) -> Vec2 {
        let dimension = self.advance();
        let [x, y] = match self.kind {
            SequenceKind::Independent => {
                let [x, y, ..] = pcg4d([self.key[0], self.key[1], self.index, dimension]);
                [x, y]
            }
            SequenceKind::Sobol => {
                let [shuffle_seed, seed_x, seed_y] = pcg3d([self.key[0], self.key[1], dimension]);
                let index = scramble_reversed(self.index, shuffle_seed).reverse_bits();
                [
                    scramble_reversed(index, seed_x).reverse_bits(),
                    scramble_reversed(sobol_second_reversed(index), seed_y).reverse_bits(),
                ]
            }
        };
        Vec2::new(unit_float(x), unit_float(y))
    }

    /// At dimension 0, from what [`Self::key`] and [`Self::index`] give.
    pub(super) fn of_key(kind: SequenceKind, key: [u32; 2], index: u32) -> Self {
        Self {
            kind,
            key,
            index,
            dimension: 0,
        }
    }

    pub(super) fn key(&self) -> [u32; 2] {
        self.key
    }

    pub(super) fn index(&self) -> u32 {
        self.index
    }

    fn advance(&mut self) -> u32 {
        let dimension = self.dimension;
        self.dimension = dimension.wrapping_add(1);
        dimension
    }
}

/// Nested uniform (Owen) scrambling in base 2 of a number whose most significant digit is bit 0: each bit is flipped by a hash of the
/// bits below it and the seed. The hash of Laine and Karras with the constants of Vegdahl (Building a Better LK Hash, 2021): additions
/// and multiplications carry upwards only, which is all that is asked of it.
fn scramble_reversed(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The second Sobol dimension of `index`, most significant digit in bit 0. (The first, in this bit order, is `index` itself.)
///
/// Its generator matrix is Pascal's triangle modulo 2. By Lucas's theorem the entry (i, j) is odd exactly if the set bits of i are
/// among those of j, so the product is a sum over supersets, done in log2(32) steps (as Ahmed, An Implementation Algorithm of 2D Sobol
/// Sequence, EGSR 2024).
fn sobol_second_reversed(index: u32) -> u32 {
    let mut x = index;
    x ^= x >> 16;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^ (x & 0xaaaa_aaaa) >> 1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The direction numbers of the second dimension follow v -> v ^ v >> 1 from 0.1 (binary).
    #[test]
    fn second_dimension_follows_its_direction_numbers() {
        let by_directions = |index: u32| {
            let (mut direction, mut sum) = (1u32 << 31, 0);
            for bit in 0..32 {
                if index >> bit & 1 == 1 {
                    sum ^= direction;
                }
                direction ^= direction >> 1;
            }
            sum
        };
        for index in (0..100_000).step_by(7).chain([u32::MAX, 0x8000_0000, 0xdead_beef]) {
            assert_eq!(sobol_second_reversed(index).reverse_bits(), by_directions(index));
        }
    }

    #[test]
    fn scrambling_permutes_and_keeps_nesting() {
        for seed in [0, 1, 0x9e37_79b9, u32::MAX] {
            // Numbers that agree in the lowest k bits must agree in them afterwards, and differ where they first differed.
            for (a, bit) in (0..2000u32).zip((0..32).cycle()) {
                let a = a.wrapping_mul(0x85eb_ca6b);
                let b = a ^ (1 << bit);
                let difference = scramble_reversed(a, seed) ^ scramble_reversed(b, seed);
                assert_eq!(difference.trailing_zeros(), bit);
            }
        }
    }
}
