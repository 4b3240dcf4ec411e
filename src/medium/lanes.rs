//! The commonest phase functions for sixteen places at once: isotropic, and of Henyey and Greenstein.
//!
//! Directions are in frames whose z axis is the direction in which a path has come.

use std::f32::consts::{FRAC_1_PI, TAU};

use crate::math::lanes::{Lanes, Vec3Lanes};

use super::phase::NEARLY_ISOTROPIC;

/// A phase function per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PhaseLanes {
    /// The lanes that have one, a bit each.
    pub lanes: u32,
    /// The mean cosines.
    pub g: Lanes,
}

impl PhaseLanes {
    /// Lanes without phase functions.
    pub const NONE: Self = Self {
        lanes: 0,
        g: Lanes::ZERO,
    };

    /// The densities as [`super::Phase::pdf`], by the cosine of the angle between the old and the new direction.
    #[inline(always)]
    pub fn pdf(&self, cosine: Lanes) -> Lanes {
        let g = self.g;
        let squared = (g.mul_add(g, Lanes::ONE) - (g + g) * cosine).fast_max(Lanes::ZERO);
        Lanes::splat(0.25 * FRAC_1_PI) * g.mul_neg_add(g, Lanes::ONE) / (squared * squared.sqrt())
    }

    /// Directions as of [`super::Phase::sample`], and their densities.
    #[inline(always)]
    pub fn sample(&self, [u, v]: [Lanes; 2]) -> (Vec3Lanes, Lanes) {
        let (one, g) = (Lanes::ONE, self.g);
        let even = u + u - one;
        let almost_even = (Lanes::splat(1.5) * g).mul_add(even.mul_neg_add(even, one), even);
        let ratio = g.mul_neg_add(g, one) / (g + g).mul_add(u, one - g);
        let skewed = ratio.mul_neg_add(ratio, g.mul_add(g, one)) / (g + g);
        let is_even = g.abs().simd_lt(Lanes::splat(NEARLY_ISOTROPIC));
        let cosine = is_even.select(almost_even, skewed).fast_max(-one).fast_min(one);
        let sine = cosine.mul_neg_add(cosine, one).fast_max(Lanes::ZERO).sqrt();
        let (sin_phi, cos_phi) = (Lanes::splat(TAU) * v).sin_cos();
        let wi = Vec3Lanes::of(sine * cos_phi, sine * sin_phi, cosine);
        (wi, self.pdf(cosine))
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::super::Phase;
    use super::*;
    use crate::math::lanes::LANES;
    use crate::sampling::hash::pcg3d;
    use crate::sampling::unit_float;

    #[test]
    fn phases_in_lanes_are_those_of_one() {
        let of = [0.0f32, 0.5, -0.3, 0.95, 5e-4, -0.9, 0.0, 0.2];
        let phases = PhaseLanes {
            lanes: (1 << LANES) - 1,
            g: Lanes::new(std::array::from_fn(|lane| of[lane % of.len()])),
        };
        for number in 0..100 {
            let [x, y, _] = pcg3d([number, 3, 9]).map(unit_float);
            let (wi, pdf) = phases.sample([Lanes::splat(x), Lanes::splat(y)]);
            for lane in 0..LANES {
                let phase = match of[lane % of.len()] {
                    0.0 => Phase::Isotropic,
                    g => Phase::HenyeyGreenstein { g },
                };
                let (expected, density) = phase.sample(Vec3::ZERO, Vec3::Z, 0.0, Vec2::new(x, y));
                let found = wi.get(lane);
                assert!(found.is_normalized());
                assert!((found.z - expected.z).abs() < 1e-4, "{found} {expected}");
                let own = pdf.as_array()[lane];
                assert!((own - density).abs() < 1e-3 * density, "{own} {density}");
            }
        }
    }
}
