//! The counter-based sampler: numbers as a pure function of (pixel, sample index, dimension, seed).
//!
//! `Independent` is white noise. `Sobol` is the first two dimensions of the Sobol sequence with hashed Owen scrambling,
//! padded: every draw is a differently scrambled and differently shuffled copy of the same good 2D sequence (Burley,
//! Practical Hash-based Owen Scrambling, JCGT 9(4), 2020), so there is no limit on dimensions and no correlation
//! between draws. Within one draw the first 2^k samples of a pixel form a (0, k, 2)-net. In the first few draws, for
//! the camera and the first surface, nearby pixels share a sequence and take complementary parts of it, so that their
//! errors differ in sign and cancel in the eye or in a blurred picture (Ahmed and Wonka, Screen-space blue-noise
//! diffusion of Monte Carlo sampling error via hierarchical ordering of pixels, 2020; there for one known number of
//! samples, here for any). Sharing is among pixel quads of one colour of a chess board: quads that share an edge are
//! independent, because adaptive sampling uses one to decide about the other. In later draws all pixels are
//! independent.

use super::{
    hash::{pcg3d, pcg4d},
    unit_float,
};
use glam::{UVec2, Vec2};

/// The kind of numbers of a [`Sampler`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SequenceKind {
    /// White noise.
    Independent,
    /// Owen-scrambled Sobol points, padded and shuffled per draw: less noise for the same count.
    #[default]
    Sobol,
}

/// The dimensions below which draws are spread over neighbouring pixels as well.
pub(crate) const SPREAD_DIMENSIONS: u32 = 7;

/// The logarithm of the edge of a block of pixels that share two sequences for these draws.
pub(super) const BLOCK_BITS: u32 = 4;

/// The bit of a pixel's place in its block that holds the colour of its quad.
pub(crate) const COLOUR: u32 = 1;

/// A mask of the higher bit of each pair of bits of a place: one pair for the place in a quad of pixels, one for that
/// quad in a larger one, and so on.
pub(super) const QUADS: u32 = 0x55;

/// The generator matrix from the bits of a pixel's place to the index into the sequence. (With t = 0 throughout, index,
/// place, x and y would be nets in four dimensions, which base 2 does not have.) Found by a random search for small t,
/// where few samples have more weight.
pub(super) const OF_PLACE: [u32; 2 * BLOCK_BITS as usize] = [
    0xf4d372, 0x194c6b, 0xebcd64, 0x6500de, 0xb61727, 0x6d3e1e, 0x0a1176, 0xbe79db,
];

/// The numbers of one sample of one pixel.
///
/// A "dimension" is one draw, of one number or of a pair. Draws of different dimensions are independent of each other;
/// a number and a pair of the same dimension are not.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    pub(super) kind: SequenceKind,
    pub(super) counter: Counter<u32>,
}

/// The hashes from which, with a dimension, the seeds of a sample's numbers follow: for one sample, or one per lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counter<Word> {
    /// A hash of the pixel and the seed, and one of the pixel's block and the seed.
    pub pixel: Word,
    pub block: Word,
    /// The place of the pixel, see [`place_in_block`].
    pub place: Word,
    /// The sample index; with its bits reversed for `Sobol`, as the shuffle needs it.
    pub index: Word,
}

/// A pixel's number within its block, in reversed bit order: the lowest bit is the colour of the pixel's quad on a
/// chess board of quads, and the others follow a Morton curve through the quads of that colour, whose row within four
/// pixels follows from the column.
pub(crate) fn place_in_block(x: u32, y: u32) -> u32 {
    let colour = (x ^ y) >> 1 & 1;
    let bits = |of: u32| {
        let quad = |bit: u32| (of >> bit & 1) << (2 * (BLOCK_BITS - 1 - bit));
        (0..BLOCK_BITS).map(quad).sum::<u32>()
    };
    let row = y & 1 | y >> 1 & 0b110 | colour << (BLOCK_BITS - 1);
    bits(row) | bits(x) << 1
}

impl Sampler {
    /// The sampler of sample `sample_index` of `pixel`. All seeds are equally good.
    pub fn new(kind: SequenceKind, pixel: UVec2, sample_index: u32, seed: u32) -> Self {
        let [of_pixel, ..] = pcg3d([pixel.x, pixel.y, seed]);
        let [_, of_block, _] = pcg3d([pixel.x >> BLOCK_BITS, pixel.y >> BLOCK_BITS, seed]);
        Self {
            kind,
            counter: Counter {
                pixel: of_pixel,
                block: of_block,
                place: place_in_block(pixel.x, pixel.y),
                index: match kind {
                    SequenceKind::Independent => sample_index,
                    SequenceKind::Sobol => sample_index.reverse_bits(),
                },
            },
        }
    }

    /// The number of a dimension, in [0, 1).
    pub fn at_1d(&self, dimension: u32) -> f32 {
        unit_float(match self.kind {
            SequenceKind::Independent => self.hash(dimension)[0],
            SequenceKind::Sobol => {
                let (index, [seed, _]) = self.point(dimension);
                scramble_reversed(index, seed).reverse_bits()
            }
        })
    }

    /// The pair of numbers of a dimension, each in [0, 1).
    pub fn at_2d(&self, dimension: u32) -> Vec2 {
        let [x, y] = match self.kind {
            SequenceKind::Independent => self.hash(dimension),
            SequenceKind::Sobol => {
                let (index, [seed_x, seed_y]) = self.point(dimension);
                [
                    scramble_reversed(index, seed_x).reverse_bits(),
                    scramble_reversed(sobol_second_reversed(index), seed_y).reverse_bits(),
                ]
            }
        };
        Vec2::new(unit_float(x), unit_float(y))
    }

    fn hash(&self, dimension: u32) -> [u32; 2] {
        let Counter {
            pixel, block, index, ..
        } = self.counter;
        let [x, y, ..] = pcg4d([pixel, block, index, dimension]);
        [x, y]
    }

    /// The index into the sequence, and the seeds of the scrambling of its two dimensions.
    fn point(&self, dimension: u32) -> (u32, [u32; 2]) {
        let Counter {
            pixel,
            block,
            place,
            index,
        } = self.counter;
        let is_spread = dimension < SPREAD_DIMENSIONS;
        let sequence = if is_spread { place & COLOUR } else { pixel };
        let [shuffle_seed, seed_x, seed_y] = pcg3d([sequence, block, dimension]);
        let seeds = [seed_x, seed_y];
        let mut index = scramble_reversed(index, shuffle_seed).reverse_bits();
        if is_spread {
            let place = shuffle_quads(scramble_reversed(place, shuffle_seed), seeds);
            for (bit, &column) in OF_PLACE.iter().enumerate() {
                index ^= (place >> bit & 1) * column;
            }
        }
        (index, seeds)
    }
}

/// Nested uniform (Owen) scrambling in base 2 of a number whose most significant digit is bit 0: each bit is flipped by
/// a hash of the bits below it and the seed. The hash of Laine and Karras with the constants of Vegdahl (Building a
/// Better LK Hash, 2021): additions and multiplications carry upwards only, as Owen scrambling requires.
fn scramble_reversed(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Permutes the places within each quad: the two pairs among its four pixels differ from draw to draw, since the errors
/// of two draws with the same pairs would add up. The permutation of a quad depends on the larger quads around it, to
/// avoid stripes. (All 24 orders: Ahmed and Wonka 2020. Here the twelve even ones, with the scrambling before.)
fn shuffle_quads(place: u32, seeds: [u32; 2]) -> u32 {
    let (high, low) = (place & QUADS, place >> 1 & QUADS);
    let both = high ^ low;
    let [a, b] = seeds.map(|seed| scramble_reversed(place, seed) ^ place);
    let (once, twice) = (a & !b, b & !a);
    let as_is = !(once | twice);
    let new_high = (high & as_is) | (low & once) | (both & twice);
    let new_low = (low & as_is) | (both & once) | (high & twice);
    new_high | new_low << 1
}

/// The second Sobol dimension of `index`, most significant digit in bit 0. (The first, in this bit order, is `index`
/// itself.)
///
/// Its generator matrix is Pascal's triangle modulo 2. By Lucas's theorem the entry (i, j) is odd exactly if the set
/// bits of i are among those of j, so the product is a sum over supersets, done in log2(32) steps (as Ahmed, An
/// Implementation Algorithm of 2D Sobol Sequence, EGSR 2024).
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
            // Numbers that agree in the lowest k bits must agree in them afterwards, and differ where they first
            // differed.
            for (a, bit) in (0..2000u32).zip((0..32).cycle()) {
                let a = a.wrapping_mul(0x85eb_ca6b);
                let b = a ^ (1 << bit);
                let difference = scramble_reversed(a, seed) ^ scramble_reversed(b, seed);
                assert_eq!(difference.trailing_zeros(), bit);
            }
        }
    }
}
