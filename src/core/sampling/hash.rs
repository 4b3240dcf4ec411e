//! Integer hashes of several words at once, the source of all randomness.
//!
//! `pcg3d` and `pcg4d` of Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 9(3), 2020: a linear congruential
//! step per word, then two rounds in which the words are multiplied into each other. Every output word depends on every
//! input word. Not for cryptography.

pub(super) const MULTIPLIER: u32 = 1_664_525;
pub(super) const INCREMENT: u32 = 1_013_904_223;

fn congruential(word: u32) -> u32 {
    word.wrapping_mul(MULTIPLIER).wrapping_add(INCREMENT)
}

/// Mixes three words into three.
pub fn pcg3d(words: [u32; 3]) -> [u32; 3] {
    let mut v = words.map(congruential);
    cross_multiply3(&mut v);
    v = v.map(|word| word ^ word >> 16);
    cross_multiply3(&mut v);
    v
}

/// Mixes four words into four.
pub fn pcg4d(words: [u32; 4]) -> [u32; 4] {
    let mut v = words.map(congruential);
    cross_multiply4(&mut v);
    v = v.map(|word| word ^ word >> 16);
    cross_multiply4(&mut v);
    v
}

fn cross_multiply3(v: &mut [u32; 3]) {
    v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[2]));
    v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
    v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
}

fn cross_multiply4(v: &mut [u32; 4]) {
    v[0] = v[0].wrapping_add(v[1].wrapping_mul(v[3]));
    v[1] = v[1].wrapping_add(v[2].wrapping_mul(v[0]));
    v[2] = v[2].wrapping_add(v[0].wrapping_mul(v[1]));
    v[3] = v[3].wrapping_add(v[1].wrapping_mul(v[2]));
}
