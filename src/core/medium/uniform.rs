//! Homogeneous media: distances and transmittances by Beer's law (PBR 4th ed., sections 11.2 and 14.1).

use super::equiangular::{Equiangular, reach};
use super::{PlainPhase, Way, chance};
use crate::color::Rgb;
use crate::math::{Mask, Real, Vector, exp, ln, real_struct};

real_struct! {
    /// The extinction of a homogeneous medium.
    pub(crate) struct Uniform<R> {
        /// The extinction coefficient per unit of length.
        pub sigma_t: R::Vec3,
        /// Whether light is scattered anywhere.
        pub scatters: R::Mask,
    }
}

real_struct! {
    /// A homogeneous medium that scatters by a formula and does not emit.
    pub(crate) struct PlainMedium<R> {
        pub uniform: Uniform<R>,
        /// The single-scattering albedo.
        pub albedo: R::Vec3,
        pub phase: PlainPhase<R>,
    }
}

/// The result of sampling a path segment, as [`super::Travel`].
pub(crate) struct Passage<R: Real> {
    /// The distance of scattering; undefined where light is not scattered.
    pub distance: R,
    pub is_scattered: R::Mask,
    pub throughput: R::Vec3,
    /// The probability of having come this far, see [`super::Travel::passed`].
    pub passed: R,
}

/// The probability of sampling the distance by a lamp that is near.
const EQUIANGULAR_SHARE: f32 = 0.4;

/// The transmittance over `distance`, which may be infinite.
#[inline(always)]
fn beer<R: Real>(sigma_t: R::Vec3, distance: R) -> R::Vec3 {
    // Infinity times zero would be NaN where there is no extinction.
    sigma_t.map(|sigma_t| R::select(sigma_t.is_more(R::ZERO), exp(-sigma_t * distance), R::ONE))
}

impl<R: Real> Uniform<R> {
    /// Implements [`super::Medium::midway`]; zero where it would be None.
    #[inline(always)]
    pub fn midway(&self, length: R) -> R {
        let densest = self.sigma_t.max_element();
        (R::HALF * length.min(R::ONE / densest)).only(self.scatters & densest.is_more(R::ZERO))
    }

    /// Whether a lamp within `radius` of `center` may be near the segment.
    #[inline(always)]
    pub fn may_be_near(&self, way: &Way<R>, center: R::Vec3, radius: f32) -> R::Mask {
        let to_center = center - way.origin;
        let nearest = to_center.dot(way.dir).max(R::ZERO).min(way.length);
        // The factor keeps rounding from missing a near lamp.
        let reach = (reach(way.length, self.sigma_t.max_element()) + R::splat(radius)) * R::splat(1.001);
        (to_center - way.dir * nearest)
            .length_squared()
            .is_at_most(reach.squared())
    }

    /// Implements [`super::Medium::travel`], with the position of a `lamp` where `has_lamp` is set, and the albedo at a
    /// distance. The first number of `u` chooses a channel by its share of the throughput; the second samples the
    /// channel's distance. The weights are those of the balance heuristic over all channels, so that no channel brings
    /// noise to the others (Wilkie et al., Hero Wavelength Spectral Sampling, 2014). Near a lamp, some of the distances
    /// are roughly equiangular, with the same heuristic.
    #[inline(always)]
    pub fn travel(
        &self,
        way: &Way<R>,
        lamp: R::Vec3,
        has_lamp: R::Mask,
        throughput: R::Vec3,
        u: [R; 2],
        albedo: impl Fn(R) -> R::Vec3,
    ) -> Passage<R> {
        let Self { sigma_t, scatters } = *self;
        let share = throughput / throughput.sum();
        let (mut of_lamp, mut near) = (R::ZERO, None);
        if (has_lamp & scatters).any() {
            let (lamp, is_near) = Equiangular::new(way, lamp, sigma_t.max_element());
            of_lamp = R::splat(EQUIANGULAR_SHARE).only(is_near & has_lamp & scatters);
            near = Some(lamp);
        }
        let of_colours = R::ONE - of_lamp;
        let v = (u[0] - of_lamp) / of_colours;
        let of_two = R::select(v.is_less(share.x() + share.y()), sigma_t.y(), sigma_t.z());
        let decides = R::select(v.is_less(share.x()), sigma_t.x(), of_two);
        let mut distance = -ln(R::ONE - u[1]) / decides;
        if let Some(near) = &near {
            distance = R::select(u[0].is_less(of_lamp), near.sample(u[1]), distance);
        }
        // Without extinction the distance is infinite, or NaN if the logarithm was zero.
        let is_scattered = distance.is_less(way.length) & scatters;
        let passing = beer(sigma_t, R::select(is_scattered, distance, way.length));
        let passed = R::select(scatters, chance::<R>(throughput, passing), R::ONE);
        let mut after = (throughput * passing / (passed * of_colours)).only(passed.is_more(R::ZERO));
        if is_scattered.any() {
            let collided = sigma_t * passing;
            let mut density = of_colours * share.dot(collided);
            if let Some(near) = &near {
                // Without a near lamp its density may be NaN.
                density += (of_lamp * near.pdf(distance)).only(of_lamp.is_more(R::ZERO));
            }
            let scattered = throughput * albedo(distance) * collided / density;
            after = R::Vec3::select(is_scattered, scattered, after);
        }
        Passage {
            distance,
            is_scattered,
            throughput: after,
            passed: R::select(is_scattered, R::ONE, passed),
        }
    }

    /// Implements [`super::Medium::transmit`].
    #[inline(always)]
    pub fn transmit(&self, length: R, carried: R::Vec3) -> (R::Vec3, R) {
        let passing = beer(self.sigma_t, length);
        let passed = R::select(self.scatters, chance::<R>(carried, passing), R::ONE);
        (passing, passed)
    }
}

/// The integral of [`beer`] from 0 to `distance`, or 0 where it is infinite: infinite emitting space without extinction
/// has no finite radiance.
pub(super) fn optical_length(sigma_t: Rgb, distance: f32) -> Rgb {
    let one = |sigma_t: f32| {
        let depth = sigma_t * distance;
        if sigma_t > 0.0 && depth > 1e-4 {
            -(-depth).exp_m1() / sigma_t
        } else if distance.is_finite() {
            distance * (1.0 - 0.5 * depth)
        } else {
            0.0
        }
    };
    Rgb::from_array(sigma_t.to_array().map(one))
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec2, Vec3};

    use super::super::{Medium, MediumSource, Phase, Volume};
    use super::*;
    use crate::math::LanesOf;
    use crate::math::lanes::{LANES, Lanes, Vec3Lanes, lanes_of};
    use crate::sampling::hash::pcg3d;
    use crate::sampling::{Sampler, unit_float};

    const SIGMA_T: Rgb = Rgb::new(0.35, 0.7, 2.8);
    const ALBEDO: Rgb = Rgb::new(0.9, 0.5, 0.2);
    const EMISSION: Rgb = Rgb::new(1.0, 2.0, 3.0);

    fn coloured() -> Medium {
        Medium::new(MediumSource {
            sigma_t: Volume::Constant(SIGMA_T),
            scale: 1.0,
            albedo: Volume::Constant(ALBEDO),
            emission: Volume::Constant(EMISSION),
            phase: Phase::Isotropic,
        })
    }

    /// The means of transmitted and of scattered light have formulas, for any throughput.
    #[test]
    fn what_travels_agrees_with_beer() {
        const COUNT: u32 = 1_000_000;
        let (medium, length) = (coloured(), 1.3);
        let mut stream = Sampler::new(Default::default(), Default::default(), 0, 0).stream(0);
        let way = Way {
            origin: Vec3::ZERO,
            dir: Vec3::X,
            length,
        };
        let throughputs = [Rgb::ONE, Rgb::new(0.1, 2.0, 0.0), Rgb::new(3.0, 0.2, 0.7)];
        let lamps = [None, Some(Vec3::new(0.4, 0.1, 0.05)), Some(Vec3::new(-0.1, 0.02, 0.0))];
        for (before, lamp) in throughputs
            .into_iter()
            .flat_map(|before| lamps.map(|lamp| (before, lamp)))
        {
            let (mut passed, mut scattered) = ([DVec3::ZERO; 2], [DVec3::ZERO; 2]);
            for number in 0..COUNT {
                let [x, y, _] = pcg3d([number, 7, 11]).map(unit_float);
                let mut throughput = before;
                let travel = medium.travel(&way, lamp, &mut throughput, Vec2::new(x, y), &mut stream);
                let [sum, squares] = match travel.scattered_at {
                    Some(distance) => {
                        assert!(distance < length);
                        &mut scattered
                    }
                    None => &mut passed,
                };
                *sum += throughput.as_dvec3();
                *squares += throughput.as_dvec3().powf(2.0);
            }
            let passing = (-SIGMA_T * length).exp();
            let expected = [before * passing, before * ALBEDO * (Rgb::ONE - passing)];
            for ([sum, squares], expected) in [passed, scattered].into_iter().zip(expected) {
                let mean = sum / f64::from(COUNT);
                let variance = squares / f64::from(COUNT) - mean * mean;
                let error = (variance / f64::from(COUNT)).map(f64::sqrt);
                let off = (mean - expected.as_dvec3()).abs();
                assert!(
                    off.cmple(4.0 * error + 1e-6).all(),
                    "{mean} +- {error}, expected {expected}"
                );
            }
        }
    }

    #[test]
    fn emission_is_gathered_along_the_whole_way() {
        let medium = coloured();
        let mut stream = Sampler::new(Default::default(), Default::default(), 0, 0).stream(0);
        for length in [1e-6f32, 0.01, 1.3, f32::INFINITY] {
            let way = Way {
                origin: Vec3::ZERO,
                dir: Vec3::X,
                length,
            };
            let travel = medium.travel(&way, None, &mut Rgb::ONE.clone(), Vec2::splat(0.4), &mut stream);
            let absorbed = Rgb::from_array((-SIGMA_T * length).to_array().map(|depth| -depth.exp_m1()));
            let expected = EMISSION * absorbed / SIGMA_T;
            assert!(
                ((travel.emitted - expected) / expected).abs().max_element() < 1e-4,
                "{length}"
            );
        }
    }

    fn assert_near(found: Rgb, expected: Rgb, what: &str) {
        let tolerance = 2e-4 * expected.max_element() + 1e-6;
        assert!(found.abs_diff_eq(expected, tolerance), "{what}: {found} {expected}");
    }

    #[test]
    fn ways_in_lanes_are_those_of_one() {
        let (mut lamps, mut scatterings) = (0, 0);
        let media = [
            (SIGMA_T, ALBEDO),
            (Rgb::new(0.0, 0.7, 1.0), Rgb::ONE),
            (Rgb::new(0.2, 0.0, 3.0), Rgb::ZERO),
            (Rgb::ZERO, Rgb::ONE),
        ];
        let media: [_; LANES] = std::array::from_fn(|lane| {
            let (sigma_t, albedo) = media[lane % 4];
            let scatters = albedo != Rgb::ZERO;
            (Uniform { sigma_t, scatters }, albedo)
        });
        for number in 0..400 {
            let vector = |n: usize| Vec3::from(pcg3d([number, n as u32, 5]).map(unit_float));
            let ways: [Way; LANES] = std::array::from_fn(|lane| Way {
                origin: vector(lane),
                dir: (vector(lane + 20) - 0.5).normalize(),
                length: match lane % 5 {
                    0 => f32::INFINITY,
                    _ => 2.0 * vector(lane + 40).x,
                },
            });
            let mut uniforms: Uniform<Lanes> = LanesOf::splat(media[0].0);
            let mut way: Way<Lanes> = LanesOf::splat(ways[0]);
            let [mut albedos, mut carried, mut at] = [Vec3Lanes::ZERO; 3];
            let mut numbers = [Lanes::ZERO; 2];
            for lane in 0..LANES {
                uniforms.set_lane(lane, media[lane].0);
                way.set_lane(lane, ways[lane]);
                albedos.set(lane, media[lane].1);
                carried.set(lane, vector(lane + 60));
                at.set(lane, vector(lane + 100));
                numbers[0].set_lane(lane, vector(lane + 80).x);
                numbers[1].set_lane(lane, vector(lane + 80).y);
            }
            // A lamp in two of three lanes.
            let lit = 0xb6db;
            let found = uniforms.travel(&way, at, lanes_of(lit), carried, numbers, |_| albedos);
            let (passing, passed) = uniforms.transmit(way.length, carried);
            let (midway, near) = (uniforms.midway(way.length), uniforms.may_be_near(&way, at, 0.0));
            for (lane, (uniform, albedo)) in media.iter().enumerate() {
                let (way, throughput, lamp) = (&ways[lane], carried.get(lane), at.get(lane));
                let u = numbers.map(|numbers| numbers.as_array()[lane]);
                let has_lamp = lit >> lane & 1 == 1;
                let one = uniform.travel(way, lamp, has_lamp, throughput, u, |_| *albedo);
                let is_scattered = found.is_scattered.to_bitmask() >> lane & 1 == 1;
                assert_eq!(is_scattered, one.is_scattered, "{number} {lane}");
                assert_near(found.throughput.get(lane), one.throughput, "throughput");
                assert!((found.passed.as_array()[lane] - one.passed).abs() < 1e-5);
                if one.is_scattered {
                    scatterings += 1;
                    let distance = found.distance.as_array()[lane];
                    assert!((distance - one.distance).abs() < 1e-3 * (1.0 + one.distance));
                }
                let (share, chance) = uniform.transmit(way.length, throughput);
                assert_near(passing.get(lane), share, "passing");
                assert!((passed.as_array()[lane] - chance).abs() < 1e-5);
                let expected = uniform.midway(way.length);
                assert!((midway.as_array()[lane] - expected).abs() < 1e-5 * (1.0 + expected));
                if has_lamp && uniform.scatters && Equiangular::new(way, lamp, uniform.sigma_t.max_element()).1 {
                    lamps += 1;
                    assert!(
                        near.to_bitmask() >> lane & 1 == 1,
                        "a lamp that is near is not left out"
                    );
                }
            }
        }
        assert!(lamps > 200 && scatterings > 1000, "{lamps} {scatterings}");
    }
}
