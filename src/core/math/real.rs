//! The trait of numbers, single or one per lane, for formulas that are written once for both.
//!
//! One formula gives the same number in both forms up to rounding: `a b + c` is rounded once in lanes, where the
//! hardware does so, and twice in a single number. A formula takes every branch that some lane takes, and selects at
//! the end: `if condition.any()` skips a branch that no lane takes, and is an ordinary branch for a single number.

mod lanes;
mod one;

use std::fmt::Debug;
use std::ops::{Add, AddAssign, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

use glam::Vec3;

/// A number of either form: `f32` or `Lanes`.
pub trait Real:
    Copy
    + Debug
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
{
    /// A condition: `bool`, or one per lane as comparisons of `Lanes` give it.
    type Mask: Mask;
    /// A whole number.
    type Word: Word;
    /// A vector, or a colour.
    type Vec3: Vector<Self>;

    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// One half.
    const HALF: Self;

    /// The same value in every lane.
    fn splat(value: f32) -> Self;

    /// The sum `self a + b`, rounded once in lanes where the hardware does so.
    fn mul_add(self, a: Self, b: Self) -> Self;

    /// The smaller one; on x86 `other` where `self` is NaN. Where `other` is NaN the result is undefined.
    fn min(self, other: Self) -> Self;

    /// The larger one, as [`Self::min`] the smaller one.
    fn max(self, other: Self) -> Self;

    /// The number without its sign.
    fn abs(self) -> Self;

    /// The square root; NaN where `self` is negative.
    fn sqrt(self) -> Self;

    /// The number with the sign of `sign`.
    fn copy_sign(self, sign: Self) -> Self;

    /// A mask of where both are equal. NaN equals nothing.
    fn equals(self, other: Self) -> Self::Mask;

    /// A mask of where it is less than `other`.
    fn is_less(self, other: Self) -> Self::Mask;

    /// A mask of where it is `other` or less.
    fn is_at_most(self, other: Self) -> Self::Mask;

    /// A mask of where it is more than `other`.
    #[inline(always)]
    fn is_more(self, other: Self) -> Self::Mask {
        other.is_less(self)
    }

    /// Selects `yes` where `condition` holds, else `no`.
    fn select(condition: Self::Mask, yes: Self, no: Self) -> Self;

    /// A mask of where `value` is more than `limit`.
    #[inline(always)]
    fn is_above(value: Self, limit: f32) -> Self::Mask {
        value.is_more(Self::splat(limit))
    }

    /// A mask of where `word` is `least` or more.
    fn is_at_least(word: Self::Word, least: u32) -> Self::Mask;

    /// The largest whole number that is not above it. It must be in the range of `i32`.
    fn floor(self) -> Self;

    /// The whole part of a number from 0 to 2^24.
    fn whole(self) -> Self::Word;

    /// The number of a word below 2^24.
    fn of_whole(word: Self::Word) -> Self;

    /// The bits of the number.
    fn to_bits(self) -> Self::Word;

    /// The number of these bits.
    fn from_bits(bits: Self::Word) -> Self;

    /// Calls `look_up` with each index in turn, and returns the values.
    fn gather(places: Self::Word, look_up: impl Fn(usize) -> f32) -> Self;

    /// Calls a function of single numbers in each lane where `condition` holds, one after the other; the other lanes
    /// are zero.
    fn each<const N: usize, const M: usize>(
        condition: Self::Mask,
        numbers: [Self; N],
        function: impl Fn([f32; N]) -> [f32; M],
    ) -> [Self; M];

    /// The square.
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }

    /// The number limited to [0, 1].
    #[inline(always)]
    fn saturated(self) -> Self {
        self.max(Self::ZERO).min(Self::ONE)
    }

    /// Interpolates linearly from `self` at `t` = 0 to `other` at 1.
    #[inline(always)]
    fn mix(self, other: Self, t: Self) -> Self {
        t.mul_add(other - self, self)
    }

    /// The number where `condition` holds, else zero.
    #[inline(always)]
    fn only(self, condition: Self::Mask) -> Self {
        Self::select(condition, self, Self::ZERO)
    }
}

/// A condition of either form.
pub trait Mask: Copy + Debug + PartialEq + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// The condition that holds nowhere.
    const NEVER: Self;
    /// The condition that holds everywhere.
    const ALWAYS: Self;

    /// Whether it holds in any lane.
    fn any(self) -> bool;
}

/// A word of either form: `u32` or `WordLanes`.
pub trait Word:
    Copy
    + Debug
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    /// The same value in every lane.
    fn splat(value: u32) -> Self;

    /// The product modulo 2^32.
    fn wrapping_mul(self, other: Self) -> Self;
}

/// A vector or a colour of either form: [`Vec3`] or `Vec3Lanes`.
pub trait Vector<R: Real>:
    Copy
    + Debug
    + PartialEq
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<Output = Self>
    + Mul<R, Output = Self>
    + Div<Output = Self>
    + Div<R, Output = Self>
{
    /// The vector with these components.
    fn of(x: R, y: R, z: R) -> Self;

    /// The same vector in every lane.
    fn same(v: Vec3) -> Self;

    /// The first component.
    fn x(self) -> R;

    /// The second component.
    fn y(self) -> R;

    /// The third component.
    fn z(self) -> R;

    /// The vector whose components are all `value`.
    #[inline(always)]
    fn even(value: R) -> Self {
        Self::of(value, value, value)
    }

    /// The dot product.
    #[inline(always)]
    fn dot(self, other: Self) -> R {
        let (x, y) = (self.x() * other.x(), self.y() * other.y());
        self.z().mul_add(other.z(), x + y)
    }

    /// The cross product.
    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        Self::of(
            self.y() * other.z() - other.y() * self.z(),
            self.z() * other.x() - other.z() * self.x(),
            self.x() * other.y() - other.x() * self.y(),
        )
    }

    /// The squared length.
    #[inline(always)]
    fn length_squared(self) -> R {
        self.dot(self)
    }

    /// The vector scaled to unit length; not finite where it has no direction.
    #[inline(always)]
    fn normalize(self) -> Self {
        self * (R::ONE / self.length_squared().sqrt())
    }

    /// Applies `f` to each component.
    #[inline(always)]
    fn map(self, f: impl Fn(R) -> R) -> Self {
        Self::of(f(self.x()), f(self.y()), f(self.z()))
    }

    /// The sum of the components.
    #[inline(always)]
    fn sum(self) -> R {
        self.x() + self.y() + self.z()
    }

    /// The largest component.
    #[inline(always)]
    fn max_element(self) -> R {
        self.x().max(self.y()).max(self.z())
    }

    /// The sum `self + scale v`.
    #[inline(always)]
    fn plus_scaled(self, scale: R, v: Self) -> Self {
        Self::of(
            scale.mul_add(v.x(), self.x()),
            scale.mul_add(v.y(), self.y()),
            scale.mul_add(v.z(), self.z()),
        )
    }

    /// Interpolates linearly from `self` at `t` = 0 to `other` at 1.
    #[inline(always)]
    fn mix(self, other: Self, t: R) -> Self {
        self + (other - self) * t
    }

    /// Selects `yes` where `condition` holds, else `no`.
    #[inline(always)]
    fn select(condition: R::Mask, yes: Self, no: Self) -> Self {
        Self::of(
            R::select(condition, yes.x(), no.x()),
            R::select(condition, yes.y(), no.y()),
            R::select(condition, yes.z(), no.z()),
        )
    }

    /// The vector where `condition` holds, else zero.
    #[inline(always)]
    fn only(self, condition: R::Mask) -> Self {
        Self::select(condition, self, Self::even(R::ZERO))
    }

    /// The vector with these coordinates along three axes.
    #[inline(always)]
    fn along(self, [x, y, z]: [Vec3; 3]) -> Self {
        Self::same(x) * self.x() + Self::same(y) * self.y() + Self::same(z) * self.z()
    }

    /// The coordinates of the vector along three orthonormal axes.
    #[inline(always)]
    fn coordinates(self, axes: [Vec3; 3]) -> Self {
        let [x, y, z] = axes.map(|axis| self.dot(Self::same(axis)));
        Self::of(x, y, z)
    }

    /// The mirror image about the third axis.
    #[inline(always)]
    fn mirrored(self) -> Self {
        Self::of(-self.x(), -self.y(), self.z())
    }

    /// The vector with another third component.
    #[inline(always)]
    fn with_third(self, z: R) -> Self {
        Self::of(self.x(), self.y(), z)
    }
}
