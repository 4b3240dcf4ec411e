//! Edits of key frames, and keys that follow from other edits of a thing.

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::encode::{lights, objects};
use super::keys::{KeyEdit, KeyPath, Keys, value_at};
use super::moment::shown_time;
use super::write::patch::Draft;
use super::write::{folder, home_of, steps};
use super::{Authored, ObjectState};
use crate::document::{Object, Track, Value};

/// The keys of a thing after an edit of one of its tracks. An error, in words, if that cannot be done.
pub(crate) fn edit_keys(world: &World, thing: Entity, path: &KeyPath, edit: KeyEdit) -> Result<Option<Keys>, String> {
    let keys = world.get::<Keys>(thing);
    let track = keys.and_then(|keys| keys.track(path));
    let value = value_of(world, thing, path);
    let edited = edit.apply(track.map(|track| &**track), value.as_ref(), shown_time(world));
    let edited = edited.map_err(|reason| format!("\"{path}\" cannot be edited: {reason}."))?;
    Ok(keys.cloned().unwrap_or_default().with(path, edited).some())
}

/// The present value at a path of a thing, in the words of its file.
fn value_of(world: &World, thing: Entity, path: &KeyPath) -> Option<Value> {
    let state = ObjectState::of(world, thing);
    let plugin = plugin_in_file(world, thing, &state);
    let value = plugin
        .as_ref()
        .and_then(|plugin| value_at(plugin, path.as_str()).cloned());
    let full = || value_at(&plugin_of(world, &state)?, path.as_str()).cloned();
    // A thing that stands at the origin has no transform in the file.
    let still = || (path.is_place() && state.to_world.is_some()).then(|| Value::Transform(Vec::new()));
    value.or_else(full).or_else(still)
}

/// The path of the place of a thing; None for what has no place.
pub(crate) fn place_path(world: &World, thing: Entity) -> Option<KeyPath> {
    let state = ObjectState::of(world, thing);
    state.to_world?;
    let plugin = plugin_in_file(world, thing, &state)?;
    Some(Keys::place_in(world.get::<Keys>(thing), &plugin))
}

/// The keys of a thing that was edited: each value with a track that the edit has changed has a key of it at the time that is shown. A value that can have
/// none any more, because a texture took its place or the plugin is another one, has no track.
///
/// `before` is the state before the edit. None if the keys stay as they are.
pub(crate) fn keys_after(world: &World, thing: Entity, before: &ObjectState) -> Option<Keys> {
    let keys = before.keys.as_ref()?;
    let now = ObjectState::of(world, thing);
    if now.keys != before.keys || !now.is_there() {
        return None;
    }
    let (old, new) = (
        plugin_in_file(world, thing, before)?,
        plugin_in_file(world, thing, &now)?,
    );
    let time = shown_time(world);
    let mut edited = keys.clone();
    for (path, track) in keys.tracks() {
        let (before, now) = (value_at(&old, path.as_str()), value_at(&new, path.as_str()));
        if before == now {
            continue;
        }
        let now = now.cloned().or_else(|| unwritten(&new, path, track));
        let now = now.map(|now| match (now, track.at(time)) {
            (Value::Transform(now), Value::Transform(old)) => Value::Transform(steps::revised(&old, &now)),
            (now, _) => now,
        });
        edited = edited.with(path, now.and_then(|now| track.with_key(time, now)));
    }
    (edited != *keys).then_some(edited)
}

/// The default of a value that a file leaves out.
fn unwritten(plugin: &Object, path: &KeyPath, track: &Track) -> Option<Value> {
    if path.as_str().contains('.') || plugin.children.iter().any(|child| child.name() == Some(path.as_str())) {
        return None;
    }
    match track.keys[0].value {
        Value::Transform(_) => Some(Value::Transform(Vec::new())),
        Value::Float(_) => Some(Value::Float(0.0)),
        _ => None,
    }
}

impl Keys {
    /// The keys of a copy that stands elsewhere: `by` takes the place of the original to that of the copy.
    pub(crate) fn moved(&self, by: &Affine3A) -> Self {
        let places: Vec<KeyPath> = self
            .tracks()
            .map(|(path, _)| path.clone())
            .filter(KeyPath::is_place)
            .collect();
        places.into_iter().fold(self.clone(), |keys, path| {
            let track = keys.track(&path).map(|track| track.moved(by));
            keys.with(&path, track)
        })
    }
}

/// The plugin of a thing with every parameter spelled out, without the materials in it.
fn plugin_of(world: &World, state: &ObjectState) -> Option<Object> {
    let home = home_of(world);
    let folder = folder(&home);
    let to_world = state.to_world.map_or(Affine3A::IDENTITY, |pose| pose.0);
    if let Some(shape) = &state.shape {
        Some(objects::shape(shape, &to_world, state.area_light.as_ref(), folder))
    } else if let Some(material) = &state.material {
        Some(objects::material(material, folder))
    } else if let Some(emitter) = &state.emitter {
        Some(lights::emitter(emitter, &to_world, folder))
    } else {
        let (sensor, film) = state.sensor.as_ref().zip(state.film.as_ref())?;
        Some(objects::sensor(sensor, film, &to_world))
    }
}

/// The plugin of a thing in the words of its file.
fn plugin_in_file(world: &World, thing: Entity, state: &ObjectState) -> Option<Object> {
    let plugin = plugin_of(world, state)?;
    Some(Draft::new(world.get::<Authored>(thing), plugin).object)
}
