//! The factor by which a light has become stronger. Light transport is linear: known light from a lamp stays correct if
//! it is multiplied by that factor.

use std::mem::replace;
use std::sync::Arc;

use super::{LightSource, WeightedSource};
use crate::color::Rgb;
use crate::texture::Parameter;

impl WeightedSource {
    /// The factor per channel that turns the light of `old` into this one's. None if they differ in anything else, or
    /// if a black light has become bright.
    pub fn gain_since(&self, old: &Self) -> Option<Rgb> {
        let gain = self.source.gain_since(&old.source)?;
        (self.sampling_weight == old.sampling_weight).then_some(gain)
    }
}

impl LightSource {
    fn gain_since(&self, old: &Self) -> Option<Rgb> {
        if self == old {
            return Some(Rgb::ONE);
        }
        let mut as_strong = old.clone();
        let gain = as_strong.take_strength(self)?;
        (as_strong == *self).then_some(gain)
    }

    /// Takes the strength of another light of the same kind, and returns the factor on the strength before. None if
    /// there is no such factor.
    fn take_strength(&mut self, new: &Self) -> Option<Rgb> {
        use LightSource as L;
        let of_scale = |scale: &mut f32, new: f32| ratio(Rgb::splat(replace(scale, new)), Rgb::splat(new));
        match (self, new) {
            (L::Surface { radiance, .. }, L::Surface { radiance: new, .. }) => {
                let before = replace(radiance, *new);
                match (before, *new) {
                    (Parameter::Constant(before), Parameter::Constant(now)) => ratio(before, now),
                    _ => None,
                }
            }
            (L::Point { intensity: own, .. }, L::Point { intensity: new, .. })
            | (L::Directional { irradiance: own, .. }, L::Directional { irradiance: new, .. })
            | (L::Constant { radiance: own }, L::Constant { radiance: new }) => ratio(replace(own, *new), *new),
            (L::Spot(own), L::Spot(new)) => ratio(replace(&mut own.intensity, new.intensity), new.intensity),
            (L::Luminaire(own), L::Luminaire(new)) => ratio(replace(&mut own.scale, new.scale), new.scale),
            (L::Projector(own), L::Projector(new)) => of_scale(&mut own.scale, new.scale),
            (
                L::Environment { map, scale, .. },
                L::Environment {
                    map: other, scale: new, ..
                },
            ) if Arc::ptr_eq(map, other) => of_scale(scale, *new),
            (L::SunSky { atmosphere: own, .. }, L::SunSky { atmosphere: new, .. }) => {
                let (has_sky, has_sun) = (own.sky_scale > 0.0, own.sun_scale > 0.0);
                let sky = of_scale(&mut own.sky_scale, new.sky_scale)?;
                let sun = of_scale(&mut own.sun_scale, new.sun_scale)?;
                match (has_sky, has_sun) {
                    (true, false) => Some(sky),
                    (false, _) => Some(sun),
                    (true, true) => is_about(sky, sun).then_some(sky),
                }
            }
            _ => None,
        }
    }
}

/// The common factor of all `new` lights over the `old` ones, light by light. None if they differ in anything else, or
/// by several factors.
pub fn common(old: &[&WeightedSource], new: &[&WeightedSource]) -> Option<Rgb> {
    let is_same_number = old.len() == new.len();
    let mut gains = new.iter().zip(old).map(|(new, old)| new.gain_since(old));
    let first = gains.next().unwrap_or(Some(Rgb::ONE)).filter(|_| is_same_number)?;
    gains
        .all(|gain| gain.is_some_and(|gain| is_about(gain, first)))
        .then_some(first)
}

/// Whether two gains differ by no more than rounding.
fn is_about(one: Rgb, other: Rgb) -> bool {
    (one - other).abs().cmple(1e-5 * one.abs().max(other.abs())).all()
}

/// The factor from one strength to another, per channel.
fn ratio(before: Rgb, now: Rgb) -> Option<Rgb> {
    if now == Rgb::ZERO && before != Rgb::ZERO {
        return Some(Rgb::ZERO);
    }
    let mut ratio = Rgb::ONE;
    for channel in 0..3 {
        if before[channel] != now[channel] {
            ratio[channel] = now[channel] / before[channel];
        }
    }
    ratio.is_finite().then_some(ratio)
}

#[cfg(test)]
mod tests {
    use glam::{Mat3, Vec3};

    use super::*;

    fn gain(new: LightSource, old: LightSource) -> Option<Rgb> {
        WeightedSource::from(new).gain_since(&old.into())
    }

    #[test]
    fn strengths_have_a_ratio_by_colour() {
        let point = |intensity: Rgb, x: f32| LightSource::Point {
            position: Vec3::X * x,
            intensity,
        };
        let (before, now) = (Rgb::new(2.0, 0.0, 4.0), Rgb::new(3.0, 0.0, 1.0));
        assert_eq!(
            gain(point(now, 0.0), point(before, 0.0)),
            Some(Rgb::new(1.5, 1.0, 0.25))
        );
        assert_eq!(gain(point(Rgb::ZERO, 0.0), point(before, 0.0)), Some(Rgb::ZERO));
        assert_eq!(gain(point(now, 1.0), point(before, 0.0)), None);
        // A black light cannot be multiplied to become bright.
        assert_eq!(gain(point(before, 0.0), point(Rgb::ZERO, 0.0)), None);
        let weaker = WeightedSource {
            sampling_weight: 0.5,
            ..point(now, 0.0).into()
        };
        assert_eq!(weaker.gain_since(&point(before, 0.0).into()), None);
    }

    #[test]
    fn surfaces_have_one_if_their_radiance_is_the_same_all_over() {
        let surface = |radiance: f32, slot| LightSource::Surface {
            instance: 1,
            slot,
            radiance: Parameter::Constant(Rgb::splat(radiance)),
            is_two_sided: false,
        };
        assert_eq!(gain(surface(6.0, 0), surface(3.0, 0)), Some(Rgb::splat(2.0)));
        assert_eq!(gain(surface(6.0, 1), surface(3.0, 0)), None);
        let constant = LightSource::Constant { radiance: Rgb::ONE };
        assert_eq!(gain(constant.clone(), surface(3.0, 0)), None);
        assert_eq!(gain(constant.clone(), constant), Some(Rgb::ONE));
    }

    #[test]
    fn sun_and_sky_have_one_if_they_change_together() {
        let light = |sky_scale, sun_scale| LightSource::SunSky {
            atmosphere: super::super::Atmosphere {
                turbidity: 3.0,
                albedo: Rgb::splat(0.2),
                sun_direction: Vec3::Z,
                sky_scale,
                sun_scale,
                sun_aperture: 0.01,
                limb_darkening: false,
            },
            world_from_local: Mat3::IDENTITY,
        };
        assert_eq!(gain(light(2.0, 4.0), light(1.0, 2.0)), Some(Rgb::splat(2.0)));
        assert_eq!(gain(light(2.0, 0.0), light(1.0, 0.0)), Some(Rgb::splat(2.0)));
        assert_eq!(gain(light(1.0, 4.0), light(1.0, 2.0)), None);
        assert_eq!(gain(light(0.0, 4.0), light(0.0, 2.0)), Some(Rgb::splat(2.0)));
    }
}
