//! The meaning of words in a line: things by their names, and counts.

use bevy::prelude::*;

use super::error::ScriptError;
use crate::document::suggest::did_you_mean;
use crate::document::value::{parse_floats, parse_integer};
use crate::scene::{DocumentOrder, Film, InteriorMedium, Material, Medium, SceneId, UsesMaterial};

pub(super) fn unknown<'c>(what: &str, name: &str, known: impl IntoIterator<Item = &'c str>) -> ScriptError {
    let help = did_you_mean(name, known).map_or(String::new(), |help| format!("; {help}"));
    format!("there is no {what} called \"{name}\"{help}").into()
}

/// The thing of this id, or else of this name. Several things of one name are an error, because otherwise the wrong one
/// could be changed unnoticed. Errors depend on the scene, so that literal values should be parsed before.
pub(super) fn named(world: &mut World, name: &str) -> Result<Entity, ScriptError> {
    let mut things = world.query::<(&DocumentOrder, Entity, Option<&SceneId>, Option<&Name>)>();
    let (mut by_id, mut by_name) = (Vec::new(), Vec::new());
    for (_, entity, id, called) in things.iter(world) {
        if id.is_some_and(|id| id.0 == name) {
            by_id.push(entity);
        } else if called.is_some_and(|called| called.as_str() == name) {
            by_name.push(entity);
        }
    }
    match by_id.as_slice() {
        [] => {}
        [entity] => return Ok(*entity),
        several => return Err(ambiguous(name, several.len())),
    }
    match by_name.as_slice() {
        [] => {}
        [entity] => return Ok(*entity),
        several => return Err(ambiguous(name, several.len())),
    }
    let names = crate::scene::insert::names(world);
    Err(unknown("thing", name, names.iter().map(String::as_str)).of_scene())
}

fn ambiguous(name: &str, count: usize) -> ScriptError {
    let message = format!("there are {count} things called \"{name}\": give the one that is meant an id of its own");
    ScriptError::from(message).of_scene()
}

/// Parses a point of the picture.
pub(super) fn parse_place(text: &str) -> Result<Vec2, ScriptError> {
    match parse_floats(text)?[..] {
        [x, y] => Ok(Vec2::new(x, y)),
        _ => Err("expected two numbers".into()),
    }
}

pub(super) fn all_named(world: &mut World, names: &[&str]) -> Result<Vec<Entity>, ScriptError> {
    names.iter().map(|name| named(world, name)).collect()
}

/// A material itself, or the material of a shape.
pub(super) fn material_of(world: &World, entity: Entity) -> Option<Entity> {
    match world.get::<Material>(entity) {
        Some(_) => Some(entity),
        None => world.get::<UsesMaterial>(entity).map(|uses| uses.0),
    }
}

/// A medium itself, or the interior medium of a shape.
pub(super) fn medium_of(world: &World, entity: Entity) -> Option<Entity> {
    match world.get::<Medium>(entity) {
        Some(_) => Some(entity),
        None => world.get::<InteriorMedium>(entity).map(|medium| medium.0),
    }
}

/// Parses a number of samples per pixel, in the range of films.
pub(super) fn sample_count(text: &str) -> Result<u32, ScriptError> {
    let (number, most) = (count(text)?, Film::LARGEST_SAMPLE_COUNT);
    match (1..=most).contains(&number) {
        true => Ok(number),
        false => Err(format!("expected 1 to {most}, found {number}").into()),
    }
}

pub(super) fn count(text: &str) -> Result<u32, ScriptError> {
    u32::try_from(parse_integer(text)?).map_err(|_| format!("expected a whole number from 0 on, found `{text}`").into())
}
