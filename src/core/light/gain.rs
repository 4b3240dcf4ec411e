//! The factor by which a light has become stronger. Light transport is linear: known light from a lamp stays correct if
//! it is multiplied by that factor.

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
        use LightSource as L;
        if self == old {
            return Some(Rgb::ONE);
        }
        // The old light with the strength of the new one: the two must be equal.
        let (as_strong, gain) = match (old.clone(), self) {
            (
                L::Surface {
                    radiance,
                    instance,
                    slot,
                    is_two_sided,
                },
                L::Surface { radiance: new, .. },
            ) => {
                let (Parameter::Constant(before), Parameter::Constant(now)) = (radiance, *new) else {
                    return None;
                };
                let radiance = *new;
                (
                    L::Surface {
                        radiance,
                        instance,
                        slot,
                        is_two_sided,
                    },
                    ratio(before, now)?,
                )
            }
            (
                L::Point {
                    position,
                    intensity: before,
                },
                &L::Point { intensity, .. },
            ) => (L::Point { position, intensity }, ratio(before, intensity)?),
            (
                L::Directional {
                    direction,
                    irradiance: before,
                },
                &L::Directional { irradiance, .. },
            ) => (L::Directional { direction, irradiance }, ratio(before, irradiance)?),
            (L::Constant { radiance: before }, &L::Constant { radiance }) => {
                (L::Constant { radiance }, ratio(before, radiance)?)
            }
            (L::Spot(mut spot), L::Spot(new)) => {
                let gain = ratio(spot.intensity, new.intensity)?;
                spot.intensity = new.intensity;
                (L::Spot(spot), gain)
            }
            (L::Projector(mut projector), L::Projector(new)) => {
                let gain = ratio(Rgb::splat(projector.scale), Rgb::splat(new.scale))?;
                projector.scale = new.scale;
                (L::Projector(projector), gain)
            }
            (
                L::Environment {
                    map,
                    world_from_local,
                    scale: before,
                },
                L::Environment {
                    map: new_map, scale, ..
                },
            ) if Arc::ptr_eq(&map, new_map) => {
                let gain = ratio(Rgb::splat(before), Rgb::splat(*scale))?;
                (
                    L::Environment {
                        map,
                        world_from_local,
                        scale: *scale,
                    },
                    gain,
                )
            }
            (
                L::SunSky {
                    mut atmosphere,
                    world_from_local,
                },
                L::SunSky { atmosphere: new, .. },
            ) => {
                let sky = ratio(Rgb::splat(atmosphere.sky_scale), Rgb::splat(new.sky_scale))?;
                let sun = ratio(Rgb::splat(atmosphere.sun_scale), Rgb::splat(new.sun_scale))?;
                let (has_sky, has_sun) = (atmosphere.sky_scale > 0.0, atmosphere.sun_scale > 0.0);
                (atmosphere.sky_scale, atmosphere.sun_scale) = (new.sky_scale, new.sun_scale);
                let gain = match (has_sky, has_sun) {
                    (true, false) => sky,
                    (false, _) => sun,
                    (true, true) if is_about(sky, sun) => sky,
                    (true, true) => return None,
                };
                (
                    L::SunSky {
                        atmosphere,
                        world_from_local,
                    },
                    gain,
                )
            }
            _ => return None,
        };
        (as_strong == *self).then_some(gain)
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
