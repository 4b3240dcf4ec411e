//! Adds new things.

use bevy::math::{Affine3A, Mat3, Quat};
use bevy::prelude::*;

use super::spot::{self, Spot};
use super::things::{check_name, select_new};
use super::{media, media_boxes, media_upkeep, view};
use crate::app::editor::camera::{pose, rounding};
use crate::app::editor::command::addition::{Addition, AdditionKind};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::lamps::PhotometricValue;
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::color::Rgb;
use crate::engine::{measures_of_area_light, measures_of_emitter};
use crate::photometry::lamps::{Lamp, LampForm};
use crate::scene::insert::next_order;
use crate::scene::names::free_name_for;
use crate::scene::{
    ActiveSensor, AreaLight, Cone, DocumentOrder, Emitter, EmitterKind, Film, InMedium, LengthUnit, SceneId, Sensor,
    Shape, ShapeKind, Solid, ToWorld,
};

/// The height of a light above the surface it shines on, and of a flat entity above the surface it lies on, in half
/// sizes.
const ABOVE: f32 = 4.0;
const FLAT: f32 = 0.01;
/// The golden angle in radians: multiples of it never repeat a direction.
const GOLDEN_ANGLE: f32 = 2.399_963;

pub fn add(edit: &mut Edit, addition: Addition) -> Result<(), CommandError> {
    check_name(addition.name.as_deref().unwrap_or_default())?;
    let up = edit.world.resource::<ViewSettings>().navigation.up;
    let is_light = hangs(addition.kind);
    let spot = match (addition.at, addition.size) {
        _ if !has_spot(addition.kind) => Spot::default(),
        (Some(foot), Some(size)) => Spot { foot, size, on: None },
        (at, size) => {
            let found = spot::find(edit.world, size, lift(addition.kind), is_light);
            match at {
                Some(foot) => Spot {
                    foot,
                    on: None,
                    ..found
                },
                None => found,
            }
        }
    };
    let Spot { foot, size, on } = spot;
    // A light without a given place hangs above the surface that it shines on.
    let above = match addition.at {
        None if is_light && has_spot(addition.kind) => foot + up * spot::headroom(edit.world, &spot, ABOVE * size),
        _ => foot,
    };
    // Places that the user gives are kept, up to the half size that is added to them.
    let placed = |place: Vec3| match addition.at {
        Some(at) => rounding::sum_of_places(at, rounding::without_residue(place - at)),
        None => spot::rounded_place(place, size),
    };
    let above = placed(above);
    // A flat thing must not coincide with the surface below it.
    let ground = match on {
        Some(_) => foot + up * (FLAT * size),
        None => foot,
    };
    let scale = Affine3A::from_scale(Vec3::splat(size));
    let at = |place: Vec3| Affine3A::from_translation(placed(place));
    // For axes that are the world's this gives exact zeros and ones.
    let facing = |direction: Vec3| {
        let (x, y) = direction.any_orthonormal_pair();
        Affine3A::from_mat3(Mat3::from_cols(x, y, direction))
    };
    let order = DocumentOrder(next_order(edit.world));
    let name = addition.name.as_deref().unwrap_or(addition.kind.name());
    let name = free_name_for(edit.world, name);
    let called = (order, SceneId(name.clone()), Name::new(name));
    let shape = |kind| Shape {
        kind,
        ..Shape::default()
    };
    let entity = match addition.kind {
        AdditionKind::Sphere => {
            let (center, radius) = (Vec3::ZERO, size);
            let pose = ToWorld(at(foot + up * size));
            edit.spawn((called, shape(ShapeKind::Sphere { center, radius }), pose))
        }
        AdditionKind::Cube => {
            let pose = ToWorld(at(foot + up * size) * scale);
            edit.spawn((called, shape(ShapeKind::Cube), pose))
        }
        AdditionKind::Fog => media_boxes::surround(edit, addition.name.as_deref().unwrap_or("fog")),
        AdditionKind::FogBox => {
            let name = addition.name.as_deref().unwrap_or("fog-box");
            let middle = foot + up * ((1.0 - media_boxes::SUNK) * size);
            // Through its middle one seventh of the light passes.
            media_boxes::bounded(edit, name, at(middle) * scale, media::fog(size))
        }
        AdditionKind::Rectangle => {
            let pose = ToWorld(at(ground) * facing(up) * scale);
            edit.spawn((called, shape(ShapeKind::Rectangle), pose))
        }
        AdditionKind::Disk => {
            let pose = ToWorld(at(ground) * facing(up) * scale);
            edit.spawn((called, shape(ShapeKind::Disk), pose))
        }
        AdditionKind::Cylinder => {
            let kind = ShapeKind::Cylinder {
                p0: Vec3::ZERO,
                p1: 2.0 * size * Vec3::Z,
                radius: size,
            };
            let pose = ToWorld(at(foot) * facing(up));
            edit.spawn((called, shape(kind), pose))
        }
        AdditionKind::Solid(plugin) => {
            let part = Solid::of_plugin(plugin).ok_or_else(|| format!("There is no shape called \"{plugin}\"."))?;
            let part = part.clone().scaled(solid_scale(&part, size, addition.size.is_some()));
            let [low, high] = part.corners();
            let middle = Vec3::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), 0.0);
            let pose = ToWorld(at(foot) * facing(up) * Affine3A::from_translation(-middle));
            edit.spawn((called, shape(ShapeKind::Solid(part)), pose))
        }
        AdditionKind::AreaLight => {
            let pose = ToWorld(at(above) * facing(-up) * scale);
            let light = AreaLight {
                radiance: Rgb::splat(10.0).into(),
                ..AreaLight::default()
            };
            edit.spawn((called, shape(ShapeKind::Rectangle), pose, light))
        }
        AdditionKind::Camera => {
            let (view, sensor, film) = camera(edit.world);
            // At another place it looks as the view does.
            let translation = addition.at.map_or(view.translation, Into::into);
            let active = edit.world.resource::<ActiveSensor>().0;
            let medium = active.and_then(|active| media_upkeep::medium_at(edit.world, active, translation.into()));
            let camera = edit.spawn((called, sensor, film, ToWorld(Affine3A { translation, ..view })));
            if let Some(medium) = medium {
                edit.set(camera, InMedium(medium));
            }
            camera
        }
        AdditionKind::Lamp(lamp) => {
            let hung = at(above) * facing(-up);
            add_lamp(edit, lamp, addition.name.as_deref(), called, hung, up)?
        }
        AdditionKind::Emitter(plugin) => {
            let emitter = emitter(plugin, above.distance(foot).max(size))?;
            let pose = match emitter.kind {
                EmitterKind::Constant { .. } => Affine3A::IDENTITY,
                EmitterKind::Environment { .. } => turned_up(up, Vec3::Y),
                // The sky of the model is above its xy plane.
                EmitterKind::SunSky(_) => turned_up(up, Vec3::Z),
                EmitterKind::Directional { .. } => facing(free_direction(&sun_directions(edit.world), up)),
                EmitterKind::ReflectionProbe { .. } | EmitterKind::IrradianceVolume { .. } => at(above) * scale,
                EmitterKind::IlluminanceMeter { .. } => at(ground) * facing(up),
                EmitterKind::IlluminanceGrid { .. } => at(ground) * facing(up) * scale,
                EmitterKind::MarkerPoint => at(foot) * upright(up),
                EmitterKind::MarkerBox | EmitterKind::MarkerSphere => at(foot + up * size) * upright(up) * scale,
                EmitterKind::MarkerPath => at(foot) * upright(up) * scale,
                _ => at(above) * facing(-up),
            };
            if emitter.is_sky() {
                set_sky(edit, emitter, pose, addition.name.as_deref().unwrap_or(plugin))
            } else {
                let properties = emitter.new_properties();
                let entity = edit.spawn((called, emitter, ToWorld(pose)));
                if let Some(properties) = properties {
                    edit.set(entity, properties);
                }
                entity
            }
        }
    };
    select_new(edit, vec![entity]);
    Ok(())
}

/// Adds a lamp of the table. `hung` is the pose of one with a place, which shines down.
fn add_lamp(
    edit: &mut Edit,
    lamp: &'static Lamp,
    name: Option<&str>,
    called: (DocumentOrder, SceneId, Name),
    hung: Affine3A,
    up: Vec3,
) -> Result<Entity, CommandError> {
    let metres = edit
        .world
        .get_resource::<LengthUnit>()
        .map_or(1.0, |unit| unit.metres());
    Ok(match new_lamp(lamp, metres)? {
        NewLamp::Shape(kind, light, scale) => {
            let shape = Shape {
                kind,
                ..Shape::default()
            };
            let pose = ToWorld(hung * Affine3A::from_scale(scale));
            edit.spawn((called, shape, pose, light))
        }
        NewLamp::Sky(emitter) => set_sky(edit, emitter, Affine3A::IDENTITY, name.unwrap_or(lamp.name)),
        NewLamp::Parallel(emitter) => {
            let direction = free_direction(&sun_directions(edit.world), up);
            let (x, y) = direction.any_orthonormal_pair();
            let pose = Affine3A::from_mat3(Mat3::from_cols(x, y, direction));
            edit.spawn((called, emitter, ToWorld(pose)))
        }
        NewLamp::Placed(emitter) => edit.spawn((called, emitter, ToWorld(hung))),
    })
}

/// The parts of a new lamp.
enum NewLamp {
    /// A shape with its light, and its scale.
    Shape(ShapeKind, AreaLight, Vec3),
    /// Light from all directions.
    Sky(Emitter),
    /// Light from one direction.
    Parallel(Emitter),
    /// A light with a place.
    Placed(Emitter),
}

/// A lamp of the table in a scene whose unit of length has so many metres.
fn new_lamp(lamp: &'static Lamp, metres: f64) -> Result<NewLamp, CommandError> {
    let value = PhotometricValue::from(lamp);
    let units = |length: f32| (f64::from(length) / metres) as f32;
    let emitter = |kind: EmitterKind| -> Result<Emitter, String> {
        let mut emitter = Emitter::from(kind);
        let measures = measures_of_emitter(&emitter, Affine3A::IDENTITY, None, metres);
        value.apply(&mut emitter, &measures, None)?;
        Ok(emitter)
    };
    let shape = |kind: ShapeKind, scale: Vec3, area: f32| -> Result<NewLamp, String> {
        let mut light = AreaLight::default();
        let measures = measures_of_area_light(&light, Some(f64::from(area)), metres);
        value.apply(&mut light, &measures, None)?;
        Ok(NewLamp::Shape(kind, light, scale))
    };
    Ok(match lamp.form {
        LampForm::Point => NewLamp::Placed(emitter(EmitterKind::Point { intensity: Rgb::ONE })?),
        LampForm::Spot { cutoff, beam } => NewLamp::Placed(emitter(EmitterKind::Spot {
            intensity: Rgb::ONE,
            cone: Cone {
                cutoff_angle: cutoff,
                beam_width: beam,
            },
            texture: None,
        })?),
        LampForm::Rectangle { size } => {
            let [width, height] = size.map(units);
            let scale = 0.5 * Vec3::new(width, height, width.min(height));
            shape(ShapeKind::Rectangle, scale, width * height)?
        }
        LampForm::Tube { radius, length } => {
            let [radius, length] = [radius, length].map(units);
            let half = 0.5 * length * Vec3::X;
            let kind = ShapeKind::Cylinder {
                p0: -half,
                p1: half,
                radius,
            };
            shape(kind, Vec3::ONE, std::f32::consts::TAU * radius * length)?
        }
        LampForm::Parallel => NewLamp::Parallel(emitter(EmitterKind::Directional { irradiance: Rgb::ONE })?),
        LampForm::Sky => NewLamp::Sky(emitter(EmitterKind::Constant { radiance: Rgb::ONE })?),
    })
}

/// A frame whose y is up, and whose z is level: the direction of a marker.
fn upright(up: Vec3) -> Affine3A {
    let level = match up.abs() == Vec3::Y {
        true => Vec3::Z,
        false => up.any_orthonormal_vector(),
    };
    Affine3A::from_mat3(Mat3::from_cols(up.cross(level), up, level))
}

/// A light that illuminates things at `distance` world units about as much as a white sky would.
fn emitter(plugin: &'static str, distance: f32) -> Result<Emitter, CommandError> {
    let mut emitter = Emitter::of_plugin(plugin).ok_or_else(|| format!("There is no light called \"{plugin}\"."))?;
    match &mut emitter.kind {
        EmitterKind::Environment { .. } => {
            return Err("An environment map comes with its picture: import that.".into());
        }
        EmitterKind::Luminaire { .. } => return Err("An IES lamp comes with its file: import that.".into()),
        EmitterKind::Projector { .. } => {}
        EmitterKind::Point { intensity } | EmitterKind::Spot { intensity, .. } => {
            *intensity = Rgb::splat(spot::rounded(std::f32::consts::PI * distance * distance));
        }
        EmitterKind::Directional { irradiance } => *irradiance = Rgb::splat(2.0),
        EmitterKind::IrradianceVolume { spacing } | EmitterKind::IlluminanceGrid { spacing, .. } => {
            *spacing = spot::rounded(0.25 * distance);
        }
        EmitterKind::Constant { .. }
        | EmitterKind::SunSky(_)
        | EmitterKind::ReflectionProbe { .. }
        | EmitterKind::IlluminanceMeter { .. }
        | EmitterKind::MarkerPoint
        | EmitterKind::MarkerBox
        | EmitterKind::MarkerSphere
        | EmitterKind::MarkerPath => {}
    }
    Ok(emitter)
}

/// The factor on the numbers of a building part, whose defaults are metres. `size` is half its height if it is given.
/// Else it keeps its numbers unless the view shows that the scene is of another scale.
fn solid_scale(part: &Solid, size: f32, is_given: bool) -> f32 {
    let [low, high] = part.corners();
    let factor = 2.0 * size / (high.z - low.z);
    let is_usual = !is_given && (0.1..=10.0).contains(&factor);
    if is_usual { 1.0 } else { factor }
}

/// The height of a thing's position above its foot, in half sizes.
fn lift(kind: AdditionKind) -> f32 {
    match kind {
        AdditionKind::Sphere | AdditionKind::Cube | AdditionKind::FogBox => 1.0,
        AdditionKind::Rectangle
        | AdditionKind::Disk
        | AdditionKind::Cylinder
        | AdditionKind::Solid(_)
        | AdditionKind::Fog
        | AdditionKind::Camera => 0.0,
        AdditionKind::Emitter("markerbox" | "markersphere") => 1.0,
        AdditionKind::AreaLight | AdditionKind::Emitter(_) | AdditionKind::Lamp(_) if hangs(kind) => ABOVE,
        AdditionKind::AreaLight | AdditionKind::Emitter(_) | AdditionKind::Lamp(_) => 0.0,
    }
}

/// Whether it hangs above the surface below it: lights and probes do, and meters and markers are on the surface.
fn hangs(kind: AdditionKind) -> bool {
    match kind {
        AdditionKind::AreaLight | AdditionKind::Lamp(_) => true,
        AdditionKind::Emitter(plugin) => {
            Emitter::of_plugin(plugin).is_some_and(|emitter| emitter.shines() || emitter.is_probe())
        }
        AdditionKind::Sphere
        | AdditionKind::Rectangle
        | AdditionKind::Cube
        | AdditionKind::Disk
        | AdditionKind::Cylinder
        | AdditionKind::Solid(_)
        | AdditionKind::Fog
        | AdditionKind::FogBox
        | AdditionKind::Camera => false,
    }
}

/// Whether a free spot is searched for, since the kind has a place.
fn has_spot(kind: AdditionKind) -> bool {
    match kind {
        AdditionKind::Camera | AdditionKind::Fog => false,
        AdditionKind::Lamp(lamp) => !matches!(lamp.form, LampForm::Parallel | LampForm::Sky),
        AdditionKind::Emitter(plugin) => Emitter::of_plugin(plugin).is_some_and(|emitter| emitter.has_place()),
        _ => true,
    }
}

/// The directions towards which lights shine that are infinitely far away.
fn sun_directions(world: &mut World) -> Vec<Vec3> {
    let mut emitters = world.query::<(&Emitter, &ToWorld)>();
    let suns = emitters
        .iter(world)
        .filter(|(emitter, _)| matches!(emitter.kind, EmitterKind::Directional { .. }));
    suns.map(|(_, pose)| Vec3::from(pose.0.matrix3.z_axis).normalize_or_zero())
        .collect()
}

/// A direction that points down and aslant and differs from all of these.
fn free_direction(known: &[Vec3], up: Vec3) -> Vec3 {
    let aslant = |turns: usize| {
        let turn = Quat::from_axis_angle(up, GOLDEN_ANGLE * turns as f32);
        (turn * (up.any_orthonormal_vector() * 0.5) - up).normalize_or(-up)
    };
    // The tolerance is well above rounding, and well below what is visible.
    let is_free = |direction: &Vec3| !known.iter().any(|known| known.abs_diff_eq(*direction, 1e-3));
    (0..known.len())
        .map(aslant)
        .find(is_free)
        .unwrap_or_else(|| aslant(known.len()))
}

/// The rotation that takes `from` to `up`.
pub fn turned_up(up: Vec3, from: Vec3) -> Affine3A {
    Affine3A::from_quat(Quat::from_rotation_arc(from, up))
}

/// The pose, sensor and film of the view, as they are of the camera in use.
fn camera(world: &World) -> (Affine3A, Sensor, Film) {
    let active = world.resource::<ActiveSensor>().0;
    let sensor = active
        .and_then(|active| world.get::<Sensor>(active))
        .copied()
        .unwrap_or_default();
    let film = active
        .and_then(|active| world.get::<Film>(active))
        .copied()
        .unwrap_or_default();
    let lens = pose::lens(world).unwrap_or(sensor.lens);
    (
        view::rounded_view(world).unwrap_or_default(),
        Sensor { lens, ..sensor },
        film,
    )
}

/// The environment light, if there is one.
pub fn sky(world: &mut World) -> Option<Entity> {
    let mut emitters = world.query::<(&DocumentOrder, Entity, &Emitter)>();
    let skies = emitters.iter(world).filter(|(.., emitter)| emitter.is_sky());
    skies
        .map(|(order, entity, _)| (*order, entity))
        .min()
        .map(|(_, entity)| entity)
}

/// Two skies would add up, and other programs refuse them.
pub fn set_sky(edit: &mut Edit, emitter: Emitter, pose: Affine3A, name: &str) -> Entity {
    if let Some(known) = sky(edit.world) {
        let keeps_pose = edit
            .world
            .get::<Emitter>(known)
            .is_some_and(|old| old.plugin() == emitter.plugin());
        edit.set(known, emitter);
        if !keeps_pose {
            edit.set(known, ToWorld(pose));
        }
        return known;
    }
    let name = free_name_for(edit.world, name);
    let order = DocumentOrder(next_order(edit.world));
    edit.spawn((order, SceneId(name.clone()), Name::new(name), emitter, ToWorld(pose)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sun_shines_where_no_other_does() {
        let mut suns = Vec::new();
        for _ in 0..3 {
            let next = free_direction(&suns, Vec3::Y);
            assert!(
                next.y < 0.0 && suns.iter().all(|sun: &Vec3| sun.distance(next) > 0.1),
                "{suns:?}"
            );
            suns.push(next);
        }
        // The place of one that was deleted is free again.
        let first = suns.remove(0);
        assert!(free_direction(&suns, Vec3::Y).distance(first) < 1e-3);
    }
}
