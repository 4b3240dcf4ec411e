//! The verbs of media and of shapes that shine.

use bevy::prelude::*;

use super::assign;
use super::error::ScriptError;
use super::names::{all_named, named, unknown};
use super::verb::verbs;
use crate::app::editor::command::media::{Filling, MediumSide};
use crate::app::editor::command::{MediumEdit, ValueEdit};
use crate::scene::{AreaLight, Medium};

verbs! {
    VERBS(world):
    "medium" "MEDIUM|none interior|exterior|around THING..."
        [medium, side, things @ ..] if !things.is_empty() => use_medium(world, medium, side, things)?;
    "medium-of" "THING [interior|exterior|around] (a new one of its own)"
        [thing, side @ ..] if side.len() <= 1 => new_medium(world, thing, side.first().copied())?;
    "fill" "fog|smoke|MEDIUM SHAPE..." [with, shapes @ ..] if !shapes.is_empty() => fill(world, with, shapes)?;
    "emit" "SHAPE RADIANCE|none"
        [shape, "none"] => ValueEdit::SetAreaLight(named(world, shape)?, None),
        [shape, radiance] => {
            let mut light = AreaLight::default();
            assign::area_light(&mut light, "radiance", radiance)?;
            ValueEdit::SetAreaLight(named(world, shape)?, Some(light))
        };
}

fn use_medium(world: &mut World, medium: &str, side: &str, things: &[&str]) -> Result<MediumEdit, ScriptError> {
    let side = side_of(side)?;
    Ok(MediumEdit::UseMedium {
        medium: match medium {
            "none" => None,
            name => Some(named(world, name)?),
        },
        things: all_named(world, things)?,
        side,
    })
}

fn new_medium(world: &mut World, thing: &str, side: Option<&str>) -> Result<MediumEdit, ScriptError> {
    let side = side.map_or(Ok(MediumSide::Interior), side_of)?;
    Ok(MediumEdit::GiveMedium {
        thing: named(world, thing)?,
        side,
    })
}

fn fill(world: &mut World, with: &str, shapes: &[&str]) -> Result<MediumEdit, ScriptError> {
    // A medium of the scene takes precedence if it has this name.
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
    })
}

fn side_of(word: &str) -> Result<MediumSide, ScriptError> {
    let names = MediumSide::ALL.map(MediumSide::name);
    MediumSide::of_name(word).ok_or_else(|| unknown("place of a medium", word, names))
}
