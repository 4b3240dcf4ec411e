//! Emitters that are no surface.

use bevy::math::Affine3A;

use super::{BRIGHTEST, Checker};
use crate::color::Rgb;
use crate::light::LightSource;
use crate::scene::Emitter;

/// A colour of light: finite and not negative.
pub(super) fn emission(what: &str, value: Rgb, check: &mut Checker) -> Rgb {
    check.color(what, value, BRIGHTEST)
}

/// None for a light that cannot be: nowhere, or going nowhere.
pub(in crate::engine) fn pack_emitter(
    emitter: &Emitter,
    to_world: Affine3A,
    check: &mut Checker,
) -> Option<LightSource> {
    match *emitter {
        Emitter::Point { intensity } => {
            let position = glam::Vec3::from(to_world.translation);
            if !position.is_finite() {
                check.report("its position is not finite, the light is left out");
                return None;
            }
            Some(LightSource::Point {
                position,
                intensity: emission("intensity", intensity, check),
            })
        }
        Emitter::Directional { irradiance } => {
            let Some(direction) = glam::Vec3::from(to_world.matrix3.z_axis).try_normalize() else {
                check.report("it has no direction, the light is left out");
                return None;
            };
            Some(LightSource::Directional {
                direction,
                irradiance: emission("irradiance", irradiance, check),
            })
        }
        Emitter::Constant { radiance } => Some(LightSource::Constant {
            radiance: emission("radiance", radiance, check),
        }),
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::Vec3;

    use super::*;

    fn pack(emitter: Emitter, to_world: Affine3A) -> (Option<LightSource>, usize) {
        let mut errors = Vec::new();
        let mut check = Checker {
            name: "lamp",
            errors: &mut errors,
        };
        (pack_emitter(&emitter, to_world, &mut check), errors.len())
    }

    #[test]
    fn a_directional_light_goes_along_z_whatever_the_scale() {
        let to_world = Affine3A::from_rotation_y(90f32.to_radians()) * Affine3A::from_scale(Vec3::splat(5.0));
        let (light, errors) = pack(Emitter::Directional { irradiance: Rgb::ONE }, to_world);
        let Some(LightSource::Directional { direction, .. }) = light else {
            panic!("{light:?}")
        };
        assert!(direction.abs_diff_eq(Vec3::X, 1e-6), "{direction}");
        assert_eq!(errors, 0);
    }

    #[test]
    fn impossible_lights_are_left_out_and_reported() {
        let intensity = Rgb::ONE;
        let nowhere = Affine3A::from_translation(Vec3::INFINITY);
        assert_eq!(pack(Emitter::Point { intensity }, nowhere), (None, 1));
        let (light, errors) = pack(Emitter::Directional { irradiance: Rgb::ONE }, Affine3A::ZERO);
        assert_eq!((light, errors), (None, 1));
        let (light, errors) = pack(Emitter::Constant { radiance: Rgb::NAN }, Affine3A::IDENTITY);
        assert_eq!(
            (light, errors),
            (Some(LightSource::Constant { radiance: Rgb::ZERO }), 1)
        );
    }
}
