//! The search for places, aims and times of lamps: it begins, and what it has found becomes a proposal.

use std::sync::Arc;

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::film_lamps::{FilmLamps, Lamp, channel_of};
use super::finding::{MEASURING, Observing, is_lit, is_measuring, observe_all, refusal};
use super::{group_name, is_elsewhere, notes};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::light_paint::{LightPainting, Placement, Proposal};
use crate::app::editor::picture::light_search::LampPlacing;
use crate::engine::lamp_freedom::{FreeLamp, LampChange};
use crate::engine::placing::{FoundLamps, LampSearch, MOST_PIXELS, NoPlace, SAMPLES};
use crate::engine::{PackedScene, RenderControl, RenderFilm, WakeUp};
use crate::inverse_lighting::PixelLight;
use crate::scene::{Shape, SunPosition, ToWorld};

/// Begins the search.
pub(super) fn begin(world: &mut World) -> Result<(), CommandError> {
    if !is_lit(world.resource::<RenderFilm>()) || world.resource::<LightPainting>().is_empty() {
        return Err("Paint the light you want first; the picture must have the light of each lamp.".into());
    }
    if is_elsewhere(world) {
        return Err("The strokes belong to another view.".into());
    }
    observe_all(world)?;
    let observing = world.resource::<Observing>();
    let painting = world.resource::<LightPainting>();
    if is_measuring(world) {
        return Err(MEASURING.into());
    }
    let (film, packed) = (world.resource::<RenderFilm>(), world.resource::<PackedScene>());
    let mut free = Vec::new();
    for (number, lamp) in observing.list.lamps.iter().enumerate() {
        if lamp.choice.freedom.is_none() {
            continue;
        }
        let group = &film.light_groups[lamp.layer];
        let name = group_name(world, group);
        if group.entities.len() > 1 {
            return Err(format!("{name} share a layer, and cannot move.").into());
        }
        let free_lamp = FreeLamp::new(world, &packed.lamps, lamp.entity, lamp.choice.freedom);
        free.push((free_lamp.map_err(|reason| format!("{name} {reason}."))?, number));
    }
    if free.is_empty() {
        return Err("No lamp may move, turn or stand at another hour: choose some.".into());
    }
    let (Some(scene), Some(view)) = (packed.scene.clone(), film.view.clone()) else {
        return Err("There is no picture yet.".into());
    };
    let lamps = FilmLamps {
        film: &film.film,
        list: &observing.list,
        lux: observing.lux.as_deref(),
    };
    let count = observing.list.lamps.len();
    let search = LampSearch {
        scene,
        view,
        free,
        limits: observing.list.limits(),
        light: PixelLight::of(&observing.painting, &lamps, count, MOST_PIXELS),
        targets: observing.painting.targets(),
        samples: SAMPLES,
    };
    let revision = painting.revision;
    world.resource_mut::<LightPainting>().proposal = None;
    world.init_resource::<LampPlacing>();
    world.resource_scope(|world, mut placing: Mut<LampPlacing>| {
        placing.start(
            search,
            revision,
            world.resource::<RenderControl>(),
            world.resource::<WakeUp>(),
        );
    });
    Ok(())
}

/// Ends a search whose result is no longer wanted.
pub(super) fn forget(world: &mut World) {
    let placing = world.get_resource_mut::<LampPlacing>();
    if let Some(mut placing) = placing.filter(|placing| placing.progress().is_some()) {
        placing.cancel();
    }
}

/// Takes what the search has found, and drops what belongs to other strokes.
pub(super) fn follow(world: &mut World) {
    let revision = world.resource::<LightPainting>().revision;
    let proposal = &world.resource::<LightPainting>().proposal;
    if proposal.as_ref().is_some_and(|proposal| proposal.revision != revision) {
        world.resource_mut::<LightPainting>().proposal = None;
    }
    let found = world
        .get_resource_mut::<LampPlacing>()
        .and_then(|mut placing| placing.collect());
    let Some((of, found)) = found.filter(|(of, _)| *of == revision) else {
        return;
    };
    let proposal = match found {
        Ok(found) => proposal_of(world, &found, of),
        Err(NoPlace::Cancelled) => return,
        Err(NoPlace::Unsolvable(error)) => Proposal {
            notes: vec![refusal(error).to_string()],
            revision: of,
            ..Proposal::default()
        },
    };
    world.resource_mut::<LightPainting>().proposal = Some(Arc::new(proposal));
}

fn proposal_of(world: &World, found: &FoundLamps, revision: u64) -> Proposal {
    let painting = world.resource::<LightPainting>();
    let Some(observing) = world.get_resource::<Observing>() else {
        return Proposal::default();
    };
    let film = world.resource::<RenderFilm>();
    let lamps = &observing.list.lamps;
    let named =
        |lamp: &Lamp| (film.light_groups.get(lamp.layer)).map_or_else(String::new, |group| group_name(world, group));
    let names: Vec<String> = lamps.iter().map(named).collect();
    let percent = found.errors.map(|error| 100.0 * error);
    let mut proposal = Proposal {
        mix: painting.base.clone(),
        notes: vec![match percent[1] < percent[0] {
            true => format!("The error becomes {:.1} % in place of {:.1} %.", percent[1], percent[0]),
            false => format!("No better places were found: the error stays {:.1} %.", percent[0]),
        }],
        revision,
        ..Proposal::default()
    };
    for (lamp, gain) in lamps.iter().zip(&found.fit.gains) {
        proposal.mix.set(lamp.entity, channel_of(lamp, *gain));
    }
    let free = lamps
        .iter()
        .zip(&names)
        .filter(|(lamp, _)| !lamp.choice.freedom.is_none());
    for (((lamp, name), change), at_limit) in free.zip(&found.changes).zip(&found.at_limit) {
        let (words, placement) = match change {
            LampChange::Motion(motion) => moved(world, lamp, *motion),
            LampChange::Sun(sky) => (time_of(&sky.sun), Placement::Sun(sky.clone())),
        };
        proposal.notes.push(format!("{name} {words}."));
        if *at_limit {
            proposal
                .notes
                .push(format!("{name} is at the limit of what it may do."));
        }
        proposal.placements.push((lamp.entity, placement));
    }
    proposal.notes.extend(notes::notes(painting, &found.fit, lamps, &names));
    proposal
}

/// How a motion moves a lamp, in words, and its pose afterwards.
fn moved(world: &World, lamp: &Lamp, motion: Affine3A) -> (String, Placement) {
    let to_world = world.get::<ToWorld>(lamp.entity).copied().unwrap_or_default();
    let middle = world.get::<Shape>(lamp.entity).map_or(Vec3::ZERO, Shape::middle);
    let before = to_world.0 * Affine3A::from_translation(middle);
    let after = motion * before;
    let distance = after.translation.distance(before.translation);
    let turned = Quat::from_mat3a(&motion.matrix3).to_axis_angle().1.to_degrees();
    let words = match lamp.choice.freedom.turn > 0.0 {
        true => format!("moves by {distance:.3} and turns by {turned:.1}°"),
        false => format!("moves by {distance:.3}"),
    };
    (words, Placement::Pose(after))
}

fn time_of(sun: &SunPosition) -> String {
    match sun {
        SunPosition::PlaceAndTime(at) => format!(
            "stands as at {:02}:{:02} on {}-{:02}-{:02}",
            at.hour as i32, at.minute as i32, at.year, at.month, at.day
        ),
        SunPosition::Direction(_) => "stays".to_owned(),
    }
}
