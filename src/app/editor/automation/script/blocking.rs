//! The verbs that add things and block out: `add`, `draw`, `push` and `cut`.

use bevy::prelude::*;

use super::assign;
use super::error::ScriptError;
use super::names::named;
use super::verb::verbs;
use crate::app::editor::command::SceneEdit;
use crate::app::editor::command::addition::{Addition, AdditionKind};
use crate::app::editor::command::blocking::block::{Block, Plane};
use crate::app::editor::command::blocking::faces::{Face, pushed};
use crate::app::editor::command::blocking::openings::{Cut, HOLE, floor_of, wall_of};
use crate::app::editor::command::blocking::{BlockKind, Reshaping};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::document::value::{parse_float, parse_vec3};
use crate::scene::{Opening, Shape, Solid, ToWorld};

verbs! {
    VERBS(world):
    "add" "KIND [name=NAME] [at=X,Y,Z (where it stands)] [size=S (half its extent)]"
        [kind, options @ ..] => SceneEdit::Add(addition(kind, options)?);
    "draw" "box|floor|wall FROM TO [name=NAME] [height=H] [thickness=T]"
        [kind, from, to, options @ ..] => draw(world, kind, [from, to], options)?;
    "cover" "gableroof|hiproof|shedroof (what is selected)" [form] => SceneEdit::Cover(roof(form)?);
    "push" "NAME FACE DISTANCE (+x, -x, +y, ... of its own axes)"
        [name, face, distance] => push(world, name, face, distance)?;
    "cut" "door|window|french-window|hole WALL FROM [sill=H] [width=W] [height=H]"
        [kind, wall, from, options @ ..] => cut(world, wall, kind, from, options)?;
}

/// The default heights of drawings, in world units.
const HEIGHT: f32 = 2.5;
const FLOOR_HEIGHT: f32 = 0.1;
const THICKNESS: f32 = 0.2;

fn roof(form: &str) -> Result<&'static str, ScriptError> {
    let known = AdditionKind::SHAPES.iter().find_map(|kind| match kind {
        AdditionKind::Solid(plugin) if *plugin == form => Solid::of_plugin(plugin)?.roof().map(|_| *plugin),
        _ => None,
    });
    known.ok_or_else(|| format!("expected gableroof, hiproof or shedroof, found `{form}`").into())
}

fn draw(world: &World, kind: &str, [from, to]: [&str; 2], options: &[&str]) -> Result<SceneEdit, ScriptError> {
    let known = BlockKind::of_name(kind);
    let kind = known.ok_or_else(|| format!("expected box, floor or wall, found `{kind}`"))?;
    let up = world.resource::<ViewSettings>().navigation.up;
    let mut block = Block {
        kind,
        name: None,
        from: parse_vec3(from)?,
        to: parse_vec3(to)?,
        plane: Plane::of_normal(up, up),
        height: if kind == BlockKind::Floor { FLOOR_HEIGHT } else { HEIGHT },
        thickness: THICKNESS,
    };
    for option in options {
        match option.split_once('=') {
            Some(("name", name)) => block.name = Some(name.to_owned()),
            Some(("height", height)) => block.height = parse_float(height)?,
            Some(("thickness", thickness)) => block.thickness = parse_float(thickness)?,
            _ => return Err(format!("expected name=, height= or thickness=, found `{option}`").into()),
        }
    }
    Ok(SceneEdit::Build(Box::new(block)))
}

fn push(world: &mut World, name: &str, face: &str, distance: &str) -> Result<SceneEdit, ScriptError> {
    let face = Face::of_name(face).ok_or("expected a face: +x, -x, +y, -y, +z or -z")?;
    let distance = parse_float(distance)?;
    let entity = named(world, name)?;
    let (shape, pose) = parts(world, entity)?;
    let (kind, pose) = pushed(&shape.kind, pose, face, distance).ok_or("it has no such face to push")?;
    Ok(SceneEdit::Reshape(
        entity,
        Shape { kind, ..shape.clone() },
        pose,
        Reshaping::Push,
    ))
}

fn cut(world: &mut World, wall: &str, kind: &str, from: &str, options: &[&str]) -> Result<SceneEdit, ScriptError> {
    let usual = match kind {
        "door" => Opening::DOOR,
        "window" => Opening::WINDOW,
        "french-window" => Opening::FRENCH_WINDOW,
        "hole" => HOLE,
        other => return Err(format!("expected door, window, french-window or hole, found `{other}`").into()),
    };
    let from = parse_float(from)?;
    let mut lengths = Vec::new();
    for option in options {
        let (name, number) = option.split_once('=').unwrap_or((option, ""));
        let number = parse_float(number)?;
        if name != "sill" && !(["width", "height"].contains(&name) && number > 0.0) {
            return Err(format!("expected sill=, width= or height= with a length, found `{option}`").into());
        }
        lengths.push((name, number));
    }
    let entity = named(world, wall)?;
    let (shape, pose) = parts(world, entity)?;
    let up = world.resource::<ViewSettings>().navigation.up;
    let is_hole = kind == "hole";
    let (wall, pose) = match is_hole {
        true => floor_of(&shape.kind, pose, up).ok_or("it is no box whose upper side is level")?,
        false => wall_of(&shape.kind, pose, up).ok_or("it is neither a wall nor an upright box")?,
    };
    let height = match wall {
        Solid::Wall { height, .. } => height,
        _ => HEIGHT,
    };
    let usual = match is_hole {
        true => Opening {
            sill: (0.5 * (height - usual.height)).max(0.0),
            ..usual
        },
        false => usual.in_wall(height),
    };
    let mut opening = Opening { from, ..usual };
    for (name, length) in lengths {
        match name {
            "sill" => opening.sill = length,
            "width" => opening.width = length,
            _ => opening.height = length,
        }
    }
    let (kind, pose) = Cut {
        wall,
        pose,
        opening,
        is_hole,
    }
    .done();
    Ok(SceneEdit::Reshape(
        entity,
        Shape { kind, ..shape.clone() },
        pose,
        Reshaping::Cut,
    ))
}

fn parts(world: &World, entity: Entity) -> Result<(&Shape, &bevy::math::Affine3A), ScriptError> {
    let shape = world.get::<Shape>(entity).ok_or("it is no shape")?;
    let pose = world.get::<ToWorld>(entity).ok_or("it has no place")?;
    Ok((shape, &pose.0))
}

fn addition(kind: &str, options: &[&str]) -> Result<Addition, ScriptError> {
    let known = AdditionKind::of_name(kind).ok_or_else(|| {
        let names: Vec<&str> = AdditionKind::all().map(AdditionKind::name).collect();
        format!("\"{kind}\" cannot be added, only {}", names.join(", "))
    })?;
    let mut addition = Addition::from(known);
    for option in options {
        match option.split_once('=') {
            Some(("name", name)) => addition.name = Some(name.to_owned()),
            Some(("at", place)) => addition.at = Some(parse_vec3(place)?),
            Some(("size", size)) => {
                let size = assign::within(parse_float(size)?, &(f32::MIN_POSITIVE..=f32::MAX))?;
                addition.size = Some(size);
            }
            _ => return Err(format!("expected name=, at= or size=, found `{option}`").into()),
        }
    }
    // The size must not depend on the camera.
    if addition.at.is_some() {
        addition.size.get_or_insert(known.usual_size());
    }
    Ok(addition)
}
