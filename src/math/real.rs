//! A number, or a number per lane, for formulas that are written once for both.
//!
//! One formula gives the same number in both forms but for rounding: `a b + c` is rounded once in lanes, where the hardware does so, and
//! twice in a single number.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Not, Sub};

use super::lanes::{Lanes, WordLanes};

/// A number of either form: `f32` or [`Lanes`].
pub trait Real: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// A condition: `bool`, or one per lane as comparisons of [`Lanes`] give it.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask> + Not<Output = Self::Mask>;
    /// A whole number.
    type Word: Word;

    /// The same value in every lane.
    fn splat(value: f32) -> Self;

    /// The fused `self a + b`.
    fn mul_add(self, a: Self, b: Self) -> Self;

    /// The smaller one; `other` where `self` is no number.
    fn min(self, other: Self) -> Self;

    /// A mask of where both are equal, which no number that is NaN is.
    fn equals(self, other: Self) -> Self::Mask;

    /// Selects `yes` where `condition` holds, else `no`.
    fn select(condition: Self::Mask, yes: Self, no: Self) -> Self;

    /// A mask of where `value` is more than `limit`.
    fn is_above(value: Self, limit: f32) -> Self::Mask;

    /// A mask of where `word` is `least` or more.
    fn is_at_least(word: Self::Word, least: u32) -> Self::Mask;
}

/// A word of either form: `u32` or [`WordLanes`].
pub trait Word: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// The same value in every lane.
    fn splat(value: u32) -> Self;
}

impl Real for f32 {
    type Mask = bool;
    type Word = u32;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        f32::min(self, other)
    }

    #[inline(always)]
    fn equals(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn select(condition: bool, yes: Self, no: Self) -> Self {
        if condition { yes } else { no }
    }

    #[inline(always)]
    fn is_above(value: Self, limit: f32) -> bool {
        value > limit
    }

    #[inline(always)]
    fn is_at_least(word: u32, least: u32) -> bool {
        word >= least
    }
}

impl Real for Lanes {
    type Mask = Lanes;
    type Word = WordLanes;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Lanes::splat(value)
    }

    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Lanes::mul_add(self, a, b)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.fast_min(other)
    }

    #[inline(always)]
    fn equals(self, other: Self) -> Lanes {
        self.simd_eq(other)
    }

    #[inline(always)]
    fn select(condition: Lanes, yes: Self, no: Self) -> Self {
        condition.select(yes, no)
    }

    #[inline(always)]
    fn is_above(value: Self, limit: f32) -> Lanes {
        value.simd_gt(Lanes::splat(limit))
    }

    #[inline(always)]
    fn is_at_least(word: WordLanes, least: u32) -> Lanes {
        bytemuck::cast(word.simd_ge(WordLanes::splat(least)))
    }
}

impl Word for u32 {
    #[inline(always)]
    fn splat(value: u32) -> Self {
        value
    }
}

impl Word for WordLanes {
    #[inline(always)]
    fn splat(value: u32) -> Self {
        WordLanes::splat(value)
    }
}
