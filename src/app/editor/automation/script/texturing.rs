//! The verbs that place and project textures.

use bevy::math::Vec2;
use bevy::prelude::*;

use super::error::ScriptError;
use super::names::{all_named, named, unknown};
use super::verb::verbs;
use crate::app::editor::command::TextureEdit;
use crate::app::editor::command::texture_placing::{Placing, TextureGroup, texture_groups};
use crate::app::editor::command::uv_projection::{ProjectedFrom, Projection};
use crate::app::editor::commands::texturing::material_parts;
use crate::document::value::{parse_float, parse_floats};
use crate::scene::{LengthUnit, Material};

verbs! {
    VERBS(world):
    "place-texture" "NAME [PARAMETER] [offset=U,V] [rotation=DEGREES] [repeats=U,V] [shear=S]"
        [name, options @ ..] => {
            let owner = named(world, name)?;
            place(world, owner, options)?
        };
    "project-texture" "box|face|view|above|sphere|cylinder TILE (its edge) SHAPE..."
        [from, tile, shapes @ ..] if !shapes.is_empty() => {
            let projection = projection(world, from, tile)?;
            TextureEdit::ProjectTextures { shapes: all_named(world, shapes)?, projection }
        };
}

fn projection(world: &World, from: &str, tile: &str) -> Result<Projection, ScriptError> {
    let names = ProjectedFrom::ALL.map(ProjectedFrom::name);
    let from = ProjectedFrom::of_name(from).ok_or_else(|| unknown("projection", from, names))?;
    let unit = world.get_resource::<LengthUnit>().copied().unwrap_or_default();
    let tile = unit.parse(tile).ok_or("expected the length of a tile's edge")? as f32;
    Ok(Projection { from, tile })
}

fn place(world: &World, owner: Entity, options: &[&str]) -> Result<TextureEdit, ScriptError> {
    let parts = material_parts(world, owner);
    let groups = texture_groups(parts.iter().filter_map(|part| world.get::<Material>(*part)));
    let (parameter, options) = match options {
        [first, rest @ ..] if !first.contains('=') => (Some(*first), rest),
        options => (None, options),
    };
    let names = |group: &TextureGroup| group.parameters.iter().map(|(name, _)| *name).collect::<Vec<_>>();
    let group = match parameter {
        _ if groups.is_empty() => return Err("it has no picture or checkerboard".into()),
        None => &groups[0],
        Some(wanted) => groups
            .iter()
            .find(|group| names(group).contains(&wanted))
            .ok_or_else(|| unknown("texture", wanted, groups.iter().flat_map(names)))?,
    };
    let mut placing = Placing::of(&group.to_uv).ok_or("the texture has no extent")?;
    for option in options {
        match option.split_once('=') {
            Some(("offset", offset)) => placing.offset = pair(offset)?,
            Some(("rotation", degrees)) => placing.degrees = parse_float(degrees)?,
            Some(("repeats", repeats)) => placing.repeats = pair(repeats)?,
            Some(("shear", shear)) => placing.shear = parse_float(shear)?,
            _ => return Err(format!("expected offset=, rotation=, repeats= or shear=, found `{option}`").into()),
        }
    }
    let after = placing.to_uv();
    if Placing::of(&after).is_none() {
        return Err("the texture would have no extent".into());
    }
    Ok(TextureEdit::PlaceTextures {
        owner,
        before: group.to_uv,
        after,
    })
}

fn pair(text: &str) -> Result<Vec2, ScriptError> {
    match parse_floats(text)?[..] {
        [u, v] => Ok(Vec2::new(u, v)),
        _ => Err("expected two numbers".into()),
    }
}
