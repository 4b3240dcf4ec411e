//! The verbs about time and key frames.

use bevy::prelude::*;

use super::error::ScriptError;
use super::names::{count, named, unknown};
use super::verb::verbs;
use crate::app::editor::command::timeline::Timeline;
use crate::app::editor::command::{TimeCommand, TimeEdit};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::document::Interpolation;
use crate::document::value::parse_float;
use crate::scene::{KeyEdit, KeyPath, Keys, place_path, shown_time};

verbs! {
    VERBS(world):
    "time" "SECONDS" [time] => TimeCommand::SetTime(precise(time)?);
    "frame" "NUMBER"
        [number] => {
            let frames = world.resource::<ViewSettings>().timeline;
            TimeCommand::SetTime(frames.time(frame(number)?))
        };
    "timeline" "FPS FIRST LAST (frames)" [fps, first, last] => frames(fps, first, last)?;
    "key" "NAME [PROPERTY, else its place]"
        [name, path @ ..] if path.len() <= 1 => set(world, name, path.first().copied())?;
    "unkey" "NAME [PROPERTY, else all that have a key now]"
        [name, path @ ..] if path.len() <= 1 => remove(world, name, path.first().copied(), KeyEdit::Remove)?;
    "stand-still" "NAME [PROPERTY, else all] (removes all keys)"
        [name, path @ ..] if path.len() <= 1 => remove(world, name, path.first().copied(), KeyEdit::RemoveAll)?;
    "move-key" "NAME PROPERTY FROM TO (seconds)" [name, path, from, to] => shift(world, name, path, [from, to])?;
    "interpolate" "NAME PROPERTY linear|ease|step" [name, path, way] => interpolate(world, name, path, way)?;
}

/// Parses a number of double precision, for times. Its range is that of other numbers.
fn precise(text: &str) -> Result<f64, ScriptError> {
    parse_float(text)?;
    text.trim().parse().map_err(|_| "expected a number".into())
}

/// Parses the number of a frame, perhaps with a fraction.
fn frame(text: &str) -> Result<f64, ScriptError> {
    let (frame, most) = (precise(text)?, Timeline::MOST);
    match (0.0..=f64::from(most)).contains(&frame) {
        true => Ok(frame),
        false => Err(format!("expected a frame from 0 to {most}, found {frame}").into()),
    }
}

fn frames(fps: &str, first: &str, last: &str) -> Result<TimeCommand, ScriptError> {
    let timeline = Timeline {
        fps: precise(fps)?,
        first: count(first)?,
        last: count(last)?,
    };
    match timeline == timeline.within_range() {
        true => Ok(TimeCommand::SetTimeline(timeline)),
        false => Err("expected frames per second, and a last frame that is not before the first".into()),
    }
}

fn set(world: &mut World, name: &str, path: Option<&str>) -> Result<TimeEdit, ScriptError> {
    let thing = named(world, name)?;
    let path = match path {
        Some(path) => KeyPath::new(path),
        None => place_path(world, thing).ok_or("it has no place")?,
    };
    Ok(TimeEdit::Key(vec![(thing, path)], KeyEdit::Set))
}

fn remove(world: &mut World, name: &str, path: Option<&str>, edit: KeyEdit) -> Result<TimeEdit, ScriptError> {
    let thing = named(world, name)?;
    if let Some(path) = path {
        return Ok(TimeEdit::Key(vec![(thing, KeyPath::new(path))], edit));
    }
    let time = shown_time(world);
    let keys = world.get::<Keys>(thing).ok_or("it has no keys")?;
    let wanted = keys
        .tracks()
        .filter(|(_, track)| edit != KeyEdit::Remove || track.has_key(time));
    let targets: Vec<(Entity, KeyPath)> = wanted.map(|(path, _)| (thing, path.clone())).collect();
    match targets.is_empty() {
        true => Err(format!("it has no key at {time} s").into()),
        false => Ok(TimeEdit::Key(targets, edit)),
    }
}

fn shift(world: &mut World, name: &str, path: &str, times: [&str; 2]) -> Result<TimeEdit, ScriptError> {
    let [from, to] = times.map(precise);
    let edit = KeyEdit::Move { from: from?, to: to? };
    let thing = named(world, name)?;
    Ok(TimeEdit::Key(vec![(thing, KeyPath::new(path))], edit))
}

fn interpolate(world: &mut World, name: &str, path: &str, way: &str) -> Result<TimeEdit, ScriptError> {
    let known = Interpolation::ALL.into_iter().find(|known| known.name() == way);
    let known = known.ok_or_else(|| unknown("interpolation", way, Interpolation::ALL.map(Interpolation::name)))?;
    let thing = named(world, name)?;
    Ok(TimeEdit::Key(
        vec![(thing, KeyPath::new(path))],
        KeyEdit::Interpolate(known),
    ))
}
