//! The bins of a histogram over directions, about the axis nearest to a surface's normal.
//!
//! A direction is projected to the octahedron; each half of that, above and below the axis' plane, is a square of bins
//! whose sides are parallel to the square's, so that no bin is on both sides. Bins differ in solid angle, which their
//! densities account for.

use glam::Vec3;

use crate::math::Vector;
use crate::math::lanes::{Lanes, Vec3Lanes, WordLanes, copy_sign};

/// The bins along each side of a half.
pub(in crate::render) const SIDE: usize = 8;
/// The bins of both halves.
pub(in crate::render) const BINS: usize = 2 * SIDE * SIDE;

/// The axis of a direction's largest component: 2 axis if it points along the axis, or 2 axis + 1 if against it.
pub(super) fn axis_of(normal: Vec3) -> usize {
    let size = normal.abs();
    let axis = match () {
        _ if size.x > size.y && size.x > size.z => 0,
        _ if size.y > size.z => 1,
        _ => 2,
    };
    2 * axis + usize::from(normal[axis] < 0.0)
}

/// The axes of sixteen normals as [`axis_of`] finds them.
#[derive(Clone, Copy)]
pub(in crate::render) struct BinLanes {
    is_x: Lanes,
    is_y: Lanes,
    sign: Lanes,
}

impl BinLanes {
    #[inline(always)]
    pub fn of(normal: Vec3Lanes) -> Self {
        let size = normal.abs();
        let is_x = size.x.simd_gt(size.y) & size.x.simd_gt(size.z);
        let is_y = size.y.simd_gt(size.z) & !is_x;
        let along = is_x.select(normal.x, is_y.select(normal.y, normal.z));
        Self {
            is_x,
            is_y,
            sign: copy_sign(Lanes::ONE, along),
        }
    }

    /// The numbers of the axes.
    #[inline(always)]
    pub fn axes(&self) -> WordLanes {
        let negative = self.sign.simd_lt(Lanes::ZERO);
        let word = |value: u32, mask: Lanes| WordLanes::splat(value) & bytemuck::cast::<_, WordLanes>(mask);
        word(2, self.is_y) + word(4, !(self.is_x | self.is_y)) + word(1, negative)
    }

    /// Transforms directions to the frames of the axes.
    #[inline(always)]
    fn to_axis(self, d: Vec3Lanes) -> Vec3Lanes {
        let pick = |x: Lanes, y: Lanes, z: Lanes| self.is_x.select(x, self.is_y.select(y, z));
        Vec3Lanes::of(
            pick(d.y, d.z, d.x),
            pick(d.z, d.x, d.y),
            pick(d.x, d.y, d.z) * self.sign,
        )
    }

    /// Transforms directions from the frames of the axes to world space.
    #[inline(always)]
    fn to_world(self, d: Vec3Lanes) -> Vec3Lanes {
        let pick = |x: Lanes, y: Lanes, z: Lanes| self.is_x.select(x, self.is_y.select(y, z));
        let z = d.z * self.sign;
        Vec3Lanes::of(pick(z, d.y, d.x), pick(d.x, z, d.y), pick(d.y, d.x, z))
    }

    /// The bins of directions, and the density per solid angle of a uniform point within each bin.
    #[inline(always)]
    pub fn find(&self, dir: Vec3Lanes) -> (WordLanes, Lanes) {
        let d = self.to_axis(dir);
        let size = d.abs();
        let r = Lanes::ONE / (size.x + size.y + size.z);
        let half = Lanes::splat(0.5 * SIDE as f32);
        let last = Lanes::splat(SIDE as f32 - 1.0);
        let place = |sum: Lanes| {
            (sum * r)
                .mul_add(half, half)
                .fast_max(Lanes::ZERO)
                .trunc()
                .fast_min(last)
        };
        let (u, v) = (place(d.x + d.y), place(d.x - d.y));
        let below = d.z.simd_lt(Lanes::ZERO) & Lanes::splat((SIDE * SIDE) as f32);
        let bin = v.mul_add(Lanes::splat(SIDE as f32), u) + below;
        let density = Lanes::splat((SIDE * SIDE) as f32 * 0.5) * r * r * r;
        (bytemuck::cast(bin.fast_trunc_int()), density)
    }

    /// Directions at the positions `x` and `y` within bins, in world space.
    #[inline(always)]
    pub fn direction(&self, bin: Lanes, x: Lanes, y: Lanes) -> Vec3Lanes {
        let half = Lanes::splat((SIDE * SIDE) as f32);
        let is_below = bin.simd_ge(half);
        let bin = bin - (half & is_below);
        let row = ((bin + Lanes::splat(0.5)) * Lanes::splat(1.0 / SIDE as f32)).trunc();
        let column = row.mul_neg_add(Lanes::splat(SIDE as f32), bin);
        let scale = Lanes::splat(1.0 / SIDE as f32);
        // Half of u and v, which go from -1 to 1.
        let place = |number: Lanes| number.mul_sub(scale, Lanes::splat(0.5));
        let (u, v) = (place(column + x), place(row + y));
        let (px, py) = (u + v, u - v);
        let pz = (Lanes::ONE - px.abs() - py.abs()).fast_max(Lanes::ZERO);
        let pz = is_below.select(-pz, pz);
        self.to_world(Vec3Lanes::of(px, py, pz).normalize())
    }
}

/// The bin of a direction about the axis with this number.
pub(super) fn bin_of(axis: usize, dir: Vec3) -> usize {
    let mut normal = Vec3::ZERO;
    normal[axis / 2] = if axis.is_multiple_of(2) { 1.0 } else { -1.0 };
    let (bin, _) = BinLanes::of(Vec3Lanes::splat(normal)).find(Vec3Lanes::splat(dir));
    (bin.as_array()[0] as usize).min(BINS - 1)
}

/// The share of each bin in a density that follows the cosine with the axis.
pub(super) fn cosine_shares() -> [f32; BINS] {
    const PLACES: usize = 16;
    let mut shares = [0.0; BINS];
    let axis = BinLanes::of(Vec3Lanes::splat(Vec3::Z));
    for (bin, share) in shares.iter_mut().enumerate() {
        let mut sum = 0.0;
        for x in 0..PLACES {
            for y in 0..PLACES {
                let place = |k: usize| Lanes::splat((k as f32 + 0.5) / PLACES as f32);
                let dir = axis.direction(Lanes::splat(bin as f32), place(x), place(y));
                let (_, density) = axis.find(dir);
                sum += dir.z.as_array()[0].max(0.0) * std::f32::consts::FRAC_1_PI / density.as_array()[0];
            }
        }
        *share = sum / (PLACES * PLACES) as f32;
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::LANES;
    use crate::sampling::hash::pcg3d;

    const NORMALS: [Vec3; 6] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];

    fn number(word: u32) -> f32 {
        (word >> 8) as f32 / (1 << 24) as f32
    }

    #[test]
    fn axes_are_those_of_one() {
        for (axis, normal) in NORMALS.into_iter().enumerate() {
            let tilted = (normal + 0.4 * Vec3::new(0.3, -0.7, 0.5)).normalize();
            for normal in [normal, tilted] {
                assert_eq!(axis_of(normal), axis);
                let lanes = BinLanes::of(Vec3Lanes::splat(normal)).axes();
                assert_eq!(lanes.as_array(), &[axis as u32; LANES]);
            }
        }
    }

    #[test]
    fn places_in_a_bin_are_found_in_it() {
        for (axis, normal) in NORMALS.into_iter().enumerate() {
            let about = BinLanes::of(Vec3Lanes::splat(normal));
            for bin in 0..BINS {
                for place in 0..4 {
                    let inner = |shift: u32| {
                        let [x, ..] = pcg3d([bin as u32, place, shift]);
                        Lanes::splat(0.01 + 0.98 * number(x))
                    };
                    let dir = about.direction(Lanes::splat(bin as f32), inner(0), inner(1));
                    assert_eq!(about.find(dir).0.as_array()[0] as usize, bin);
                    let dir = dir.get(0);
                    assert_eq!(bin_of(axis, dir), bin);
                    assert!((dir.length() - 1.0).abs() < 1e-5);
                    assert_eq!(dir.dot(normal) > 0.0, bin < BINS / 2, "{bin} {dir}");
                }
            }
        }
    }

    #[test]
    fn densities_are_one_in_each_bin() {
        const COUNT: u32 = 400_000;
        let about = BinLanes::of(Vec3Lanes::splat(Vec3::NEG_Y));
        let mut sums = [0.0; BINS];
        for start in (0..COUNT).step_by(LANES) {
            let mut dirs = Vec3Lanes::ZERO;
            for lane in 0..LANES {
                let [x, y, _] = pcg3d([start + lane as u32, 3, 5]).map(number);
                let (z, turn) = (1.0 - 2.0 * x, std::f32::consts::TAU * y);
                let across = (1.0 - z * z).max(0.0).sqrt();
                dirs.set(lane, Vec3::new(across * turn.cos(), across * turn.sin(), z));
            }
            let (bins, densities) = about.find(dirs);
            for (&bin, &density) in bins.as_array().iter().zip(densities.as_array()) {
                sums[bin as usize] += f64::from(density) * 4.0 * std::f64::consts::PI / f64::from(COUNT);
            }
        }
        // Some thousands of directions in each.
        assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 0.1), "{sums:?}");
        let all = sums.iter().sum::<f64>() / BINS as f64;
        assert!((all - 1.0).abs() < 0.005, "{all}");
    }

    #[test]
    fn the_cosine_is_in_the_upper_half() {
        let shares = cosine_shares();
        assert!((shares.iter().sum::<f32>() - 1.0).abs() < 1e-3);
        assert!(shares[BINS / 2..].iter().all(|&share| share == 0.0));
        assert!(shares[..BINS / 2].iter().all(|&share| share > 0.0));
    }
}
