//! Packs emitters that are not surfaces, and the radiance of those that are.

use std::f32::consts::PI;
use std::path::Path;

use bevy::math::Affine3A;

use super::Checker;
use super::environment::Environments;
use super::texture::TexturePacker;
use super::view::rigid;
use crate::color::Rgb;
use crate::light::{Atmosphere, LightSource, Luminaire, Projector, Spot, WeightedSource};
use crate::memory::Shortage;
use crate::photometry::LUMENS_PER_WATT;
use crate::scene::{Emitter, EmitterKind, FieldOfView, FovAxis, SunPosition, SunSky};
use crate::texture::Parameter;

/// The context for packing lights.
pub(in crate::engine) struct LightContext<'c, 'p> {
    pub textures: &'c mut TexturePacker<'p>,
    pub environments: &'c mut Environments,
    /// Messages about lights that do not fit into the memory budget.
    pub shortages: &'c mut Vec<String>,
}

impl LightContext<'_, '_> {
    /// Notes that the picture of a light cannot be sampled.
    fn report_shortage(&mut self, name: &str, picture: &Path, shortage: &Shortage) {
        let file = picture.display();
        self.shortages.push(format!(
            "{name}: sampling its picture {file} needs {shortage}; the light is left out"
        ));
    }
}

/// None for a light without a valid position or direction, and for one whose picture is not available yet.
pub(in crate::engine) fn pack_emitter(
    emitter: &Emitter,
    to_world: Affine3A,
    context: &mut LightContext,
    check: &mut Checker,
) -> Option<WeightedSource> {
    let emitter = check.emitter(emitter);
    let source = match &emitter.kind {
        EmitterKind::Point { intensity } => {
            let position = glam::Vec3::from(to_world.translation);
            if !position.is_finite() {
                check.report("its position is not finite, the light is left out");
                return None;
            }
            LightSource::Point {
                position,
                intensity: *intensity,
            }
        }
        EmitterKind::Directional { irradiance } => {
            let Some(direction) = glam::Vec3::from(to_world.matrix3.z_axis).try_normalize() else {
                check.report("it has no direction, the light is left out");
                return None;
            };
            LightSource::Directional {
                direction,
                irradiance: *irradiance,
            }
        }
        EmitterKind::Constant { radiance } => LightSource::Constant { radiance: *radiance },
        EmitterKind::Environment {
            picture,
            scale,
            mis_compensation,
        } => {
            let image = context.textures.picture(picture)?;
            let map = match context.environments.get(&image, *mis_compensation) {
                Ok(map) => map,
                Err(shortage) => {
                    context.report_shortage(check.name, picture, &shortage);
                    return None;
                }
            };
            LightSource::Environment {
                map,
                world_from_local: turning(to_world, check)?,
                scale: *scale,
            }
        }
        EmitterKind::Spot {
            intensity,
            cone,
            texture,
        } => {
            let white = Parameter::Constant(Rgb::ONE);
            LightSource::Spot(Spot {
                world_from_local: invertible(to_world, check)?,
                intensity: *intensity,
                cutoff_angle: cone.cutoff_angle.to_radians(),
                beam_angle: cone.beam_width.to_radians(),
                texture: texture
                    .as_ref()
                    .map_or(white, |texture| context.textures.parameter(texture)),
            })
        }
        EmitterKind::Luminaire { profile, scale, flux } => {
            let image = context.textures.picture(profile)?;
            let map = match context.environments.get(&image, false) {
                Ok(map) => map,
                Err(shortage) => {
                    context.report_shortage(check.name, profile, &shortage);
                    return None;
                }
            };
            let own_flux = 4.0 * PI * LUMENS_PER_WATT * map.mean_luminance();
            let factor = if *flux > 0.0 && own_flux > 0.0 {
                flux / own_flux
            } else {
                1.0
            };
            LightSource::Luminaire(Luminaire {
                position: glam::Vec3::from(invertible(to_world, check)?.translation),
                world_from_local: turning(to_world, check)?,
                map,
                scale: *scale * factor,
            })
        }
        EmitterKind::Projector {
            irradiance,
            scale,
            field_of_view: FieldOfView { fov, axis },
        } => LightSource::Projector(Projector {
            world_from_local: invertible(to_world, check)?,
            irradiance: context.textures.packed(irradiance),
            scale: *scale,
            half_size: half_size(*fov, *axis, context.textures.aspect(irradiance)),
        }),
        EmitterKind::ReflectionProbe { .. }
        | EmitterKind::IrradianceVolume { .. }
        | EmitterKind::IlluminanceMeter { .. }
        | EmitterKind::IlluminanceGrid { .. }
        | EmitterKind::MarkerPoint
        | EmitterKind::MarkerBox
        | EmitterKind::MarkerSphere
        | EmitterKind::MarkerPath => return None,
        EmitterKind::SunSky(sky) => {
            let world_from_local = turning(to_world, check)?;
            LightSource::SunSky {
                atmosphere: atmosphere(sky, world_from_local, check)?,
                world_from_local,
            }
        }
    };
    Some(WeightedSource {
        source,
        sampling_weight: emitter.sampling_weight,
    })
}

/// Half the size of a projector's picture on the plane z = 1; `aspect` is width over height.
pub(in crate::engine) fn half_size(fov: f32, axis: FovAxis, aspect: f32) -> glam::Vec2 {
    let half_width = (0.5 * axis.horizontal(fov, aspect)).to_radians().tan();
    glam::Vec2::new(half_width, half_width / aspect)
}

/// Packs the atmosphere. None, with a report, for a sun without a direction.
fn atmosphere(sky: &SunSky, world_from_local: glam::Mat3, check: &mut Checker) -> Option<Atmosphere> {
    let atmosphere = sky.atmosphere(world_from_local);
    if atmosphere.is_none() {
        check.report(match sky.sun {
            SunPosition::Direction(_) => "`sun_direction` has no length, the light is left out",
            SunPosition::PlaceAndTime(_) => "the sun stands nowhere at such a place and time, the light is left out",
        });
    }
    atmosphere
}

/// The largest deviation of a map from one that only rotates and scales uniformly, relative to its scale.
const UNEVEN: f32 = 1e-3;

/// The rotation (and mirroring) of an emitter at infinity; stretching is reported, because it has no effect.
fn turning(to_world: Affine3A, check: &mut Checker) -> Option<glam::Mat3> {
    let Some(rigid) = rigid(to_world) else {
        check.report("its transform is degenerate, the light is left out");
        return None;
    };
    let (turned, given) = (glam::Mat3::from(rigid.matrix3), glam::Mat3::from(to_world.matrix3));
    let scale = given.z_axis.length();
    if !(given * scale.recip()).abs_diff_eq(turned, UNEVEN) {
        check.report("its transform stretches it: only the turning has an effect");
    }
    Some(turned)
}

/// Checks that a transform can be inverted. None, with a report, if not.
fn invertible(to_world: Affine3A, check: &mut Checker) -> Option<Affine3A> {
    if !to_world.is_finite() || !to_world.inverse().is_finite() {
        check.report("its transform is degenerate, the light is left out");
        return None;
    }
    Some(to_world)
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use bevy::math::Vec3;

    use super::*;
    use crate::texture::Image;

    fn pack(kind: EmitterKind, to_world: Affine3A) -> (Option<LightSource>, Vec<String>) {
        let mut errors = Vec::new();
        let mut check = Checker {
            name: "lamp",
            errors: &mut errors,
        };
        let picture = |path: &Path| (path == Path::new("/sky.exr")).then(|| Arc::new(Image::uniform(2.0)));
        let mut context = LightContext {
            textures: &mut TexturePacker::new(&picture),
            environments: &mut Environments::default(),
            shortages: &mut Vec::new(),
        };
        let light = pack_emitter(&kind.into(), to_world, &mut context, &mut check);
        (light.map(|light| light.source), errors)
    }

    #[test]
    fn a_directional_light_goes_along_z_whatever_the_scale() {
        let to_world = Affine3A::from_rotation_y(90f32.to_radians()) * Affine3A::from_scale(Vec3::splat(5.0));
        let (light, errors) = pack(EmitterKind::Directional { irradiance: Rgb::ONE }, to_world);
        let Some(LightSource::Directional { direction, .. }) = light else {
            panic!("{light:?}")
        };
        assert!(direction.abs_diff_eq(Vec3::X, 1e-6), "{direction}");
        assert!(errors.is_empty());
    }

    #[test]
    fn impossible_lights_are_left_out_and_reported() {
        let nowhere = Affine3A::from_translation(Vec3::INFINITY);
        let sky = |sun| {
            EmitterKind::SunSky(SunSky {
                sun,
                ..SunSky::default()
            })
        };
        for (kind, to_world) in [
            (EmitterKind::Point { intensity: Rgb::ONE }, nowhere),
            (EmitterKind::Directional { irradiance: Rgb::ONE }, Affine3A::ZERO),
            (sky(SunPosition::Direction(Vec3::ZERO)), Affine3A::IDENTITY),
            (sky(SunPosition::Direction(Vec3::Z)), Affine3A::ZERO),
            (Emitter::of_plugin("spot").unwrap().kind, Affine3A::ZERO),
            (Emitter::of_plugin("projector").unwrap().kind, nowhere),
        ] {
            let (light, errors) = pack(kind, to_world);
            assert_eq!((light, errors.len()), (None, 1), "{errors:?}");
        }
        let (light, errors) = pack(EmitterKind::Constant { radiance: Rgb::NAN }, Affine3A::IDENTITY);
        let black = LightSource::Constant { radiance: Rgb::ZERO };
        assert_eq!((light, errors.len()), (Some(black), 1));
    }

    #[test]
    fn an_environment_waits_for_its_picture_and_turns_with_its_transform() {
        let environment = |path: &str| EmitterKind::Environment {
            picture: path.into(),
            scale: 1.0,
            mis_compensation: true,
        };
        assert_eq!(pack(environment("/no.exr"), Affine3A::IDENTITY), (None, Vec::new()));
        // The map doubles the size and mirrors, which is a rotation.
        let mirrored = Affine3A::from_rotation_y(0.5) * Affine3A::from_scale(Vec3::new(-2.0, 2.0, 2.0));
        let (light, errors) = pack(environment("/sky.exr"), mirrored);
        let Some(LightSource::Environment { world_from_local, .. }) = light else {
            panic!("{light:?}")
        };
        assert!((2.0 * world_from_local).abs_diff_eq(glam::Mat3::from(mirrored.matrix3), 1e-5));
        assert!(errors.is_empty(), "{errors:?}");
        let stretched = Affine3A::from_scale(Vec3::new(1.0, 3.0, 1.0));
        let (light, errors) = pack(environment("/sky.exr"), stretched);
        assert!(light.is_some() && errors.len() == 1, "{errors:?}");
    }

    #[test]
    fn a_sun_stands_in_the_world() {
        // The sky's z is the world's y.
        let to_world = Affine3A::from_rotation_x(-90f32.to_radians());
        let sun = SunPosition::Direction(Vec3::new(0.0, 3.0, 0.0));
        let (light, _) = pack(
            EmitterKind::SunSky(SunSky {
                sun,
                ..SunSky::default()
            }),
            to_world,
        );
        let Some(LightSource::SunSky { atmosphere, .. }) = light else {
            panic!("{light:?}")
        };
        let sun = atmosphere.sun_direction;
        assert!(sun.abs_diff_eq(Vec3::Z, 1e-6), "{sun}");
    }
}
