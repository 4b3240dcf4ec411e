//! [`Sampler`] for sixteen paths at once.

use super::sampler::{
    BLOCK_BITS, COLOUR, Counter, OF_PLACE, QUADS, SPREAD_DIMENSIONS, Sampler, SequenceKind, place_in_block,
};
use crate::math::PerLane;
use crate::math::lanes::{Lanes, WordLanes};

/// The samplers of sixteen paths with any pixels and indices.
#[derive(Clone, Debug)]
pub struct SamplerLanes {
    kind: SequenceKind,
    counter: Counter<WordLanes>,
}

impl SamplerLanes {
    /// The samplers of [`Sampler::new`] for the pixels (x, y) and sample indices of all lanes.
    pub(crate) fn of_pixels(kind: SequenceKind, [x, y]: [WordLanes; 2], index: WordLanes, seed: u32) -> Self {
        let [of_pixel, ..] = pcg3d([x, y, word(seed)]);
        let [_, of_block, _] = pcg3d([x >> BLOCK_BITS, y >> BLOCK_BITS, word(seed)]);
        let mut place = WordLanes::ZERO;
        for (lane, place) in place.as_mut_array().iter_mut().enumerate() {
            *place = place_in_block(x.as_array()[lane], y.as_array()[lane]);
        }
        Self {
            kind,
            counter: Counter {
                pixel: of_pixel,
                block: of_block,
                place,
                index: match kind {
                    SequenceKind::Independent => index,
                    SequenceKind::Sobol => reverse_bits(index),
                },
            },
        }
    }

    /// The numbers of [`Sampler::at_1d`] at these dimensions.
    #[inline(always)]
    pub fn at_1d(&self, dimension: WordLanes) -> Lanes {
        unit_floats(match self.kind {
            SequenceKind::Independent => self.hash(dimension)[0],
            SequenceKind::Sobol => {
                let (index, [seed, _]) = self.point(dimension);
                reverse_bits(scramble_reversed(index, seed))
            }
        })
    }

    /// The numbers of [`Sampler::at_2d`] at these dimensions.
    #[inline(always)]
    pub fn at_2d(&self, dimension: WordLanes) -> [Lanes; 2] {
        let [x, y] = match self.kind {
            SequenceKind::Independent => self.hash(dimension),
            SequenceKind::Sobol => {
                let (index, [seed_x, seed_y]) = self.point(dimension);
                [
                    reverse_bits(scramble_reversed(index, seed_x)),
                    reverse_bits(scramble_reversed(sobol_second_reversed(index), seed_y)),
                ]
            }
        };
        [unit_floats(x), unit_floats(y)]
    }

    #[inline(always)]
    fn hash(&self, dimension: WordLanes) -> [WordLanes; 2] {
        let counter = &self.counter;
        let [x, y, ..] = pcg4d([counter.pixel, counter.block, counter.index, dimension]);
        [x, y]
    }

    /// The index into the sequence, and the seeds of the scrambling of its two dimensions.
    #[inline(always)]
    fn point(&self, dimension: WordLanes) -> (WordLanes, [WordLanes; 2]) {
        let Counter {
            pixel,
            block,
            place,
            index,
        } = self.counter;
        let is_spread = dimension.simd_lt(word(SPREAD_DIMENSIONS));
        let sequence = (pixel & !is_spread) | (place & word(COLOUR) & is_spread);
        let [shuffle_seed, seed_x, seed_y] = pcg3d([sequence, block, dimension]);
        let mut index = reverse_bits(scramble_reversed(index, shuffle_seed));
        let seeds = [seed_x, seed_y];
        // Paths need it up to the first surface only.
        if is_spread.any() {
            let place = shuffle_quads(scramble_reversed(place, shuffle_seed), seeds) & is_spread;
            for (bit, &column) in OF_PLACE.iter().enumerate() {
                index ^= ((place >> bit as u32) & word(1)) * word(column);
            }
        }
        (index, seeds)
    }
}

/// The samplers of a batch are of one kind.
impl PerLane for Sampler {
    type Lanes = SamplerLanes;

    #[inline(always)]
    fn splat(self) -> SamplerLanes {
        let Counter {
            pixel,
            block,
            place,
            index,
        } = self.counter;
        SamplerLanes {
            kind: self.kind,
            counter: Counter {
                pixel: word(pixel),
                block: word(block),
                place: word(place),
                index: word(index),
            },
        }
    }

    #[inline(always)]
    fn gather_lane(lanes: &SamplerLanes, lane: usize) -> Self {
        let of_lane = |words: &WordLanes| words.as_array()[lane];
        Self {
            kind: lanes.kind,
            counter: Counter {
                pixel: of_lane(&lanes.counter.pixel),
                block: of_lane(&lanes.counter.block),
                place: of_lane(&lanes.counter.place),
                index: of_lane(&lanes.counter.index),
            },
        }
    }

    #[inline(always)]
    fn scatter_lane(self, lanes: &mut SamplerLanes, lane: usize) {
        debug_assert_eq!(self.kind, lanes.kind);
        let Counter {
            pixel,
            block,
            place,
            index,
        } = self.counter;
        let of_all = &mut lanes.counter;
        pixel.scatter_lane(&mut of_all.pixel, lane);
        block.scatter_lane(&mut of_all.block, lane);
        place.scatter_lane(&mut of_all.place, lane);
        index.scatter_lane(&mut of_all.index, lane);
    }
}

#[inline(always)]
fn reverse_bits(words: WordLanes) -> WordLanes {
    // Compilers turn this loop into one instruction.
    let mut words = words.to_array();
    for word in &mut words {
        *word = word.reverse_bits();
    }
    words.into()
}

#[inline(always)]
fn unit_floats(bits: WordLanes) -> Lanes {
    Lanes::from_i32x16(bytemuck::cast(bits >> 8)) * Lanes::splat(1.0 / (1 << 24) as f32)
}

#[inline(always)]
fn word(value: u32) -> WordLanes {
    WordLanes::splat(value)
}

#[inline(always)]
fn congruential(words: WordLanes) -> WordLanes {
    words * word(super::hash::MULTIPLIER) + word(super::hash::INCREMENT)
}

/// The hash [`super::hash::pcg3d`] in lanes.
#[inline(always)]
fn pcg3d(words: [WordLanes; 3]) -> [WordLanes; 3] {
    let multiply = |v: &mut [WordLanes; 3]| {
        v[0] += v[1] * v[2];
        v[1] += v[2] * v[0];
        v[2] += v[0] * v[1];
    };
    let mut v = words.map(congruential);
    multiply(&mut v);
    v = v.map(|word| word ^ (word >> 16));
    multiply(&mut v);
    v
}

/// The hash [`super::hash::pcg4d`] in lanes.
#[inline(always)]
fn pcg4d(words: [WordLanes; 4]) -> [WordLanes; 4] {
    let multiply = |v: &mut [WordLanes; 4]| {
        v[0] += v[1] * v[3];
        v[1] += v[2] * v[0];
        v[2] += v[0] * v[1];
        v[3] += v[1] * v[2];
    };
    let mut v = words.map(congruential);
    multiply(&mut v);
    v = v.map(|word| word ^ (word >> 16));
    multiply(&mut v);
    v
}

#[inline(always)]
fn scramble_reversed(mut x: WordLanes, seed: WordLanes) -> WordLanes {
    x ^= x * word(0x3d20_adea);
    x += seed;
    x *= (seed >> 16) | word(1);
    x ^= x * word(0x0552_6c56);
    x ^ (x * word(0x53a2_2864))
}

/// [`super::sampler`]'s function in lanes.
#[inline(always)]
fn shuffle_quads(place: WordLanes, seeds: [WordLanes; 2]) -> WordLanes {
    let (high, low) = (place & word(QUADS), (place >> 1) & word(QUADS));
    let both = high ^ low;
    let [a, b] = seeds.map(|seed| scramble_reversed(place, seed) ^ place);
    let (once, twice) = (a & !b, b & !a);
    let as_is = !(once | twice);
    let new_high = (high & as_is) | (low & once) | (both & twice);
    let new_low = (low & as_is) | (both & once) | (high & twice);
    new_high | (new_low << 1)
}

#[inline(always)]
fn sobol_second_reversed(index: WordLanes) -> WordLanes {
    let mut x = index;
    x ^= x >> 16;
    x ^= (x & word(0xff00_ff00)) >> 8;
    x ^= (x & word(0xf0f0_f0f0)) >> 4;
    x ^= (x & word(0xcccc_cccc)) >> 2;
    x ^ ((x & word(0xaaaa_aaaa)) >> 1)
}

#[cfg(test)]
mod tests {
    use glam::UVec2;

    use super::*;
    use crate::math::lanes::LANES;

    #[test]
    fn numbers_are_the_samplers() {
        for kind in [SequenceKind::Independent, SequenceKind::Sobol] {
            let pixel = |lane: u32| UVec2::new(17 * lane, 1000 - lane);
            let samplers: Vec<Sampler> = (0..LANES as u32)
                .map(|lane| Sampler::new(kind, pixel(lane), lane * lane, 5))
                .collect();
            let words = |of_lane: &dyn Fn(u32) -> u32| WordLanes::new(std::array::from_fn(|lane| of_lane(lane as u32)));
            let pixels = [words(&|lane| pixel(lane).x), words(&|lane| pixel(lane).y)];
            let begun = SamplerLanes::of_pixels(kind, pixels, words(&|lane| lane * lane), 5);
            let mut lanes = samplers[0].splat();
            for (lane, sampler) in samplers.iter().enumerate() {
                sampler.scatter_lane(&mut lanes, lane);
                assert_eq!(Sampler::gather_lane(&lanes, lane).counter, sampler.counter);
                assert_eq!(Sampler::gather_lane(&begun, lane).counter, sampler.counter);
            }
            for dimension in [0, 1, 2, 77, 12_345] {
                let dimensions: [u32; LANES] = std::array::from_fn(|lane| dimension + lane as u32);
                let (single, pair) = (lanes.at_1d(dimensions.into()), lanes.at_2d(dimensions.into()));
                for (lane, sampler) in samplers.iter().enumerate() {
                    assert_eq!(single.as_array()[lane], sampler.at_1d(dimensions[lane]));
                    let expected = sampler.at_2d(dimensions[lane]);
                    assert_eq!(pair.map(|numbers| numbers.as_array()[lane]), expected.to_array());
                }
            }
        }
    }
}
