//! The verb `set`: finds the component of a thing that has a parameter, and makes the command that changes it.

use bevy::prelude::*;

use super::assign::{self, AssignError};
use super::error::ScriptError;
use super::names::{material_of, medium_of, named};
use super::verb::verbs;
use crate::app::editor::command::ValueEdit;
use crate::app::editor::command::lamps::{PhotometricValue, strength_of};
use crate::app::editor::command::material_tree::materials_inside;
use crate::app::editor::commands::things::pose_of;
use crate::app::editor::model::gather_light::measures_of;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::document::suggest::did_you_mean;
use crate::photometry::lamps::{LAMPS, Lamp};
use crate::scene::{AreaLight, Emitter, EulerAngles, Film, LengthUnit, Material, Medium, Sensor, Shape};

verbs! {
    VERBS(world):
    "set" "NAME PARAMETER VALUE"
        [name, parameter, value @ ..] if !value.is_empty() => {
            let entity = named(world, name)?;
            set(world, entity, parameter, &value.join(" "))?
        };
    "lamp" "NAME LAMP"
        [name, lamp] => {
            let entity = named(world, name)?;
            let lamp = Lamp::of_name(lamp).ok_or_else(|| unknown_lamp(lamp))?;
            let parameter = strength_of(lamp, &measures_of(world, entity));
            let parameter = parameter.ok_or("the lamp is of another kind than the thing")?;
            let value = PhotometricValue::from(lamp);
            // Lights with the colours of a picture keep them.
            let alone = PhotometricValue { color: None, ..value };
            let shone = shine(world, entity, &value, Some(parameter));
            shone.or_else(|_| shine(world, entity, &alone, Some(parameter)))?.ok_or("it is no light")?
        };
}

fn unknown_lamp(name: &str) -> String {
    let names: Vec<&str> = LAMPS.iter().map(|lamp| lamp.name).collect();
    format!("there is no lamp `{name}`, only {}", names.join(", "))
}

/// The command that gives a light a value in photometric units; None for a thing that is no light.
fn shine(
    world: &World,
    entity: Entity,
    value: &PhotometricValue,
    parameter: Option<&str>,
) -> Result<Option<ValueEdit>, String> {
    let measures = measures_of(world, entity);
    if let Some(mut emitter) = world.get::<Emitter>(entity).cloned() {
        value.apply(&mut emitter, &measures, parameter)?;
        return Ok(Some(ValueEdit::SetEmitter(entity, emitter)));
    }
    let Some(mut light) = world.get::<AreaLight>(entity).cloned() else {
        return Ok(None);
    };
    value.apply(&mut light, &measures, parameter)?;
    Ok(Some(ValueEdit::SetAreaLight(entity, Some(light))))
}

/// Returns the command that sets a parameter of any component of the thing. The error for an unknown parameter names
/// the known ones.
fn set(world: &mut World, entity: Entity, parameter: &str, value: &str) -> Result<ValueEdit, ScriptError> {
    let mut known = Vec::new();
    if let Some(pose) = pose_of(world, entity) {
        known = vec!["position", "rotation", "scale"];
        if world.get::<Emitter>(entity).is_some() {
            // Some components have a factor of this name.
            known.pop();
        }
        if known.contains(&parameter) {
            let up = world.resource::<ViewSettings>().navigation.up;
            let shape = world.get::<Shape>(entity);
            let rest = shape.map_or(Vec3::ZERO, |shape| shape.rest_angles(up));
            let angles = world.get::<EulerAngles>(entity).copied();
            return Ok(match assign::pose(&pose, parameter, value, angles, rest)? {
                (pose, None) => ValueEdit::Transform(vec![(entity, pose)]),
                (pose, Some(angles)) => ValueEdit::Turn(entity, pose, angles),
            });
        }
    }
    let is_strength = ["intensity", "radiance", "irradiance", "scale", "sun_scale", "sky_scale"].contains(&parameter);
    if let Some(photometric) = PhotometricValue::parse(value).filter(|_| is_strength)
        && let Some(edit) = shine(world, entity, &photometric, Some(parameter))?
    {
        return Ok(edit);
    }
    // This error is more informative than that of a component without the parameter.
    let mut wrong_value = None;
    macro_rules! attempt {
        ($of:expr, $component:ty, $assign:expr, $command:expr) => {
            if let Some(mut edited) = world.get::<$component>($of).cloned() {
                match $assign(&mut edited, parameter, value) {
                    Ok(()) => return Ok($command(edited)),
                    Err(AssignError::Unknown { known: names }) => known.extend(names),
                    Err(error) => wrong_value = wrong_value.or(Some(error)),
                }
            }
        };
    }
    attempt!(entity, Shape, assign::shape, |edited| ValueEdit::SetShape(
        entity, edited
    ));
    attempt!(entity, AreaLight, assign::area_light, |edited| ValueEdit::SetAreaLight(
        entity,
        Some(edited)
    ));
    attempt!(entity, Emitter, assign::emitter, |edited| ValueEdit::SetEmitter(
        entity, edited
    ));
    attempt!(entity, Sensor, assign::sensor, |edited| ValueEdit::SetSensor(
        entity, edited
    ));
    attempt!(entity, Film, assign::film, |edited| ValueEdit::SetFilm(entity, edited));
    let material = material_of(world, entity);
    if let Some(material) = material {
        attempt!(material, Material, assign::material, |edited| ValueEdit::SetMaterial(
            material,
            Box::new(edited)
        ));
    }
    let unit = world.get_resource::<LengthUnit>().copied().unwrap_or_default();
    let assign_medium =
        |medium: &mut Medium, parameter: &str, text: &str| assign::medium(medium, parameter, text, unit);
    if let Some(medium) = medium_of(world, entity) {
        attempt!(medium, Medium, assign_medium, |edited| ValueEdit::SetMedium(
            medium,
            Box::new(edited)
        ));
    }
    Err(match wrong_value {
        Some(error) => error.into(),
        None => no_parameter(world, parameter, &known, material).into(),
    })
}

/// The message about a thing with parameters called `known`, and `material`, but no such parameter.
fn no_parameter(world: &World, parameter: &str, known: &[&str], material: Option<Entity>) -> String {
    if let Some(help) = did_you_mean(parameter, known.iter().copied()) {
        return format!("there is no `{parameter}`; {help}");
    }
    let instead = match known {
        [] => String::new(),
        known => format!(", only {}", known.join(", ")),
    };
    let inside = material.map_or(Vec::new(), |material| materials_inside(world, material));
    let inside: Vec<String> = inside
        .into_iter()
        .filter_map(|inner| Some(format!("`{}`", world.get::<Name>(inner)?)))
        .collect();
    let elsewhere = match &inside[..] {
        [] => String::new(),
        inside => format!("; the material is made of {}", inside.join(" and ")),
    };
    format!("there is no `{parameter}`{instead}{elsewhere}")
}
