//! How much light the lights of the scene give in photometric units, for their strengths.

use std::f64::consts::PI;

use bevy::math::{Affine3A, Mat3};

use super::pack::light::half_size;
use crate::color::{Rgb, luminance};
use crate::light::{PictureLight, Projector, Spot};
use crate::photometry::{LUMENS_PER_WATT, LightUnit, Measure};
use crate::scene::{AreaLight, Emitter, EmitterKind, FieldOfView, Parameter, SunSky};
use crate::texture;

/// A measure of the light of one parameter, by its name.
pub type MeasureOf = (&'static str, Measure);

/// The measures of a light that is no shape, the usual unit of each parameter first. `picture` is what its picture of
/// all directions, or the file of its intensities, gives; without it such a light has no measures. `metres`: the length
/// of a unit of the world, on which lumens and candela depend.
pub fn measures_of_emitter(
    emitter: &Emitter,
    to_world: Affine3A,
    picture: Option<PictureLight>,
    metres: f64,
) -> Vec<MeasureOf> {
    use LightUnit::{Candela, Lumen, Lux, Nit};
    let of = |parameter, measures: &[(LightUnit, f64)]| {
        let measure = |&(unit, value): &(LightUnit, f64)| {
            let value = in_metres(unit, value, metres);
            Some((parameter, Measure::new(unit, value)?))
        };
        measures.iter().filter_map(measure).collect()
    };
    match &emitter.kind {
        EmitterKind::Point { .. } => of("intensity", &[(Lumen, 4.0 * PI), (Candela, 1.0)]),
        EmitterKind::Spot { cone, .. } => {
            let spot = Spot {
                world_from_local: to_world,
                intensity: Rgb::ONE,
                cutoff_angle: cone.cutoff_angle.to_radians(),
                beam_angle: cone.beam_width.to_radians(),
                texture: texture::Parameter::Constant(Rgb::ONE),
            };
            of("intensity", &[(Lumen, spot.solid_angle()), (Candela, 1.0)])
        }
        EmitterKind::Directional { .. } => of("irradiance", &[(Lux, 1.0)]),
        EmitterKind::Constant { .. } => of("radiance", &[(Nit, 1.0), (Lux, PI)]),
        EmitterKind::Environment { .. } => {
            let picture = picture.unwrap_or_default();
            let [mean, irradiance] = [picture.mean, picture.irradiance].map(f64::from);
            of("scale", &[(Nit, mean), (Lux, irradiance)])
        }
        EmitterKind::Luminaire { flux, .. } => {
            let picture = picture.unwrap_or_default();
            let own = own_flux(&picture);
            let watts = if *flux > 0.0 { *flux } else { own } / LUMENS_PER_WATT;
            let peak = f64::from(picture.peak) * f64::from(watts * LUMENS_PER_WATT / own);
            of("scale", &[(Lumen, f64::from(watts)), (Candela, peak)])
        }
        EmitterKind::Projector {
            irradiance: Parameter::Constant(_),
            scale,
            field_of_view: FieldOfView { fov, axis },
        } => {
            let projector = Projector {
                world_from_local: to_world,
                irradiance: texture::Parameter::Constant(Rgb::ONE),
                scale: *scale,
                half_size: half_size(*fov, *axis, 1.0),
            };
            let scale = f64::from(*scale);
            of(
                "irradiance",
                &[
                    (Lumen, scale * projector.power_of_one()),
                    (Candela, scale * projector.intensity_of_one()),
                ],
            )
        }
        EmitterKind::SunSky(sky) => of_sky(sky, to_world),
        EmitterKind::Projector { .. }
        | EmitterKind::ReflectionProbe { .. }
        | EmitterKind::IrradianceVolume { .. }
        | EmitterKind::IlluminanceMeter { .. }
        | EmitterKind::IlluminanceGrid { .. }
        | EmitterKind::MarkerPoint
        | EmitterKind::MarkerBox
        | EmitterKind::MarkerSphere
        | EmitterKind::MarkerPath => Vec::new(),
    }
}

/// A value in units of the world in metres. Radiance and irradiance have no length in them here: light that falls with
/// the square of the distance brings as much at a distance of one unit, whatever that is.
fn in_metres(unit: LightUnit, value: f64, metres: f64) -> f64 {
    match unit {
        LightUnit::Lumen | LightUnit::Candela => value * metres * metres,
        LightUnit::Lux | LightUnit::Nit => value,
    }
}

/// The flux in lumens of a file of intensities, which is in the units of [`PictureLight`].
pub fn own_flux(picture: &PictureLight) -> f32 {
    4.0 * std::f32::consts::PI * LUMENS_PER_WATT * picture.mean
}

/// The sun on a surface that faces it, and the sky on one that lies flat.
fn of_sky(sky: &SunSky, to_world: Affine3A) -> Vec<MeasureOf> {
    let plain = SunSky {
        sun_scale: 1.0,
        sky_scale: 1.0,
        ..*sky
    };
    let Some(atmosphere) = plain.atmosphere(Mat3::from(to_world.matrix3)) else {
        return Vec::new();
    };
    let sun = luminance(atmosphere.sun_irradiance());
    let measures = [("sun_scale", sun), ("sky_scale", atmosphere.sky_irradiance())];
    let lux = |(parameter, value)| Some((parameter, Measure::new(LightUnit::Lux, f64::from(value))?));
    measures.into_iter().filter_map(lux).collect()
}

/// The measures of a shape that shines with the same radiance everywhere. `area` is that of one side of its surface in
/// world units, see [`crate::accel::Instance::area`]; without it there are no lumens. `metres` is as in
/// [`measures_of_emitter`].
pub fn measures_of_area_light(light: &AreaLight, area: Option<f64>, metres: f64) -> Vec<MeasureOf> {
    if let Parameter::Texture(_) = light.radiance {
        return Vec::new();
    }
    let sides = if light.two_sided { 2.0 } else { 1.0 };
    let lumens = area.and_then(|area| {
        let watts = in_metres(LightUnit::Lumen, PI * sides * area, metres);
        Measure::new(LightUnit::Lumen, watts)
    });
    let all = [lumens, Measure::new(LightUnit::Nit, 1.0)];
    all.into_iter().flatten().map(|measure| ("radiance", measure)).collect()
}
