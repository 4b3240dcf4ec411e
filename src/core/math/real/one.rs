//! One number.

use glam::Vec3;

use super::{Mask, Real, Vector, Word};

impl Real for f32 {
    type Mask = bool;
    type Word = u32;
    type Vec3 = Vec3;

    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const HALF: Self = 0.5;

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
    fn max(self, other: Self) -> Self {
        f32::max(self, other)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }

    #[inline(always)]
    fn copy_sign(self, sign: Self) -> Self {
        f32::copysign(self, sign)
    }

    #[inline(always)]
    fn equals(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn select(condition: bool, yes: Self, no: Self) -> Self {
        if condition { yes } else { no }
    }

    #[inline(always)]
    fn is_at_least(word: u32, least: u32) -> bool {
        word >= least
    }

    #[inline(always)]
    fn floor(self) -> Self {
        f32::floor(self)
    }

    #[inline(always)]
    fn whole(self) -> u32 {
        self as u32
    }

    #[inline(always)]
    fn of_whole(word: u32) -> Self {
        word as f32
    }

    #[inline(always)]
    fn to_bits(self) -> u32 {
        f32::to_bits(self)
    }

    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        f32::from_bits(bits)
    }

    #[inline(always)]
    fn gather(place: u32, look_up: impl Fn(usize) -> f32) -> Self {
        look_up(place as usize)
    }

    #[inline(always)]
    fn each<const N: usize, const M: usize>(
        condition: bool,
        numbers: [f32; N],
        function: impl Fn([f32; N]) -> [f32; M],
    ) -> [f32; M] {
        if condition { function(numbers) } else { [0.0; M] }
    }
}

impl Mask for bool {
    const NEVER: Self = false;
    const ALWAYS: Self = true;

    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}

impl Word for u32 {
    #[inline(always)]
    fn splat(value: u32) -> Self {
        value
    }

    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        u32::wrapping_mul(self, other)
    }
}

impl Vector<f32> for Vec3 {
    #[inline(always)]
    fn of(x: f32, y: f32, z: f32) -> Self {
        Vec3::new(x, y, z)
    }

    #[inline(always)]
    fn same(v: Vec3) -> Self {
        v
    }

    #[inline(always)]
    fn x(self) -> f32 {
        self.x
    }

    #[inline(always)]
    fn y(self) -> f32 {
        self.y
    }

    #[inline(always)]
    fn z(self) -> f32 {
        self.z
    }
}
