//! A number per lane.

use glam::Vec3;

use super::{Mask, Real, Vector, Word};
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, WordLanes, copy_sign, each_lane};

impl Real for Lanes {
    type Mask = Lanes;
    type Word = WordLanes;
    type Vec3 = Vec3Lanes;

    const ZERO: Self = Lanes::ZERO;
    const ONE: Self = Lanes::ONE;
    const HALF: Self = Lanes::HALF;

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
    fn max(self, other: Self) -> Self {
        self.fast_max(other)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Lanes::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Lanes::sqrt(self)
    }

    #[inline(always)]
    fn copy_sign(self, sign: Self) -> Self {
        copy_sign(self, sign)
    }

    #[inline(always)]
    fn equals(self, other: Self) -> Lanes {
        self.simd_eq(other)
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> Lanes {
        self.simd_lt(other)
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> Lanes {
        self.simd_le(other)
    }

    #[inline(always)]
    fn select(condition: Lanes, yes: Self, no: Self) -> Self {
        condition.select(yes, no)
    }

    #[inline(always)]
    fn is_at_least(word: WordLanes, least: u32) -> Lanes {
        bytemuck::cast(word.simd_ge(WordLanes::splat(least)))
    }

    #[inline(always)]
    fn floor(self) -> Self {
        Lanes::floor(self)
    }

    #[inline(always)]
    fn whole(self) -> WordLanes {
        bytemuck::cast(self.fast_trunc_int())
    }

    #[inline(always)]
    fn of_whole(word: WordLanes) -> Self {
        Lanes::from_i32x16(bytemuck::cast(word))
    }

    #[inline(always)]
    fn to_bits(self) -> WordLanes {
        bytemuck::cast(self)
    }

    #[inline(always)]
    fn from_bits(bits: WordLanes) -> Self {
        bytemuck::cast(bits)
    }

    #[inline(always)]
    fn gather(places: WordLanes, look_up: impl Fn(usize) -> f32) -> Self {
        let mut found = [0.0; LANES];
        for (found, &place) in found.iter_mut().zip(places.as_array()) {
            *found = look_up(place as usize);
        }
        Lanes::new(found)
    }

    #[inline(always)]
    fn each<const N: usize, const M: usize>(
        condition: Lanes,
        numbers: [Lanes; N],
        function: impl Fn([f32; N]) -> [f32; M],
    ) -> [Lanes; M] {
        let mut found = [Lanes::ZERO; M];
        for lane in each_lane(condition.to_bitmask()) {
            let mut of_lane = [0.0; N];
            for (number, lanes) in of_lane.iter_mut().zip(&numbers) {
                *number = lanes.as_array()[lane];
            }
            for (lanes, number) in found.iter_mut().zip(function(of_lane)) {
                lanes.as_mut_array()[lane] = number;
            }
        }
        found
    }

    #[inline(always)]
    fn only(self, condition: Lanes) -> Self {
        self & condition
    }
}

impl Mask for Lanes {
    const NEVER: Self = Lanes::ZERO;
    // A NaN: all bits are set.
    const ALWAYS: Self = Lanes::new([f32::from_bits(u32::MAX); LANES]);

    #[inline(always)]
    fn any(self) -> bool {
        Lanes::any(self)
    }
}

impl Word for WordLanes {
    #[inline(always)]
    fn splat(value: u32) -> Self {
        WordLanes::splat(value)
    }

    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        self * other
    }
}

impl Vector<Lanes> for Vec3Lanes {
    #[inline(always)]
    fn of(x: Lanes, y: Lanes, z: Lanes) -> Self {
        Vec3Lanes::of(x, y, z)
    }

    #[inline(always)]
    fn same(v: Vec3) -> Self {
        Vec3Lanes::splat(v)
    }

    #[inline(always)]
    fn x(self) -> Lanes {
        self.x
    }

    #[inline(always)]
    fn y(self) -> Lanes {
        self.y
    }

    #[inline(always)]
    fn z(self) -> Lanes {
        self.z
    }

    #[inline(always)]
    fn dot(self, other: Self) -> Lanes {
        self.x.mul_add(other.x, self.y.mul_add(other.y, self.z * other.z))
    }

    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        Vec3Lanes::of(
            self.y.mul_sub(other.z, self.z * other.y),
            self.z.mul_sub(other.x, self.x * other.z),
            self.x.mul_sub(other.y, self.y * other.x),
        )
    }

    #[inline(always)]
    fn only(self, condition: Lanes) -> Self {
        self.map(|component| component & condition)
    }
}
