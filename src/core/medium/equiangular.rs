//! Sampling of scattering distances along a path segment by the position of a lamp: nearly in proportion to the angles
//! that the distances subtend at the lamp (Kulla and Fajardo, Importance Sampling Techniques for Path Tracing in
//! Participating Media, 2012).
//!
//! With `h` the distance of the lamp from the ray and `x` the distance along the ray from the point nearest to the
//! lamp, the density is in proportion to `1 / (h + |x|)^2`. That is between half and all of the equiangular density `1
//! / (h^2 + x^2)`, and needs no trigonometric functions.

use super::Way;
use crate::math::{Real, Vector, real_struct};

/// The distance of a lamp from the ray, in mean free paths, counts as at least this. It keeps the density finite.
const NEAREST: f32 = 1e-3;

/// The largest distance between lamp and segment for which lamps are sampled, relative to the mean free path or to the
/// segment's length, whichever is shorter. Farther lamps light the segment almost evenly, and sampling by them would
/// only add noise to the light from the segment's end.
const NEAR: f32 = 0.4;

real_struct! {
    /// A distribution of scattering distances along a segment.
    pub(super) struct Equiangular<R> {
        /// The distance along the ray of the point that is nearest to the lamp.
        nearest: R,
        /// The distance of the lamp from that point.
        height: R,
        /// The antiderivative of the density at the start of the segment, in [-1, 1], up to a factor.
        from: R,
        /// The antiderivative at the end of the segment.
        to: R,
    }
}

impl<R: Real> Equiangular<R> {
    /// The distribution for a lamp in a medium with the extinction `sigma_t`, and a mask of where it is defined: where
    /// the lamp is within [`reach`] of the segment.
    #[inline(always)]
    pub fn new(way: &Way<R>, lamp: R::Vec3, sigma_t: R) -> (Self, R::Mask) {
        let to_lamp = lamp - way.origin;
        let nearest = to_lamp.dot(way.dir);
        let height_squared = (to_lamp - way.dir * nearest).length_squared();
        let beside = nearest - nearest.max(R::ZERO).min(way.length);
        let is_near = beside
            .mul_add(beside, height_squared)
            .is_at_most(reach(way.length, sigma_t).squared());
        let height = height_squared.sqrt().max(R::splat(NEAREST) / sigma_t);
        let share = |distance: R| {
            let along = distance - nearest;
            (R::ONE - height / (height + along.abs())).copy_sign(along)
        };
        let (from, to) = (share(R::ZERO), share(way.length));
        let distribution = Self {
            nearest,
            height,
            from,
            to,
        };
        (distribution, is_near & to.is_more(from))
    }

    /// The distance for `u` in [0, 1).
    #[inline(always)]
    pub fn sample(&self, u: R) -> R {
        let share = self.from.mix(self.to, u);
        (self.nearest + self.height * share / (R::ONE - share.abs())).max(R::ZERO)
    }

    /// The density at a distance.
    #[inline(always)]
    pub fn pdf(&self, distance: R) -> R {
        let size = self.height + (distance - self.nearest).abs();
        self.height / ((self.to - self.from) * size * size)
    }
}

/// The largest distance of a lamp from a segment of this length for which lamps are sampled.
#[inline(always)]
pub(super) fn reach<R: Real>(length: R, sigma_t: R) -> R {
    R::splat(NEAR) * length.min(R::ONE / sigma_t)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math::LanesOf;
    use crate::math::lanes::{LANES, Lanes, Vec3Lanes};
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
            let (lamp, is_near) = Equiangular::new(&way, Vec3::new(0.5, 0.6, 0.1), 0.5);
            assert!(is_near);
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
        let is_near = |x, y, sigma_t| Equiangular::new(&way, Vec3::new(x, y, 0.0), sigma_t).1;
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
            let lamp = vector(2);
            let way = Way {
                origin: vector(1),
                dir: (vector(3) - 0.5).normalize(),
                length: match number % 3 {
                    0 => f32::INFINITY,
                    _ => 2.0 * vector(4).x,
                },
            };
            let (sigma_t, u) = (2.0 * vector(4).y, vector(4).z);
            let sigma_t = if number % 10 == 0 { 0.0 } else { sigma_t };
            let (one, is_near) = Equiangular::new(&way, lamp, sigma_t);
            let splat = Lanes::splat;
            let (lanes, are_near) = Equiangular::new(&LanesOf::splat(way), Vec3Lanes::splat(lamp), splat(sigma_t));
            assert_eq!(are_near.to_bitmask(), if is_near { (1 << LANES) - 1 } else { 0 });
            if !is_near {
                continue;
            }
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
