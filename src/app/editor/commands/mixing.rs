//! The mix of the lights, written into the scene.

use bevy::prelude::*;

use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::light_mix::{LightMix, bake_area, bake_emitter};
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::toasts::Toasts;
use crate::color::Rgb;
use crate::engine::RenderFilm;
use crate::scene::{AreaLight, Emitter};

/// Bakes the mix into the lights. Those that cannot be multiplied stay in the mix, and are named in a message.
pub fn bake(edit: &mut Edit) -> Result<(), CommandError> {
    let mix = edit.world.resource::<LightMix>().clone();
    let gains = mix.gains(&edit.world.resource::<RenderFilm>().light_groups);
    if gains.is_empty() {
        return Err("The mix is neutral.".into());
    }
    // Solo and mute stay, and so do the channels of lights that are not in the picture.
    let mut left = mix.clone();
    let mut refusals = Vec::new();
    let all = gains.len();
    for (light, gain) in gains {
        match bake_one(edit, light, gain) {
            Ok(()) => left.note_baked(light, gain),
            Err(reason) => {
                let name = edit.world.get::<Name>(light).map_or("A light", |name| name.as_str());
                refusals.push(format!("{name} {reason}."));
            }
        }
    }
    if refusals.len() == all {
        return Err(refusals.join(" ").into());
    }
    if !refusals.is_empty() {
        edit.world.resource_mut::<Toasts>().info(refusals.join(" "));
    }
    edit.world.insert_resource(left);
    Ok(())
}

/// The error is the end of a sentence that begins with the light.
fn bake_one(edit: &mut Edit, light: Entity, gain: Rgb) -> Result<(), &'static str> {
    if let Some(baked) = edit.world.get::<AreaLight>(light).map(|light| bake_area(light, gain)) {
        edit.set(light, baked?);
    } else if let Some(baked) = edit
        .world
        .get::<Emitter>(light)
        .map(|emitter| bake_emitter(emitter, gain))
    {
        edit.set(light, baked?);
    } else {
        return Err("shines as its mesh file says");
    }
    Ok(())
}
