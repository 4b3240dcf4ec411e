//! Sixteen numbers, vectors or conditions side by side, for code that processes sixteen paths at once.
//!
//! A condition is a number per lane whose bits are all set or all clear, as the results of comparisons are, or a bit
//! per lane in a `u32`.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use glam::Vec3;
use wide::{f32x16, u32x16};

use super::real::Vector;

/// The number of lanes.
pub const LANES: usize = 16;

/// A number per lane.
pub type Lanes = f32x16;

/// A word per lane.
pub type WordLanes = u32x16;

/// A vector per lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec3Lanes {
    /// The first components.
    pub x: Lanes,
    /// The second components.
    pub y: Lanes,
    /// The third components.
    pub z: Lanes,
}

/// Asserts the contract of masks: no bit is set beyond the lanes.
#[inline(always)]
fn check_mask(bits: u32) {
    debug_assert!(bits >> LANES == 0, "the mask {bits:#x} has bits beyond {LANES} lanes");
}

/// The condition that holds in the lanes whose bit is set.
#[inline(always)]
pub(crate) fn lanes_of(bits: u32) -> Lanes {
    const BIT_OF_LANE: WordLanes = WordLanes::new([
        1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768,
    ]);
    check_mask(bits);
    bytemuck::cast((WordLanes::splat(bits) & BIT_OF_LANE).simd_eq(BIT_OF_LANE))
}

/// One in the lanes whose bit is set, else zero.
#[inline(always)]
pub(crate) fn ones_in(bits: u32) -> WordLanes {
    WordLanes::splat(1) & bytemuck::cast::<_, WordLanes>(lanes_of(bits))
}

/// The lanes whose bit is set, in order.
#[inline(always)]
pub(crate) fn each_lane(mut bits: u32) -> impl Iterator<Item = usize> {
    check_mask(bits);
    std::iter::from_fn(move || {
        let lane = (bits != 0).then(|| bits.trailing_zeros() as usize % LANES);
        bits &= bits.wrapping_sub(1);
        lane
    })
}

/// The number `magnitude` with the sign of `sign`.
#[inline(always)]
pub(crate) fn copy_sign(magnitude: Lanes, sign: Lanes) -> Lanes {
    let sign_bit = Lanes::splat(-0.0);
    (magnitude & !sign_bit) | (sign & sign_bit)
}

impl Vec3Lanes {
    /// The zero vector in every lane.
    pub const ZERO: Self = Self::of(Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);

    /// The vectors with these components.
    #[inline(always)]
    pub const fn of(x: Lanes, y: Lanes, z: Lanes) -> Self {
        Self { x, y, z }
    }

    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(v: Vec3) -> Self {
        Self::of(Lanes::splat(v.x), Lanes::splat(v.y), Lanes::splat(v.z))
    }

    /// Returns the vector of a lane below [`LANES`].
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(
            self.x.as_array()[lane],
            self.y.as_array()[lane],
            self.z.as_array()[lane],
        )
    }

    /// Replaces the vector of a lane below [`LANES`].
    #[inline(always)]
    pub fn set(&mut self, lane: usize, v: Vec3) {
        self.x.as_mut_array()[lane] = v.x;
        self.y.as_mut_array()[lane] = v.y;
        self.z.as_mut_array()[lane] = v.z;
    }

    /// The components without their signs.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self::of(self.x.abs(), self.y.abs(), self.z.abs())
    }

    /// A mask of the lanes that are not the zero vector; NaN counts as not zero.
    #[inline(always)]
    pub(crate) fn is_not_zero(self) -> Lanes {
        let zero = Lanes::ZERO;
        self.x.simd_ne(zero) | self.y.simd_ne(zero) | self.z.simd_ne(zero)
    }
}

impl Add for Vec3Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::of(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl AddAssign for Vec3Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sub for Vec3Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::of(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl Neg for Vec3Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

/// Multiplies component by component.
impl Mul for Vec3Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::of(self.x * other.x, self.y * other.y, self.z * other.z)
    }
}

impl Mul<Lanes> for Vec3Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, scale: Lanes) -> Self {
        Self::of(self.x * scale, self.y * scale, self.z * scale)
    }
}

/// Multiplies by the reciprocal, so that the quotient is not correctly rounded.
impl Div<Lanes> for Vec3Lanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: Lanes) -> Self {
        self * (Lanes::ONE / divisor)
    }
}

/// Divides component by component.
impl Div for Vec3Lanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: Self) -> Self {
        Self::of(self.x / divisor.x, self.y / divisor.y, self.z / divisor.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Frame, offset_origin};

    fn vectors(seed: u32) -> [Vec3; LANES] {
        std::array::from_fn(|lane| {
            let k = seed + 7 * lane as u32;
            let part = |factor: f32| (k as f32 * factor).fract() * 2.0 - 1.0;
            Vec3::new(part(0.754_878), part(0.569_84), part(0.311_7))
        })
    }

    fn lanes(vectors: &[Vec3; LANES]) -> Vec3Lanes {
        let mut lanes = Vec3Lanes::ZERO;
        vectors.iter().enumerate().for_each(|(lane, &v)| lanes.set(lane, v));
        lanes
    }

    #[test]
    fn bits_and_lanes_are_the_same_condition() {
        for bits in [0, 1, 0x8000, 0xffff, 0x5a5a] {
            assert_eq!(lanes_of(bits).to_bitmask(), bits);
            assert_eq!(each_lane(bits).map(|lane| 1 << lane).sum::<u32>(), bits);
        }
    }

    #[test]
    fn frames_and_offsets_are_those_of_one() {
        for seed in 0..200 {
            let normals = vectors(seed).map(Vec3::normalize);
            let (positions, dirs) = (vectors(seed + 1000).map(|v| 10.0 * v), vectors(seed + 2000));
            let frame = Frame::<Lanes>::around(lanes(&normals));
            let local = frame.to_local(lanes(&dirs));
            let world = frame.to_world(lanes(&dirs));
            let moved = offset_origin(lanes(&positions), Lanes::splat(1e-6), lanes(&normals), lanes(&dirs));
            for lane in 0..LANES {
                let expected = Frame::from_normal(normals[lane]);
                assert!(local.get(lane).abs_diff_eq(expected.to_local(dirs[lane]), 1e-6));
                assert!(world.get(lane).abs_diff_eq(expected.to_world(dirs[lane]), 1e-6));
                let expected = offset_origin(positions[lane], 1e-6, normals[lane], dirs[lane]);
                // A few steps of the last digit of 10.
                assert!(
                    moved.get(lane).abs_diff_eq(expected, 4e-6),
                    "{} {expected}",
                    moved.get(lane)
                );
                let side = dirs[lane].dot(normals[lane]).signum();
                assert!((moved.get(lane) - positions[lane]).dot(normals[lane]) * side > 0.0);
            }
        }
    }
}
