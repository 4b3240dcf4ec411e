//! Distances along a ray that are more frequent near a lamp, about as if they were evenly distributed over the angles under which the lamp sees them (Kulla
//! and Fajardo, Importance Sampling Techniques for Path Tracing in Participating Media, 2012).
//!
//! With `h` from the lamp to the ray and `x` along the ray from the nearest point, the density is in proportion to `1 / (h + |x|)^2`. That is between
//! the half and the whole of the equiangular `1 / (h^2 + x^2)`, and needs no trigonometric functions.

use glam::Vec3;

use super::Way;
use crate::math::Vector;
use crate::math::lanes::{Lanes, Vec3Lanes, copy_sign};

/// The least distance of a lamp from the ray, relative to the mean free path. It keeps the density finite.
const NEAREST: f32 = 1e-3;

/// The largest distance of a lamp from the way that is worth it, relative to the mean free path or to the way, whichever is less. In light that is nearly
/// the same all along the way, the distribution would only be noise for what comes from the end.
pub(super) const NEAR: f32 = 0.4;

/// A distribution of distances.
#[derive(Clone, Copy)]
pub(super) struct Equiangular {
    /// The distance along the way of the point that is nearest to the lamp.
    nearest: f32,
    /// The distance of the lamp from there.
    height: f32,
    /// The shares, from -1 to 1, of the start and of the end of the way.
    from: f32,
    to: f32,
}

impl Equiangular {
    /// The distribution for a lamp in a medium with the extinction `sigma_t`. None if the lamp is farther than [`NEAR`] from the way.
    pub fn new(way: &Way, lamp: Vec3, sigma_t: f32) -> Option<Self> {
        let to_lamp = lamp - way.origin;
        let nearest = to_lamp.dot(way.dir);
        let height_squared = (to_lamp - way.dir * nearest).length_squared();
        let beside = nearest - nearest.clamp(0.0, way.length);
        let reach = NEAR * way.length.min(1.0 / sigma_t);
        if height_squared + beside * beside > reach * reach {
            return None;
        }
        let height = height_squared.sqrt().max(NEAREST / sigma_t);
        let share = |distance: f32| {
            let along = distance - nearest;
            (1.0 - height / (height + along.abs())).copysign(along)
        };
        let (from, to) = (share(0.0), share(way.length));
        (to > from).then_some(Self {
            nearest,
            height,
            from,
            to,
        })
    }

    /// The distance for `u` in [0, 1).
    pub fn sample(&self, u: f32) -> f32 {
        let share = self.from + u * (self.to - self.from);
        (self.nearest + self.height * share / (1.0 - share.abs())).max(0.0)
    }

    /// The density at a distance.
    pub fn pdf(&self, distance: f32) -> f32 {
        let size = self.height + (distance - self.nearest).abs();
        self.height / ((self.to - self.from) * size * size)
    }
}

/// The same for sixteen ways.
#[derive(Clone, Copy)]
pub(super) struct EquiangularLanes {
    /// The lanes that have one, as a mask.
    pub is_near: Lanes,
    nearest: Lanes,
    height: Lanes,
    from: Lanes,
    to: Lanes,
}

impl EquiangularLanes {
    /// The distributions as of [`Equiangular::new`], with the distance `reach` that is near and the `least` height.
    #[inline(always)]
    pub fn new(origin: Vec3Lanes, dir: Vec3Lanes, length: Lanes, lamp: Vec3Lanes, [reach, least]: [Lanes; 2]) -> Self {
        let to_lamp = lamp - origin;
        let nearest = to_lamp.dot(dir);
        let height_squared = to_lamp.plus_scaled(-nearest, dir).length_squared();
        let beside = nearest - nearest.fast_max(Lanes::ZERO).fast_min(length);
        let is_near = beside.mul_add(beside, height_squared).simd_le(reach * reach);
        let height = height_squared.sqrt().fast_max(least);
        let share = |distance: Lanes| {
            let along = distance - nearest;
            copy_sign(Lanes::ONE - height / (height + along.abs()), along)
        };
        let (from, to) = (share(Lanes::ZERO), share(length));
        Self {
            is_near: is_near & to.simd_gt(from),
            nearest,
            height,
            from,
            to,
        }
    }

    #[inline(always)]
    pub fn sample(&self, u: Lanes) -> Lanes {
        let share = u.mul_add(self.to - self.from, self.from);
        (self.nearest + self.height * share / (Lanes::ONE - share.abs())).fast_max(Lanes::ZERO)
    }

    #[inline(always)]
    pub fn pdf(&self, distance: Lanes) -> Lanes {
        let size = self.height + (distance - self.nearest).abs();
        self.height / ((self.to - self.from) * size * size)
    }
}

/// The largest distance of a lamp that is near, and the least distance that it counts with.
#[inline(always)]
pub(super) fn limits(length: Lanes, sigma_t: Lanes) -> [Lanes; 2] {
    let free_path = Lanes::ONE / sigma_t;
    [
        Lanes::splat(NEAR) * length.fast_min(free_path),
        Lanes::splat(NEAREST) * free_path,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::LANES;
    use crate::sampling::hash::pcg3d;
    use crate::sampling::unit_float;

    #[test]
    fn distances_follow_their_density() {
        for length in [0.7, 3.0, f32::INFINITY] {
            let way = Way {
                origin: Vec3::new(0.3, 0.0, 0.0),
                dir: Vec3::Y,
                length,
            };
            let lamp = Equiangular::new(&way, Vec3::new(0.5, 0.6, 0.1), 0.5).unwrap();
            const STEPS: usize = 20_000;
            // The integral of the density up to each sampled distance is the number it was sampled by.
            let mut integral = 0.0f64;
            let mut before = lamp.sample(0.0);
            for step in 1..STEPS {
                let u = step as f32 / STEPS as f32;
                let distance = lamp.sample(u);
                assert!(distance >= before && distance <= length * 1.0001);
                integral += f64::from(0.5 * (lamp.pdf(before) + lamp.pdf(distance)) * (distance - before));
                before = distance;
                if u < 0.99 {
                    assert!((integral - f64::from(u)).abs() < 2e-3, "{length} {u}: {integral}");
                }
            }
        }
    }

    #[test]
    fn lamps_far_off_are_left_out() {
        let way = Way {
            origin: Vec3::ZERO,
            dir: Vec3::Y,
            length: 1.0,
        };
        let is_near = |x, y, sigma_t| Equiangular::new(&way, Vec3::new(x, y, 0.0), sigma_t).is_some();
        assert!(!is_near(NEAR + 0.01, 0.5, 1.0));
        assert!(is_near(NEAR - 0.01, 0.5, 1.0));
        assert!(!is_near(0.0, 1.01 + NEAR, 1.0));
        assert!(is_near(0.0, 0.99 + NEAR, 1.0));
        assert!(!is_near(NEAR - 0.01, 0.5, 2.0));
    }

    #[test]
    fn lanes_have_the_distributions_of_one() {
        let mut near = 0;
        for number in 0..500 {
            let vector = |n| Vec3::from(pcg3d([number, n, 5]).map(unit_float));
            let (origin, lamp) = (vector(1), vector(2));
            let dir = (vector(3) - 0.5).normalize();
            let length = if number % 3 == 0 {
                f32::INFINITY
            } else {
                2.0 * vector(4).x
            };
            let (sigma_t, u) = (2.0 * vector(4).y, vector(4).z);
            let one = Equiangular::new(&Way { origin, dir, length }, lamp, sigma_t);
            let splat = Lanes::splat;
            let lanes = EquiangularLanes::new(
                Vec3Lanes::splat(origin),
                Vec3Lanes::splat(dir),
                splat(length),
                Vec3Lanes::splat(lamp),
                limits(splat(length), splat(sigma_t)),
            );
            assert_eq!(
                lanes.is_near.to_bitmask(),
                if one.is_some() { (1 << LANES) - 1 } else { 0 }
            );
            let Some(one) = one else { continue };
            near += 1;
            let (distance, expected) = (lanes.sample(splat(u)).as_array()[0], one.sample(u));
            assert!(
                (distance - expected).abs() < 1e-3 * (1.0 + expected),
                "{distance} {expected}"
            );
            let (pdf, expected) = (lanes.pdf(splat(expected)).as_array()[0], one.pdf(expected));
            assert!((pdf - expected).abs() < 1e-3 * expected, "{pdf} {expected}");
        }
        assert!(near > 50, "{near}");
    }
}
