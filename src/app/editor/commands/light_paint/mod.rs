//! Commands about the light you want, and the lamps that are found for it.

mod film_lamps;
mod finding;
mod notes;
mod placing;

use std::path::Path;
use std::sync::Arc;

use bevy::prelude::*;

pub use self::finding::{follow, search_under_way};

use super::world::{control, set_resource, tell};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::light_mix::{LightMix, bake_area, bake_emitter};
use crate::app::editor::command::light_paint::{
    LampChoice, LightPaintCommand, LightPainting, MOST_CORNERS, MOST_STROKES, TargetPicture,
};
use crate::app::editor::picture::light_search::LampPlacing;
use crate::color::Rgb;
use crate::engine::{LightGroup, RenderControl, RenderFilm};
use crate::files;
use crate::inverse_lighting::Stroke;
use crate::render::camera::Camera;
use crate::render::image_io::load_picture;
use crate::render::view::View;
use crate::scene::{AreaLight, Emitter};

/// Applies the command.
pub fn apply(world: &mut World, command: LightPaintCommand) -> Result<(), CommandError> {
    world.init_resource::<LightPainting>();
    match command {
        LightPaintCommand::SetBrush(brush) => {
            if !brush.stroke(vec![Vec2::ZERO]).is_valid() {
                return Err("The brush has numbers out of range.".into());
            }
            world.resource_mut::<LightPainting>().brush = brush;
        }
        LightPaintCommand::SetStrokes(strokes) => set_strokes(world, strokes)?,
        LightPaintCommand::SetTarget(path) => {
            let picture = path.map(|path| read(&path)).transpose()?;
            if picture.is_some() {
                begin(world);
            }
            let mut painting = world.resource_mut::<LightPainting>();
            painting.picture = picture.map(Arc::new);
            painting.revision += 1;
            end_if_empty(world);
        }
        LightPaintCommand::SetLamp(lamp, choice) => set_lamp(world, lamp, choice)?,
        LightPaintCommand::Solve => finding::solve(world)?,
        LightPaintCommand::Place => placing::begin(world)?,
        LightPaintCommand::Discard => {
            if let Some(mut placing) = world.get_resource_mut::<LampPlacing>() {
                placing.cancel();
            }
            world.resource_mut::<LightPainting>().proposal = None;
        }
    }
    Ok(())
}

fn set_strokes(world: &mut World, strokes: Vec<Stroke>) -> Result<(), CommandError> {
    if strokes.len() > MOST_STROKES {
        return Err(format!("A painting has at most {MOST_STROKES} strokes.").into());
    }
    if strokes.iter().any(|stroke| stroke.path.len() > MOST_CORNERS) {
        return Err(format!("The path of a stroke has at most {MOST_CORNERS} corners.").into());
    }
    if !strokes.iter().all(Stroke::is_valid) {
        return Err("A stroke has numbers out of range.".into());
    }
    // Strokes of another view end with the first stroke of this one.
    let is_elsewhere = is_elsewhere(world);
    let known = world.resource::<LightPainting>().strokes.clone();
    let old = match is_elsewhere {
        true => strokes
            .iter()
            .zip(known.iter())
            .take_while(|(new, old)| new == old)
            .count(),
        false => 0,
    };
    let strokes = strokes[old..].to_vec();
    if !strokes.is_empty() {
        begin(world);
    }
    let mut painting = world.resource_mut::<LightPainting>();
    painting.strokes = strokes.into();
    painting.revision += 1;
    end_if_empty(world);
    Ok(())
}

/// Keeps the light of each lamp in a layer of its own.
pub fn keep_lamps_apart(world: &mut World) {
    if !world.resource::<RenderControl>().light_layers {
        control(world, |control| control.light_layers = true);
    }
}

/// Prepares for what is wanted of this view: the light of each lamp is kept apart from now on, and the present mix is
/// what strokes refer to. What was wanted of another view is dropped.
fn begin(world: &mut World) {
    keep_lamps_apart(world);
    let camera = camera(world);
    let is_elsewhere = is_elsewhere(world);
    if is_elsewhere {
        let base = world.resource::<LightPainting>().base.clone();
        world.resource_mut::<LightPainting>().clear();
        show(world, base);
    }
    let mix = world.get_resource_or_init::<LightMix>().clone();
    let mut painting = world.resource_mut::<LightPainting>();
    if painting.is_empty() {
        painting.base = mix;
        painting.camera = camera;
    }
    if is_elsewhere {
        tell(world, "The strokes of the other view are gone.");
    }
}

/// Shows the mix of before once nothing is wanted any more.
fn end_if_empty(world: &mut World) {
    let painting = world.resource::<LightPainting>();
    if !painting.is_empty() || painting.answer.is_none() {
        return;
    }
    let base = painting.base.clone();
    world.resource_mut::<LightPainting>().clear();
    show(world, base);
}

/// Takes channels that were changed at the mixing desk over into the mix that the painting refers to.
pub(super) fn follow_desk(world: &mut World, before: &LightMix, after: &LightMix) {
    let Some(mut painting) = world
        .get_resource_mut::<LightPainting>()
        .filter(|painting| !painting.is_empty())
    else {
        return;
    };
    let mut base = painting.base.clone();
    for lamp in before.lamps().chain(after.lamps()) {
        let channel = after.channel(lamp);
        if before.channel(lamp) != channel {
            base.set(lamp, channel);
        }
    }
    if base != painting.base {
        painting.base = base;
        painting.revision += 1;
    }
}

/// Shows a mix; factors that are baked stay.
fn show(world: &mut World, mix: LightMix) {
    let mix = world.resource::<LightMix>().with_channels(mix);
    set_resource(world, mix);
}

fn set_lamp(world: &mut World, lamp: Entity, choice: LampChoice) -> Result<(), CommandError> {
    let are_in_order = choice.most.is_finite() && 0.0 <= choice.least && choice.least <= choice.most;
    if !are_in_order {
        return Err("The limits of a lamp are not 0 <= least <= most.".into());
    }
    if !choice.freedom.is_valid() {
        return Err(
            "A lamp may move by a radius of at least 0, turn by 0 to 90 degrees, and a sun may stand between \
             two hours from 0 to 24 in this order."
                .into(),
        );
    }
    if choice.colored
        && let Err(reason) = takes_color(world, lamp)
    {
        let name = world.get::<Name>(lamp).map_or("The lamp", |name| name.as_str());
        return Err(format!("{name} {reason}.").into());
    }
    world.resource_mut::<LightPainting>().set_lamp(lamp, choice);
    Ok(())
}

/// Whether baking can give a lamp another colour. The error is the end of a sentence that begins with the lamp.
fn takes_color(world: &World, lamp: Entity) -> Result<(), &'static str> {
    let gain = Rgb::new(1.0, 0.5, 0.25);
    if let Some(light) = world.get::<AreaLight>(lamp) {
        bake_area(light, gain).map(|_| ())
    } else if let Some(emitter) = world.get::<Emitter>(lamp) {
        bake_emitter(emitter, gain).map(|_| ())
    } else {
        Err("is no lamp whose colour can change")
    }
}

fn read(path: &Path) -> Result<TargetPicture, CommandError> {
    let in_file = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let bytes = files::read(path, files::LARGEST_DATA).map_err(|error| error.to_string())?;
    let loaded = load_picture(&bytes).map_err(|error| in_file(&error))?;
    let image = loaded.image.layer("").or_else(|| {
        let grey = loaded.image.channel("Y")?;
        Some(loaded.image.as_colors(&[grey]))
    });
    let image = image.ok_or_else(|| in_file(&"the picture has no colours"))?;
    if !image.pixels.iter().all(|pixel| pixel.is_finite()) {
        return Err(in_file(&"the picture has values that are not finite").into());
    }
    Ok(TargetPicture {
        path: path.to_path_buf(),
        size: [image.width, image.height],
        pixels: image.pixels,
    })
}

/// The camera of the film of the present picture.
fn camera(world: &World) -> Option<Camera> {
    let view = world.get_resource::<RenderFilm>()?.view.as_ref();
    view.map(View::of_film)
}

/// Whether the picture is of another view than what is wanted.
fn is_elsewhere(world: &World) -> bool {
    world
        .resource::<LightPainting>()
        .is_elsewhere(world.resource::<RenderFilm>())
}

/// The name of the lamps of a group.
fn group_name(world: &World, group: &LightGroup) -> String {
    let first = group.entities.first();
    let name = first.and_then(|&light| world.get::<Name>(light));
    let name = name.map_or("A lamp", |name| name.as_str());
    match group.entities.len() {
        0 | 1 => name.to_owned(),
        many => format!("{name} and {} more", many - 1),
    }
}
