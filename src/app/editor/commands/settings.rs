//! Edits of the settings of the whole scene.

use bevy::prelude::*;

use super::things::set_pose;
use super::world::set_resource;
use crate::app::editor::command::SettingsEdit;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::light_mix::{LightMix, bake_area, bake_emitter};
use crate::app::editor::command::light_paint::{LightPainting, Placement};
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::toasts::Toasts;
use crate::color::Rgb;
use crate::document::{LIGHT_UNITS, UNIT};
use crate::engine::RenderFilm;
use crate::scene::{AreaLight, AuthoredScene, Emitter, EmitterKind};

/// Makes the edit.
pub fn edit(edit: &mut Edit, command: SettingsEdit) -> Result<(), CommandError> {
    match command {
        SettingsEdit::SetIntegrator(settings) => set_resource(edit.world, settings),
        SettingsEdit::SetSampler(settings) => set_resource(edit.world, settings),
        SettingsEdit::SetAccel(method) => set_resource(edit.world, method),
        SettingsEdit::SetUnit(unit) => {
            set_resource(edit.world, unit);
            warn_of_taken_name(edit.world, UNIT);
        }
        SettingsEdit::SetLightUnits(units) => {
            set_resource(edit.world, units);
            warn_of_taken_name(edit.world, LIGHT_UNITS);
        }
        SettingsEdit::BakeLights => bake(edit)?,
        SettingsEdit::AcceptLamps => accept_lamps(edit)?,
    }
    Ok(())
}

/// Bakes the light mix into the lights. Lights that cannot be multiplied stay in the mix, and are named in a message.
fn bake(edit: &mut Edit) -> Result<(), CommandError> {
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
    if let Some(mut painting) = edit.world.get_resource_mut::<LightPainting>() {
        painting.clear();
    }
    Ok(())
}

/// Places the lamps as was found, and bakes the strengths that belong to that.
fn accept_lamps(edit: &mut Edit) -> Result<(), CommandError> {
    let painting = edit.world.get_resource::<LightPainting>();
    let Some(proposal) = painting.and_then(|painting| painting.proposal.clone()) else {
        return Err("No places of lamps were found yet.".into());
    };
    for (lamp, placement) in &proposal.placements {
        match (placement, edit.world.get::<Emitter>(*lamp)) {
            (Placement::Pose(pose), _) => set_pose(edit, *lamp, *pose),
            (Placement::Sun(sky), Some(emitter)) => {
                let emitter = Emitter {
                    kind: EmitterKind::SunSky(**sky),
                    ..emitter.clone()
                };
                edit.set(*lamp, emitter);
            }
            (Placement::Sun(_), None) => return Err("The sun is gone.".into()),
        }
    }
    edit.check_poses()?;
    let mix = edit.world.resource::<LightMix>().with_channels(proposal.mix.clone());
    edit.world.insert_resource(mix);
    let gains = edit
        .world
        .resource::<LightMix>()
        .gains(&edit.world.resource::<RenderFilm>().light_groups);
    match gains.is_empty() {
        true => edit.world.resource_mut::<LightPainting>().clear(),
        false => bake(edit)?,
    }
    Ok(())
}

/// Bakes a gain into one light. The error is the end of a sentence that begins with the light.
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

/// Says that the file cannot store a unit of the scene, if it uses the name for something else.
fn warn_of_taken_name(world: &mut World, name: &'static str) {
    let origin = world
        .get_resource::<AuthoredScene>()
        .and_then(|scene| scene.origin.as_ref());
    if origin.is_some_and(|origin| origin.taken_unit_names.contains(&name))
        && let Some(mut toasts) = world.get_resource_mut::<Toasts>()
    {
        toasts.warn(format!(
            "The file will not keep the unit: it uses the name `{name}` for something else."
        ));
    }
}
