//! The verbs of media: `medium`, `medium-of` and `fill`.

use bevy::prelude::*;

use super::error::ScriptError;
use super::names::{all_named, named, unknown};
use crate::app::editor::command::media::{Filling, MediumSide};
use crate::app::editor::command::{Command, MediumEdit};
use crate::scene::Medium;

/// `medium MEDIUM|none interior|exterior|around THING...`
pub fn medium(world: &mut World, medium: &str, side: &str, things: &[&str]) -> Result<Command, ScriptError> {
    let side = side_of(side)?;
    Ok(MediumEdit::UseMedium {
        medium: match medium {
            "none" => None,
            name => Some(named(world, name)?),
        },
        things: all_named(world, things)?,
        side,
    }
    .into())
}

/// `medium-of THING [interior|exterior|around]`
pub fn new_medium(world: &mut World, thing: &str, side: Option<&str>) -> Result<Command, ScriptError> {
    let side = side.map_or(Ok(MediumSide::Interior), side_of)?;
    Ok(MediumEdit::GiveMedium {
        thing: named(world, thing)?,
        side,
    }
    .into())
}

/// `fill fog|smoke|MEDIUM SHAPE...`
pub fn fill(world: &mut World, with: &str, shapes: &[&str]) -> Result<Command, ScriptError> {
    // A medium of the scene is meant if there is one of this name.
    let known = named(world, with).ok();
    let known = known.filter(|thing| world.get::<Medium>(*thing).is_some());
    let with = match (known, with) {
        (Some(medium), _) => Filling::Medium(medium),
        (None, "fog") => Filling::Fog,
        (None, "smoke") => Filling::Smoke,
        (None, name) => Filling::Medium(named(world, name)?),
    };
    Ok(MediumEdit::Fill {
        shapes: all_named(world, shapes)?,
        with,
    }
    .into())
}

fn side_of(word: &str) -> Result<MediumSide, ScriptError> {
    let known = MediumSide::ALL.into_iter().find(|(_, name, _)| *name == word);
    let names = MediumSide::ALL.into_iter().map(|(_, name, _)| name);
    known
        .map(|(side, ..)| side)
        .ok_or_else(|| unknown("place of a medium", word, names))
}
