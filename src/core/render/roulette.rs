//! Russian roulette ends paths with little throughput at random, and raises the weight of the survivors (Arvo and Kirk,
//! Particle Transport and Image Synthesis, 1990; PBR 4th ed., sections 2.2.4 and 13.4.1).

use super::view::PathSettings;
use crate::math::Real;

/// The highest probability that a path continues, so that bright enclosures end too.
const HIGHEST_SURVIVAL: f32 = 0.95;

/// The same in media: milk scatters light some hundred times before it leaves, and steadily growing weights would be
/// noise.
const HIGHEST_SURVIVAL_IN_MEDIA: f32 = 0.999;

/// The number of further vertices for which roulette waits after specular bounces. Light that has passed through glass
/// is strong and rare, and roulette was played for it at its last scattering.
const SPECULAR_GRACE: u32 = 16;

/// Whether roulette is played at the surface number `depth` of the path. `is_scattered` says that the path continues in
/// a direction that was sampled by a density.
#[inline(always)]
pub(super) fn is_played<R: Real>(settings: &PathSettings, depth: R::Word, is_scattered: R::Mask) -> R::Mask {
    let late = settings.rr_depth.saturating_add(SPECULAR_GRACE);
    (is_scattered & R::is_at_least(depth, settings.rr_depth)) | R::is_at_least(depth, late)
}

/// The survival probability of a path whose throughput has `brightest` as its largest component.
#[inline(always)]
pub(super) fn survival<R: Real>(brightest: R, eta_squared: R) -> R {
    (brightest * eta_squared).min(R::splat(HIGHEST_SURVIVAL))
}

/// [`survival`] of a path that was scattered in a medium.
#[inline(always)]
pub(super) fn survival_in_media<R: Real>(brightest: R, eta_squared: R) -> R {
    (brightest * eta_squared).min(R::splat(HIGHEST_SURVIVAL_IN_MEDIA))
}

/// The squared relative index of refraction of a path that had `so_far` and is refracted with the relative index `eta`.
/// Refraction scales radiance by this factor (PBR 4th ed., section 9.5.2), which does not predict the path's
/// contribution.
#[inline(always)]
pub(super) fn eta_squared<R: Real>(so_far: R, eta: R) -> R {
    so_far * eta * eta
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::{LANES, Lanes, WordLanes};
    use crate::render::view::Strategy;

    #[test]
    fn roulette_in_lanes_is_that_of_one() {
        for rr_depth in [1, 5, u32::MAX] {
            let settings = PathSettings {
                max_depth: u32::MAX,
                rr_depth,
                hide_emitters: false,
                strategy: Strategy::Mis,
                media: false,
            };
            for depth in 1..40u32 {
                for is_scattered in [false, true] {
                    let expected = is_played::<f32>(&settings, depth, is_scattered);
                    let wait = if is_scattered { 0 } else { SPECULAR_GRACE };
                    assert_eq!(expected, depth >= rr_depth.saturating_add(wait));
                    let all = Lanes::ZERO.simd_eq(Lanes::ZERO);
                    let mask = if is_scattered { all } else { Lanes::ZERO };
                    let found = is_played::<Lanes>(&settings, WordLanes::splat(depth), mask);
                    assert_eq!(found.to_bitmask(), if expected { (1 << LANES) - 1 } else { 0 });
                }
            }
        }
    }

    #[test]
    fn glass_does_not_count_and_no_path_is_sure_to_go_on() {
        // The path goes into glass and out again.
        let inside = eta_squared(1.0f32, 1.5);
        assert_eq!(inside, 2.25);
        assert!((eta_squared(inside, 1.0 / 1.5) - 1.0).abs() < 1e-6);
        // Inside glass, radiance is scaled by the square of its index.
        assert!((survival(0.5 / 2.25, inside) - 0.5f32).abs() < 1e-6);
        assert_eq!(survival(20.0, 1.0), HIGHEST_SURVIVAL);
        assert_eq!(survival(0.0, 1.0), 0.0f32);
    }
}
