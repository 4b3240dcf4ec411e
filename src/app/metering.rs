//! The meters of an open scene, which `sunroom measure` and the window read.

use std::collections::HashMap;

use bevy::math::Vec3;
use bevy::prelude::{Entity, Name, Without, World};

use crate::meter::daylight::{lit_by, overcast_sky};
use crate::meter::job::MeterError;
use crate::meter::sites::{AskedMeter, MOST_POINTS_OF_SCENE, MeterKind, MeterLimits};
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::scene::{DocumentOrder, Emitter, EmitterKind, Hidden, ToWorld};

/// An emitter with all that a meter's place and name depend on.
pub type MeterParts<'a> = (Entity, &'a DocumentOrder, &'a Emitter, &'a ToWorld, Option<&'a Name>);

/// The meters of the scene that are not hidden, in the order of the file.
pub fn asked_meters(world: &mut World) -> Vec<AskedMeter> {
    let mut emitters = world.query_filtered::<MeterParts, Without<Hidden>>();
    let meters = meters_among(emitters.iter(world));
    meters.into_iter().map(|(_, asked)| asked).collect()
}

/// The meters among emitters, in the order of the file. Meters without a name are numbered by their kinds.
pub fn meters_among<'a>(emitters: impl Iterator<Item = MeterParts<'a>>) -> Vec<(Entity, AskedMeter)> {
    let mut meters: Vec<_> = emitters
        .filter_map(|parts| Some((parts, measured(&parts.2.kind)?)))
        .collect();
    meters.sort_by_key(|((_, order, ..), _)| **order);
    let mut nameless: HashMap<&str, u32> = HashMap::new();
    let asked = meters
        .into_iter()
        .map(|((entity, _, emitter, to_world, name), (kind, limits))| {
            let label = emitter.info().label;
            // The name of a thing without an id is its plugin.
            let name = name.filter(|name| name.as_str() != emitter.plugin());
            let name = name.map(|name| name.as_str().to_owned()).unwrap_or_else(|| {
                let number = nameless.entry(label).or_default();
                *number += 1;
                format!("{label} {number}")
            });
            let world_from_meter = to_world.0;
            let asked = AskedMeter {
                name,
                world_from_meter,
                kind,
                limits,
            };
            (entity, asked)
        });
    asked.collect()
}

/// The problems with the meters of an open scene: a sentence for each.
pub fn meter_faults(world: &mut World) -> Vec<String> {
    let (mut faults, mut points) = (Vec::new(), 0);
    for asked in asked_meters(world) {
        match asked.sites() {
            Ok(sites) => points += sites.texels.texels.len(),
            Err(error) => faults.push(format!("{}: {error}", asked.name)),
        }
    }
    if points > MOST_POINTS_OF_SCENE {
        faults.push(MeterError::TooManyPoints(points).to_string());
    }
    faults
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

/// The upward direction of an overcast sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Upward {
    /// The unit vector in the world.
    pub direction: Vec3,
    /// The thing that says so.
    pub source: &'static str,
}

/// The scene and the view under an overcast sky in place of all lights, for daylight factors.
pub fn under_overcast_sky(scene: &RenderScene, view: &View, up: Vec3) -> (RenderScene, View) {
    let view = View {
        // It knows where the light of the scene's own lights comes from.
        guide: None,
        ..view.clone()
    };
    (lit_by(scene, overcast_sky(up)), view)
}

/// The upward direction of a scene: that of its first sky, or else the axis of the world nearest to the camera's.
pub fn upward<'a>(emitters: impl Iterator<Item = MeterParts<'a>>, view: &View) -> Upward {
    let of_sky = |emitter: &Emitter, to_world: &ToWorld| {
        let axes = to_world.0.matrix3;
        match emitter.kind {
            EmitterKind::SunSky(_) => Vec3::from(axes.z_axis).try_normalize(),
            EmitterKind::Environment { .. } => Vec3::from(axes.y_axis).try_normalize(),
            _ => None,
        }
    };
    let skies = emitters.filter_map(|(_, order, emitter, to_world, _)| Some((*order, of_sky(emitter, to_world)?)));
    if let Some((_, direction)) = skies.min_by_key(|(order, _)| *order) {
        let source = "the sky of the scene";
        return Upward { direction, source };
    }
    let axes = Vec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    let of_camera = |axis: &Vec3| view.camera.direction_in_camera(*axis).y;
    let nearest = axes.max_by(|a, b| of_camera(a).total_cmp(&of_camera(b)));
    Upward {
        direction: nearest.unwrap_or(Vec3::Y),
        source: "the camera",
    }
}
