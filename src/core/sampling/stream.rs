//! Random numbers for loops with an unknown number of draws.

use super::hash::pcg4d;
use super::sampler::Sampler;
use super::unit_float;

/// A stream of independent numbers that belongs to one draw of a sample (PCG-XSH-RR of O'Neill 2014, 64 bits of state).
#[derive(Clone, Debug)]
pub struct RandomStream {
    state: u64,
}

impl RandomStream {
    /// The next number, in [0, 1).
    #[inline]
    pub fn draw(&mut self) -> f32 {
        let state = self.state;
        self.state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let mixed = (((state >> 18) ^ state) >> 27) as u32;
        unit_float(mixed.rotate_right((state >> 59) as u32))
    }
}

impl Sampler {
    /// The stream of a dimension. It is independent of the number and of the pair of any dimension, its own included.
    pub fn stream(&self, dimension: u32) -> RandomStream {
        const OF_STREAMS: u32 = 0x5bd1_e995;
        let [a, b, ..] = pcg4d([
            self.counter.pixel ^ OF_STREAMS,
            self.counter.block,
            self.counter.index,
            dimension,
        ]);
        RandomStream {
            state: u64::from(a) << 32 | u64::from(b),
        }
    }
}
