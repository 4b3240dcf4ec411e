//! Random numbers that are the same in every run: all decisions of the monkey come from one seed.

/// The generator xorshift64 (Marsaglia 2003, "Xorshift RNGs").
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A generator with any seed. Zero, which the generator could not leave, becomes another number.
    pub fn new(seed: u64) -> Self {
        // Neighbouring seeds start far from each other (the finaliser of SplitMix64, Steele et al. 2014).
        let mut state = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self((state ^ (state >> 31)).max(1))
    }

    /// A number from 0 to `bound` - 1. `bound` must not be zero.
    pub fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 16) % bound as u64) as usize
    }

    /// A random element; None if the list is empty.
    pub fn one_of<'a, T>(&mut self, list: &'a [T]) -> Option<&'a T> {
        (!list.is_empty()).then(|| &list[self.below(list.len())])
    }

    /// A number from -10 to 10 in steps of 0.01.
    pub fn number(&mut self) -> f32 {
        self.below(2001) as f32 * 0.01 - 10.0
    }

    /// A number from 0 to 1 in steps of 0.01.
    pub(crate) fn fraction(&mut self) -> f32 {
        self.below(101) as f32 * 0.01
    }

    /// Three numbers as a script writes them.
    pub(crate) fn vector(&mut self) -> String {
        format!("{},{},{}", self.number(), self.number(), self.number())
    }
}
