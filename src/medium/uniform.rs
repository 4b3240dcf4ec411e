//! Media that are the same everywhere: distances and transmittances by Beer's law (PBR 4th ed., sections 11.2 and 14.1).

use glam::{Vec2, Vec3};

use super::equiangular::Equiangular;
use super::{MediumSource, Travel, Way, chance};
use crate::color::Rgb;

/// The extinction and the emission of a medium, which are the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Uniform {
    /// The extinction coefficient per unit of length.
    pub sigma_t: Rgb,
    /// The radiance that is emitted per unit of length.
    pub emission: Rgb,
}

/// The share of distances that are sampled by the place of the lamp, where that is near.
pub(super) const EQUIANGULAR_SHARE: f32 = 0.4;

/// The share of light that passes `distance`, which may be infinite.
fn beer(sigma_t: Rgb, distance: f32) -> Rgb {
    // Infinity times zero is no number, where there is no extinction.
    Rgb::select(sigma_t.cmpgt(Rgb::ZERO), (-sigma_t * distance).exp(), Rgb::ONE)
}

/// Does what [`super::Medium::travel`] says. Each colour of the throughput decides as often as its share in it says, by the first number of `u`; the second decides how far
/// that colour goes. The weights are those of the balance heuristic over all colours, so that no colour brings noise to the others (Wilkie et al.,
/// Hero Wavelength Spectral Sampling, 2014). Near a `lamp`, some of the distances are about equiangular, with the same heuristic.
pub(super) fn travel(
    source: &MediumSource,
    Uniform { sigma_t, emission }: Uniform,
    way: &Way,
    lamp: Option<Vec3>,
    throughput: &mut Rgb,
    u: Vec2,
) -> Travel {
    let emitted = match emission == Rgb::ZERO {
        true => Rgb::ZERO,
        false => *throughput * emission * optical_length(sigma_t, way.length),
    };
    if !source.scatters() {
        *throughput *= beer(sigma_t, way.length);
        return Travel {
            scattered_at: None,
            passed: 1.0,
            emitted,
        };
    }
    let share = *throughput / throughput.element_sum();
    let near_lamp = lamp.and_then(|lamp| Equiangular::new(way, lamp, sigma_t.max_element()));
    let of_lamp = if near_lamp.is_some() { EQUIANGULAR_SHARE } else { 0.0 };
    let distance = match &near_lamp {
        Some(near_lamp) if u.x < of_lamp => near_lamp.sample(u.y),
        _ => {
            let decides = match (u.x - of_lamp) / (1.0 - of_lamp) {
                u if u < share.x => sigma_t.x,
                u if u < share.x + share.y => sigma_t.y,
                _ => sigma_t.z,
            };
            -(1.0 - u.y).ln() / decides
        }
    };
    // Without extinction the distance is infinite, or no number if the logarithm was zero.
    if distance < way.length {
        let passing = beer(sigma_t, distance);
        let near_lamp = near_lamp.map_or(0.0, |near_lamp| near_lamp.pdf(distance));
        let density = (1.0 - of_lamp) * share.dot(sigma_t * passing) + of_lamp * near_lamp;
        let point = way.origin + way.dir * distance;
        *throughput *= source.albedo_at(point) * sigma_t * passing / density;
        return Travel {
            scattered_at: Some(distance),
            passed: 1.0,
            emitted,
        };
    }
    let passing = beer(sigma_t, way.length);
    let passed = chance(*throughput, passing);
    *throughput = match passed > 0.0 {
        true => *throughput * passing / (passed * (1.0 - of_lamp)),
        false => Rgb::ZERO,
    };
    Travel {
        scattered_at: None,
        passed,
        emitted,
    }
}

/// Does what [`super::Medium::transmit`] says.
pub(super) fn transmit(source: &MediumSource, uniform: Uniform, way: &Way, carried: &mut Rgb) -> (Rgb, f32) {
    let passing = beer(uniform.sigma_t, way.length);
    let passed = match source.scatters() {
        true => chance(*carried, passing),
        false => 1.0,
    };
    *carried *= passing;
    (passing, passed)
}

/// The integral of [`beer`] from 0 to `distance`. Where it is infinite it counts as 0: a space without end and without extinction that shines
/// has no finite radiance.
fn optical_length(sigma_t: Rgb, distance: f32) -> Rgb {
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
    use glam::{DVec3, Vec3};

    use super::super::{Phase, Volume};
    use super::*;
    use crate::sampling::hash::pcg3d;
    use crate::sampling::unit_float;

    const ALBEDO: Rgb = Rgb::new(0.9, 0.5, 0.2);

    fn coloured() -> (MediumSource, Uniform) {
        let uniform = Uniform {
            sigma_t: Rgb::new(0.35, 0.7, 2.8),
            emission: Rgb::new(1.0, 2.0, 3.0),
        };
        let source = MediumSource {
            sigma_t: Volume::Constant(uniform.sigma_t),
            scale: 1.0,
            albedo: Volume::Constant(ALBEDO),
            emission: Volume::Constant(uniform.emission),
            phase: Phase::Isotropic,
        };
        (source, uniform)
    }

    /// The means of what passes and of what is scattered have formulas, for any throughput.
    #[test]
    fn what_travels_agrees_with_beer() {
        const COUNT: u32 = 1_000_000;
        let (source, uniform) = coloured();
        let (sigma_t, length) = (uniform.sigma_t, 1.3);
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
                let travel = travel(&source, uniform, &way, lamp, &mut throughput, Vec2::new(x, y));
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
            let passing = (-sigma_t * length).exp();
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
        let (source, uniform) = coloured();
        let sigma_t = uniform.sigma_t;
        for length in [1e-6f32, 0.01, 1.3, f32::INFINITY] {
            let way = Way {
                origin: Vec3::ZERO,
                dir: Vec3::X,
                length,
            };
            let travel = travel(&source, uniform, &way, None, &mut Rgb::ONE.clone(), Vec2::splat(0.4));
            let absorbed = Rgb::from_array((-sigma_t * length).to_array().map(|depth| -depth.exp_m1()));
            let expected = uniform.emission * absorbed / sigma_t;
            assert!(
                ((travel.emitted - expected) / expected).abs().max_element() < 1e-4,
                "{length}"
            );
        }
    }
}
