//! Distances and transmittances in media that are the same everywhere, for sixteen ways at once: what `uniform.rs` does for one. It is done so where media
//! do not shine, have one albedo, and scatter by the commonest phase functions.

use super::equiangular::{EquiangularLanes, limits};
use super::uniform::EQUIANGULAR_SHARE;
use crate::color::Rgb;
use crate::math::Vector;
use crate::math::lanes::{Lanes, Vec3Lanes};

/// A medium of this kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlainMedium {
    /// The extinction coefficient per unit of length.
    pub sigma_t: Rgb,
    /// The part of it that is scattering; zero where light is only absorbed.
    pub albedo: Rgb,
    /// The mean cosine of the phase function.
    pub g: f32,
}

/// A medium in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlainMediumLanes {
    /// The lanes that have one, a bit each.
    pub lanes: u32,
    sigma_t: Vec3Lanes,
    albedo: Vec3Lanes,
    /// The mean cosines.
    pub g: Lanes,
}

/// Straight ways, as [`super::Way`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct WayLanes {
    pub origin: Vec3Lanes,
    pub dir: Vec3Lanes,
    pub length: Lanes,
}

/// What has become of light, as [`super::Travel`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct TravelLanes {
    /// The distances at which it is scattered, in the lanes of `is_scattered`.
    pub distance: Lanes,
    pub is_scattered: Lanes,
    pub throughput: Vec3Lanes,
    /// The probabilities of having come so far, see [`super::Travel::passed`].
    pub passed: Lanes,
}

impl PlainMediumLanes {
    /// Lanes without media.
    pub const NONE: Self = Self {
        lanes: 0,
        sigma_t: Vec3Lanes::ZERO,
        albedo: Vec3Lanes::ZERO,
        g: Lanes::ZERO,
    };

    /// Fills a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, medium: &PlainMedium) {
        self.lanes |= 1 << lane;
        self.sigma_t.set(lane, medium.sigma_t);
        self.albedo.set(lane, medium.albedo);
        self.g.as_mut_array()[lane] = medium.g;
    }

    /// The distances as [`super::Medium::midway`]; zero where there is none.
    #[inline(always)]
    pub fn midway(&self, length: Lanes) -> Lanes {
        let free_path = Lanes::ONE / self.sigma_t.max_element();
        let is_there = self.albedo.is_not_zero() & self.sigma_t.is_not_zero();
        (Lanes::splat(0.5) * length.fast_min(free_path)) & is_there
    }

    /// A mask of the lanes for which a lamp may be near that is within `radius` of `center`.
    #[inline(always)]
    pub fn may_be_near(&self, way: &WayLanes, center: Vec3Lanes, radius: f32) -> Lanes {
        let to_center = center - way.origin;
        let nearest = to_center.dot(way.dir).fast_max(Lanes::ZERO).fast_min(way.length);
        let [reach, _] = limits(way.length, self.sigma_t.max_element());
        // Rounding must leave out nothing that is near.
        let reach = (reach + Lanes::splat(radius)) * Lanes::splat(1.001);
        to_center
            .plus_scaled(-nearest, way.dir)
            .length_squared()
            .simd_le(reach * reach)
    }

    /// Does what [`super::Medium::travel`] says, in the lanes that have media. The lanes of the mask `has_lamp` have a `lamp`.
    #[inline(always)]
    pub fn travel(
        &self,
        way: &WayLanes,
        lamp: Vec3Lanes,
        has_lamp: Lanes,
        throughput: Vec3Lanes,
        u: [Lanes; 2],
    ) -> TravelLanes {
        let (zero, one) = (Lanes::ZERO, Lanes::ONE);
        let Self { sigma_t, albedo, .. } = *self;
        let scatters = albedo.is_not_zero();
        let sum = throughput.x + throughput.y + throughput.z;
        let share = throughput / sum;
        let [reach, least] = limits(way.length, sigma_t.max_element());
        let (mut of_lamp, mut near) = (zero, None);
        if has_lamp.any() {
            let lamp = EquiangularLanes::new(way.origin, way.dir, way.length, lamp, [reach, least]);
            of_lamp = Lanes::splat(EQUIANGULAR_SHARE) & lamp.is_near & has_lamp & scatters;
            near = Some(lamp);
        }
        let v = (u[0] - of_lamp) / (one - of_lamp);
        let of_two = v.simd_lt(share.x + share.y).select(sigma_t.y, sigma_t.z);
        let decides = v.simd_lt(share.x).select(sigma_t.x, of_two);
        let mut distance = -(one - u[1]).ln() / decides;
        if let Some(near) = &near {
            distance = u[0].simd_lt(of_lamp).select(near.sample(u[1]), distance);
        }
        let is_scattered = distance.simd_lt(way.length) & scatters;
        let passing = beer(sigma_t, is_scattered.select(distance, way.length));
        let carried = throughput * passing;

        let collided = sigma_t * passing;
        let mut density = (one - of_lamp) * share.dot(collided);
        if let Some(near) = &near {
            // Where there is none, its density is perhaps no number.
            density += (of_lamp * near.pdf(distance)) & of_lamp.simd_gt(zero);
        }
        let scattered = throughput * albedo * collided / density;

        let chance = scatters.select((carried.x + carried.y + carried.z) / sum, one);
        let arrived = (carried / (chance * (one - of_lamp))).only(chance.simd_gt(zero));
        TravelLanes {
            distance,
            is_scattered,
            throughput: Vec3Lanes::select(is_scattered, scattered, arrived),
            passed: is_scattered.select(one, chance),
        }
    }

    /// Does what [`super::Medium::transmit`] says, in the lanes that have media.
    #[inline(always)]
    pub fn transmit(&self, length: Lanes, carried: Vec3Lanes) -> (Vec3Lanes, Lanes) {
        let passing = beer(self.sigma_t, length);
        let after = carried * passing;
        let chance = (after.x + after.y + after.z) / (carried.x + carried.y + carried.z);
        let scatters = self.albedo.is_not_zero();
        (passing, scatters.select(chance, Lanes::ONE))
    }
}

/// The share of light that passes `distance`, which may be infinite.
#[inline(always)]
fn beer(sigma_t: Vec3Lanes, distance: Lanes) -> Vec3Lanes {
    sigma_t.map(|sigma_t| {
        let passing = (-sigma_t * distance).exp();
        // Infinity times zero is no number, where there is no extinction.
        sigma_t.simd_gt(Lanes::ZERO).select(passing, Lanes::ONE)
    })
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::super::{Medium, MediumSource, Phase, Volume, Way};
    use super::*;
    use crate::math::lanes::LANES;
    use crate::sampling::hash::pcg3d;
    use crate::sampling::{Sampler, unit_float};

    fn media() -> Vec<Medium> {
        let medium = |sigma_t, albedo| {
            Medium::new(MediumSource {
                sigma_t: Volume::Constant(sigma_t),
                scale: 1.0,
                albedo: Volume::Constant(albedo),
                emission: Volume::ZERO,
                phase: Phase::HenyeyGreenstein { g: 0.3 },
            })
        };
        vec![
            medium(Rgb::new(0.35, 0.7, 2.8), Rgb::new(0.9, 0.5, 0.2)),
            medium(Rgb::new(0.0, 0.7, 1.0), Rgb::ONE),
            medium(Rgb::new(0.2, 0.0, 3.0), Rgb::ZERO),
            medium(Rgb::ZERO, Rgb::ONE),
        ]
    }

    fn assert_near(found: Rgb, expected: Rgb, what: &str) {
        let tolerance = 2e-4 * expected.max_element() + 1e-6;
        assert!(found.abs_diff_eq(expected, tolerance), "{what}: {found} {expected}");
    }

    #[test]
    fn ways_in_lanes_are_those_of_one() {
        let (media, mut lamps, mut scatterings) = (media(), 0, 0);
        for number in 0..400 {
            let vector = |n: usize| Vec3::from(pcg3d([number, n as u32, 5]).map(unit_float));
            let ways: [Way; LANES] = std::array::from_fn(|lane| Way {
                origin: vector(lane),
                dir: (vector(lane + 20) - 0.5).normalize(),
                length: if lane % 5 == 0 {
                    f32::INFINITY
                } else {
                    2.0 * vector(lane + 40).x
                },
            });
            let throughput: [Rgb; LANES] = std::array::from_fn(|lane| vector(lane + 60));
            let u: [Vec2; LANES] = std::array::from_fn(|lane| vector(lane + 80).truncate());
            let lamp: [Vec3; LANES] = std::array::from_fn(|lane| vector(lane + 100));

            let mut plain = PlainMediumLanes::NONE;
            let [mut origin, mut dir, mut carried, mut at] = [Vec3Lanes::ZERO; 4];
            for lane in 0..LANES {
                plain.set(lane, media[lane % 4].plain().expect("it is plain"));
                origin.set(lane, ways[lane].origin);
                dir.set(lane, ways[lane].dir);
                carried.set(lane, throughput[lane]);
                at.set(lane, lamp[lane]);
            }
            let lanes_of = |f: &dyn Fn(usize) -> f32| Lanes::new(std::array::from_fn(f));
            let length = lanes_of(&|lane| ways[lane].length);
            let has_lamp = lanes_of(&|lane| (lane % 3) as f32).simd_gt(Lanes::ZERO);
            let numbers = [lanes_of(&|lane| u[lane].x), lanes_of(&|lane| u[lane].y)];
            let way = WayLanes { origin, dir, length };
            let found = plain.travel(&way, at, has_lamp, carried, numbers);
            let (passing, passed) = plain.transmit(length, carried);
            let (midway, near) = (plain.midway(length), plain.may_be_near(&way, at, 0.0).to_bitmask());
            for lane in 0..LANES {
                let medium = &media[lane % 4];
                let mut stream = Sampler::new(Default::default(), Default::default(), 0, 0).stream(0);
                let mut expected = throughput[lane];
                let lamp = (lane % 3 != 0).then_some(lamp[lane]);
                let travel = medium.travel(&ways[lane], lamp, &mut expected, u[lane], &mut stream);
                let is_scattered = found.is_scattered.to_bitmask() >> lane & 1 == 1;
                assert_eq!(is_scattered, travel.scattered_at.is_some(), "{number} {lane}");
                assert_near(found.throughput.get(lane), expected, "throughput");
                assert!((found.passed.as_array()[lane] - travel.passed).abs() < 1e-5);
                if let Some(distance) = travel.scattered_at {
                    scatterings += 1;
                    assert!((found.distance.as_array()[lane] - distance).abs() < 1e-3 * (1.0 + distance));
                }
                let mut expected = throughput[lane];
                let (share, chance) = medium.transmit(&ways[lane], &mut expected, &mut stream);
                assert_near(passing.get(lane), share, "passing");
                assert!((passed.as_array()[lane] - chance).abs() < 1e-5);
                let expected = medium.midway(ways[lane].length).unwrap_or(0.0);
                assert!((midway.as_array()[lane] - expected).abs() < 1e-5 * (1.0 + expected));
                if medium.considers(&ways[lane], lamp) {
                    lamps += 1;
                    assert!(near >> lane & 1 == 1, "a lamp that is near is not left out");
                }
            }
        }
        assert!(lamps > 200 && scatterings > 1000, "{lamps} {scatterings}");
    }
}
