//! Random numbers of the cells of a lattice.

use crate::math::{Real, Word};

/// A random word for a cell, by the whole numbers of its corner.
///
/// The bits of the numbers are stirred by multiplications and shifts as in the finalizer of MurmurHash3 (Appleby 2011).
#[inline(always)]
pub(super) fn hash<R: Real>([x, y]: [R; 2], seed: u32) -> R::Word {
    // The sum with 0 turns -0 into 0, which is the same cell.
    let [x, y] = [x + R::ZERO, y + R::ZERO].map(R::to_bits);
    let stirred = stir::<R>(x ^ R::Word::splat(seed.wrapping_mul(0x9e37_79b9)));
    stir::<R>(stirred ^ y.wrapping_mul(R::Word::splat(0x9e37_79b9)))
}

#[inline(always)]
fn stir<R: Real>(word: R::Word) -> R::Word {
    let word = (word ^ (word >> 16)).wrapping_mul(R::Word::splat(0x85eb_ca6b));
    let word = (word ^ (word >> 13)).wrapping_mul(R::Word::splat(0xc2b2_ae35));
    word ^ (word >> 16)
}

/// The upper 24 bits of a word as a number in [0, 1).
#[inline(always)]
pub(super) fn unit<R: Real>(word: R::Word) -> R {
    R::of_whole(word >> 8) * R::splat(1.0 / 16_777_216.0)
}

/// Two random numbers in [0, 1) for a cell.
#[inline(always)]
pub(super) fn pair<R: Real>(cell: [R; 2], seed: u32) -> [R; 2] {
    let word = hash(cell, seed);
    [
        unit::<R>(word),
        unit::<R>(stir::<R>(word ^ R::Word::splat(0x5bd1_e995))),
    ]
}
