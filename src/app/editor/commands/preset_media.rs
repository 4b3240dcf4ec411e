//! The media of the library's materials, for materials below whose surface light is scattered.

use bevy::prelude::*;

use super::things::delete;
use super::{media, media_upkeep};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::presets::{self, Preset};
use crate::app::editor::session::history::Edit;
use crate::scene::medium::users_of_medium;
use crate::scene::{InteriorMedium, LengthUnit, Medium, ObjectState, SceneId, Shape};

/// The least depth of paths: light is scattered often before it comes out again. A ball of milk of 5 cm is 2 % too dark
/// with it, and 9 % with a quarter.
const DEPTH: u32 = 1024;

/// An error if the preset has a medium and a shape has no inside.
pub fn need_inside(edit: &Edit, preset: &Preset, shapes: &[Entity]) -> Result<(), CommandError> {
    let is_flat = |shape: &Entity| {
        edit.world
            .get::<Shape>(*shape)
            .is_some_and(|shape| shape.kind.is_flat())
    };
    match preset.medium.is_some() && shapes.iter().any(is_flat) {
        true => Err(format!(
            "Light goes below the surface of `{}`: only a closed shape can be of it.",
            preset.name
        )
        .into()),
        false => Ok(()),
    }
}

/// Fills shapes with the medium of a preset. A preset without a medium removes the medium of another preset, but none
/// of the user's own.
pub fn fill(edit: &mut Edit, preset: &Preset, shapes: &[Entity]) {
    let unit = edit.world.get_resource::<LengthUnit>().copied().unwrap_or_default();
    let before = of_library(edit.world, &interiors(edit.world, shapes), unit);
    match preset.medium_in(unit) {
        Some(medium) => {
            let medium = used_again(edit, preset, &medium).unwrap_or_else(|| media::spawn(edit, &name(preset), medium));
            for &shape in shapes {
                edit.set(shape, InteriorMedium(medium));
            }
            media_upkeep::trace(edit.world, DEPTH);
        }
        None => {
            for &shape in shapes {
                let interior = edit.world.get::<InteriorMedium>(shape);
                if interior.is_some_and(|interior| before.contains(&interior.0)) {
                    edit.remove::<InteriorMedium>(shape);
                }
            }
        }
    }
    for medium in before {
        let is_used = users_of_medium(edit.world, medium).any(|user| ObjectState::is_in_scene(edit.world, user));
        if !is_used {
            delete(edit, medium);
        }
    }
}

/// The media inside of shapes, each once.
fn interiors(world: &World, shapes: &[Entity]) -> Vec<Entity> {
    let mut media: Vec<Entity> = Vec::new();
    for interior in shapes.iter().filter_map(|shape| world.get::<InteriorMedium>(*shape)) {
        if !media.contains(&interior.0) {
            media.push(interior.0);
        }
    }
    media
}

/// The media of the list that equal the medium of a preset.
fn of_library(world: &World, media: &[Entity], unit: LengthUnit) -> Vec<Entity> {
    if media.is_empty() {
        return Vec::new();
    }
    let (presets, _) = presets::load();
    let known: Vec<Medium> = presets.iter().filter_map(|preset| preset.medium_in(unit)).collect();
    let is_known = |medium: &Entity| {
        world
            .get::<Medium>(*medium)
            .is_some_and(|medium| known.contains(medium))
    };
    media.iter().copied().filter(is_known).collect()
}

/// A medium of the scene with the preset's name that equals its medium, to be reused.
fn used_again(edit: &mut Edit, preset: &Preset, medium: &Medium) -> Option<Entity> {
    let name = name(preset);
    let mut known = edit.world.query::<(Entity, &Medium, &SceneId)>();
    let mut alike = known
        .iter(edit.world)
        .filter(|(_, known, id)| id.0 == name && *known == medium);
    alike.next().map(|(entity, ..)| entity)
}

/// The id that a medium of the scene gets; the material has that of the preset.
fn name(preset: &Preset) -> String {
    format!("{}-inside", preset.id())
}
