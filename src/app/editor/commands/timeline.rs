//! Times and keys: sets the displayed time, plays, sets keys and moves them.

use std::time::Instant;

use bevy::ecs::entity::EntityHashSet;
use bevy::math::Affine3A;
use bevy::prelude::*;

use super::things::selected;
use super::{grouping, note_input, view};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::timeline::TimeStep;
use crate::app::editor::command::{TimeCommand, TimeEdit};
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::document::Track;
use crate::document::animation::MOST_TIME;
use crate::engine::PackedScene;
use crate::scene::{
    ActiveSensor, FreeView, KeyEdit, KeyPath, Keys, SceneStatus, ToWorld, Turntable, edit_keys, place_path,
    show_moment, shown_time,
};

/// Applies the command.
pub fn apply(world: &mut World, command: TimeCommand) -> Result<(), CommandError> {
    match command {
        TimeCommand::SetTime(time) => set_time(world, time)?,
        TimeCommand::StepTime(to) => step(world, to)?,
        TimeCommand::SetPlaying(plays) => play(world, plays),
        TimeCommand::SetTimeline(timeline) => world.resource_mut::<ViewSettings>().timeline = timeline.within_range(),
        TimeCommand::ShowTimeline(shown) => world.resource_mut::<ViewSettings>().timeline_shown = Some(shown),
    }
    Ok(())
}

/// Applies the edit.
pub fn edit(edit: &mut Edit, command: TimeEdit) -> Result<(), CommandError> {
    match command {
        TimeEdit::AddTurntable => add_turntable(edit)?,
        TimeEdit::Key(targets, how) => change_keys(edit, &targets, how)?,
    }
    Ok(())
}

/// Shows the scene at a time in seconds. Playback ends.
pub fn set_time(world: &mut World, time: f64) -> Result<(), CommandError> {
    if !(-MOST_TIME..=MOST_TIME).contains(&time) {
        return Err("There is no such time.".into());
    }
    world.resource_mut::<ViewSettings>().playback.stop();
    show_moment(world, time);
    Ok(())
}

/// Shows the scene at the time of another frame or key.
pub fn step(world: &mut World, step: TimeStep) -> Result<(), CommandError> {
    let timeline = world.resource::<ViewSettings>().timeline;
    let now = shown_time(world);
    // A time within a frame counts as its start, up to rounding.
    let frame = timeline.frame(now);
    let to = match step {
        TimeStep::FirstFrame => timeline.time(timeline.first.into()),
        TimeStep::LastFrame => timeline.time(timeline.last.into()),
        TimeStep::PreviousFrame => timeline.time((frame - 1e-4).ceil() - 1.0),
        TimeStep::NextFrame => timeline.time((frame + 1e-4).floor() + 1.0),
        TimeStep::PreviousKey | TimeStep::NextKey => {
            let is_next = step == TimeStep::NextKey;
            let near = 1e-4 / timeline.fps;
            let times = key_times(world).into_iter();
            let found = match is_next {
                true => times.filter(|time| *time > now + near).min_by(f64::total_cmp),
                false => times.filter(|time| *time < now - near).max_by(f64::total_cmp),
            };
            timeline.time_of_key(found.ok_or("There is no further key.")?)
        }
    };
    set_time(world, to)
}

/// The times of the keys of the selection, or else of everything.
fn key_times(world: &mut World) -> Vec<f64> {
    let selection = world.resource::<Selection>().clone();
    let mut all = world.query::<(Entity, &Keys)>();
    let mut times = |wanted: &dyn Fn(Entity) -> bool| {
        let keys = all.iter(world).filter(|(entity, _)| wanted(*entity));
        let tracks = keys.flat_map(|(_, keys)| keys.tracks());
        let times = tracks.flat_map(|(_, track)| track.keys.iter().map(|key| key.time));
        times.collect::<Vec<f64>>()
    };
    let of_selection = times(&|entity| selection.contains(entity));
    match of_selection.is_empty() {
        true => times(&|_| true),
        false => of_selection,
    }
}

/// Starts or stops playback.
pub fn play(world: &mut World, plays: bool) {
    let timeline = world.resource::<ViewSettings>().timeline;
    let mut now = shown_time(world);
    let end = timeline.time(timeline.last.into());
    if now < timeline.time(timeline.first.into()) || now >= end - 1e-6 {
        now = timeline.time(timeline.first.into());
    }
    let playback = &mut world.resource_mut::<ViewSettings>().playback;
    match plays {
        true => playback.start(now),
        false => playback.stop(),
    }
}

/// Shows the frame that is due during playback. Frames are skipped if the machine is slow.
pub(crate) fn play_on(world: &mut World) {
    let is_opening = world
        .get_resource::<SceneStatus>()
        .is_some_and(|status| status.is_opening);
    if is_opening {
        return;
    }
    let settings = world.resource::<ViewSettings>();
    let (Some((from, since)), timeline) = (settings.playback.started(), settings.timeline) else {
        return;
    };
    let first = timeline.time(timeline.first.into());
    let passed = from - first + Instant::now().saturating_duration_since(since).as_secs_f64();
    let frame = (timeline.frame(passed.rem_euclid(timeline.duration())) + 1e-9).floor();
    let time = timeline.time(f64::from(timeline.first) + frame);
    if time != shown_time(world) && show_moment(world, time) {
        note_input(world, true);
    }
}

/// Changes tracks. Without targets, keys are set for the places of the selection, and other edits apply to all its
/// tracks.
fn change_keys(edit: &mut Edit, targets: &[(Entity, KeyPath)], how: KeyEdit) -> Result<(), CommandError> {
    let mut targets = match targets {
        [] => targets_of_selection(edit, how)?,
        targets => targets.to_vec(),
    };
    add_members(edit.world, &mut targets, how);
    for (thing, path) in targets {
        let path = own_place(edit.world, thing, path);
        match edit_keys(edit.world, thing, &path, how)? {
            Some(keys) => edit.set(thing, keys),
            None => edit.remove::<Keys>(thing),
        }
    }
    Ok(())
}

/// Adds the places of members of groups whose places are among the targets: of members with keys that the edit changes,
/// or of all if it sets keys.
fn add_members(world: &mut World, targets: &mut Vec<(Entity, KeyPath)>, how: KeyEdit) {
    let places = targets.iter().filter(|(_, path)| path.is_place());
    let mut known: EntityHashSet = places.map(|(thing, _)| *thing).collect();
    let time = shown_time(world);
    let frames: Vec<Entity> = known
        .iter()
        .copied()
        .filter(|thing| grouping::is_frame(world, *thing))
        .collect();
    for frame in frames {
        for member in grouping::members(world, frame) {
            if !known.insert(member) {
                continue;
            }
            if how == KeyEdit::Set {
                targets.extend(place_path(world, member).map(|path| (member, path)));
            } else if let Some(keys) = world.get::<Keys>(member) {
                let tracks = keys
                    .tracks()
                    .filter(|(path, track)| path.is_place() && is_about(how, track, time));
                targets.extend(tracks.map(|(path, _)| (member, path.clone())));
            }
        }
    }
}

/// The path itself, or for a place without keys the path of the parameter that places the thing, such as `position`.
fn own_place(world: &World, thing: Entity, path: KeyPath) -> KeyPath {
    let has_keys = world.get::<Keys>(thing).is_some_and(|keys| keys.track(&path).is_some());
    match path.is_place() && !has_keys {
        true => place_path(world, thing).unwrap_or(path),
        false => path,
    }
}

/// Animates the camera in use once around the middle of the selection, or of the scene, from the first frame to the one
/// after the last.
pub fn add_turntable(edit: &mut Edit) -> Result<(), CommandError> {
    let of_selection = view::selected_bounds(edit.world);
    let bounds = match of_selection.is_empty() {
        true => edit
            .world
            .resource::<PackedScene>()
            .scene
            .as_ref()
            .map(|scene| scene.geometry.bounds()),
        false => Some(of_selection),
    };
    let middle = bounds.filter(|bounds| !bounds.is_empty()).map(|bounds| bounds.center());
    let middle = middle.ok_or("There is nothing to go around.")?;
    let free = edit.world.resource::<FreeView>();
    let camera = match (free.pose, free.lens, edit.world.resource::<ActiveSensor>().0) {
        (None, None, Some(camera)) => camera,
        _ => view::move_camera_to_view(edit)?,
    };
    let start = edit
        .world
        .get::<ToWorld>(camera)
        .map_or(Affine3A::IDENTITY, |pose| pose.0);
    let timeline = edit.world.resource::<ViewSettings>().timeline;
    let begin = timeline.time(timeline.first.into());
    let track = Turntable::new(start, middle).track(begin, begin + timeline.duration());
    let keys = edit.world.get::<Keys>(camera).cloned().unwrap_or_default();
    edit.set(camera, keys.with(&KeyPath::new("to_world"), Some(track)));
    Ok(())
}

/// Whether a track has keys that the edit changes. `time` is the displayed time.
fn is_about(how: KeyEdit, track: &Track, time: f64) -> bool {
    match how {
        KeyEdit::Remove => track.has_key(time),
        KeyEdit::Move { from, .. } => track.has_key(from),
        KeyEdit::Set | KeyEdit::RemoveAll | KeyEdit::Interpolate(_) => true,
    }
}

fn targets_of_selection(edit: &Edit, how: KeyEdit) -> Result<Vec<(Entity, KeyPath)>, CommandError> {
    let mut targets = Vec::new();
    let time = shown_time(edit.world);
    for thing in selected(edit)? {
        if how == KeyEdit::Set {
            targets.extend(place_path(edit.world, thing).map(|path| (thing, path)));
        } else if let Some(keys) = edit.world.get::<Keys>(thing) {
            let tracks = keys.tracks().filter(|(_, track)| is_about(how, track, time));
            targets.extend(tracks.map(|(path, _)| (thing, path.clone())));
        }
    }
    match (targets.is_empty(), how) {
        (true, KeyEdit::Set) => {
            Err("Keys are for things with a position, and nothing that is selected has one.".into())
        }
        (true, KeyEdit::Remove | KeyEdit::Move { .. }) => Err("What is selected has no key at this time.".into()),
        (true, _) => Err("What is selected has no keys.".into()),
        (false, _) => Ok(targets),
    }
}
