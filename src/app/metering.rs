//! The meters of an open scene, which `sunroom measure` and the window read.

use bevy::math::Vec3;
use bevy::prelude::{Name, Without, World};

use crate::meter::daylight::{lit_by, overcast_sky};
use crate::meter::sites::{AskedMeter, MeterKind, MeterLimits};
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::scene::{DocumentOrder, Emitter, EmitterKind, Hidden, ToWorld};

/// The meters of the scene that are not hidden, in the order of the file.
pub fn asked_meters(world: &mut World) -> Vec<AskedMeter> {
    let mut emitters = world.query_filtered::<(&DocumentOrder, &Emitter, &ToWorld, Option<&Name>), Without<Hidden>>();
    let asked = emitters
        .iter(world)
        .filter_map(|(order, emitter, to_world, name)| Some((*order, asked_meter(emitter, to_world, name)?)));
    let mut asked: Vec<(DocumentOrder, AskedMeter)> = asked.collect();
    asked.sort_by_key(|(order, _)| *order);
    asked.into_iter().map(|(_, asked)| asked).collect()
}

/// The meter that an emitter stands for; None for lights and probes.
pub fn asked_meter(emitter: &Emitter, to_world: &ToWorld, name: Option<&Name>) -> Option<AskedMeter> {
    let (kind, limits) = measured(&emitter.kind)?;
    Some(AskedMeter {
        name: name.map_or(emitter.info().label, Name::as_str).to_owned(),
        world_from_meter: to_world.0,
        kind,
        limits,
    })
}

/// What a kind of emitter measures; None for lights and probes.
fn measured(kind: &EmitterKind) -> Option<(MeterKind, MeterLimits)> {
    // As the number is written, of which 0.6 has no exact form.
    let limit = |value: f32| value.to_string().parse().ok().filter(|value: &f64| *value > 0.0);
    match *kind {
        EmitterKind::IlluminanceMeter { least } => {
            let limits = MeterLimits {
                least: limit(least),
                ..MeterLimits::default()
            };
            Some((MeterKind::Point, limits))
        }
        EmitterKind::IlluminanceGrid {
            spacing,
            least,
            mean,
            uniformity,
        } => {
            let limits = MeterLimits {
                least: limit(least),
                mean: limit(mean),
                uniformity: limit(uniformity),
            };
            Some((MeterKind::Grid { spacing }, limits))
        }
        _ => None,
    }
}

/// The scene and the view under an overcast sky in place of all lights, for daylight factors.
pub fn under_overcast_sky(world: &mut World, scene: &RenderScene, view: &View) -> (RenderScene, View) {
    let view = View {
        // It knows where the light of the scene's own lights comes from.
        guide: None,
        ..view.clone()
    };
    (lit_by(scene, overcast_sky(up(world, &view))), view)
}

/// The direction that is up: that of a sky of the scene, or else the axis of the world nearest to the camera's.
fn up(world: &mut World, view: &View) -> Vec3 {
    let mut emitters = world.query_filtered::<(&DocumentOrder, &Emitter, &ToWorld), Without<Hidden>>();
    let of_sky = |emitter: &Emitter, to_world: &ToWorld| {
        let axes = to_world.0.matrix3;
        match emitter.kind {
            EmitterKind::SunSky(_) => Vec3::from(axes.z_axis).try_normalize(),
            EmitterKind::Environment { .. } => Vec3::from(axes.y_axis).try_normalize(),
            _ => None,
        }
    };
    let skies = emitters
        .iter(world)
        .filter_map(|(order, emitter, to_world)| Some((*order, of_sky(emitter, to_world)?)));
    let first = skies.min_by_key(|(order, _)| *order).map(|(_, up)| up);
    let axes = Vec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    let upward = |axis: &Vec3| view.camera.direction_in_camera(*axis).y;
    let nearest = axes.max_by(|a, b| upward(a).total_cmp(&upward(b)));
    first.or(nearest).unwrap_or(Vec3::Y)
}
