//! Edits of key frames, and keys that follow from other edits of a thing.

use bevy::math::Affine3A;
use bevy::prelude::*;

use crate::document::{Category, Interpolation, Key, Object, Track, Value};
use crate::scene::components::aperture::field_of_view;
use crate::scene::components::keys::superseded_by;
use crate::scene::components::keys::{KeyEdit, KeyPath, Keys, value_at};
use crate::scene::components::moment::shown_time;
use crate::scene::encode::{lights, objects};
use crate::scene::read::millimetres;
use crate::scene::write::patch::{Draft, unwritten_value};
use crate::scene::write::{folder, home_of, steps};
use crate::scene::{Authored, AuthoredScene, IntegratorKeys, IntegratorSettings, ObjectState};

/// The keys of a thing after an edit of one of its tracks. An error, in words, if the edit is impossible.
pub(crate) fn edit_keys(world: &World, thing: Entity, path: &KeyPath, edit: KeyEdit) -> Result<Option<Keys>, String> {
    let keys = world.get::<Keys>(thing);
    let track = keys.and_then(|keys| keys.track(path));
    let value = value_of(world, thing, path);
    let edited = edit.apply(track.map(|track| &**track), value.as_ref(), shown_time(world));
    let edited = edited.map_err(|reason| format!("\"{path}\" cannot be edited: {reason}."))?;
    Ok(keys.cloned().unwrap_or_default().with(path, edited).some())
}

/// The present value at a path of a thing, in the spelling of its file.
fn value_of(world: &World, thing: Entity, path: &KeyPath) -> Option<Value> {
    let state = ObjectState::of(world, thing);
    let plugin = plugin_in_file(world, thing, &state);
    let value = plugin
        .as_ref()
        .and_then(|plugin| value_at(plugin, path.as_str()).cloned());
    let full = || value_at(&plugin_of(world, &state)?, path.as_str()).cloned();
    // A thing at the origin has no transform in the file.
    let still = || (path.is_place() && state.to_world.is_some()).then(|| Value::Transform(Vec::new()));
    value.or_else(full).or_else(still)
}

/// The path of the value that places a thing; None for things without a position.
pub(crate) fn place_path(world: &World, thing: Entity) -> Option<KeyPath> {
    let state = ObjectState::of(world, thing);
    state.to_world?;
    let plugin = plugin_in_file(world, thing, &state)?;
    Some(Keys::place_in(world.get::<Keys>(thing), &plugin))
}

/// The keys of a thing after an edit.
pub(crate) struct KeysAfter {
    /// Its present keys.
    pub keys: Keys,
    /// The values that lose their keys, because a texture or another parameter replaced them or the plugin has changed.
    pub lost: Vec<KeyPath>,
}

/// The keys of a thing after an edit: each animated value that the edit has changed gets a key at the shown time.
///
/// `before` is the state before the edit. None if the keys do not change.
pub(crate) fn keys_after(world: &World, thing: Entity, before: &ObjectState) -> Option<KeysAfter> {
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
    let mut after = KeysAfter {
        keys: keys.clone(),
        lost: Vec::new(),
    };
    for (path, track) in keys.tracks() {
        let (before, value) = (value_at(&old, path.as_str()), value_at(&new, path.as_str()));
        // The file may give the value by another parameter at this time (`fov` for `focal_length`).
        let is_said_otherwise = before.is_none()
            && superseded_by(path.as_str())
                .iter()
                .any(|other| value_at(&old, other) != value_at(&new, other));
        if before == value && !is_said_otherwise {
            continue;
        }
        let is_turned = steps::is_turned(before, value);
        let value = value.cloned().or_else(|| unwritten(&new, path, track));
        let value = value.map(|value| match (value, track.at(time)) {
            (Value::Transform(value), Value::Transform(old)) => {
                Value::Transform(steps::revised(&old, &value, is_turned))
            }
            (value, _) => value,
        });
        let track = match value {
            Some(value) => track.with_key(time, value).map(|track| (path.clone(), track)),
            None => as_field_of_view(path, track, &now).and_then(|(path, track)| {
                let value = value_at(&new, path.as_str())?;
                Some((path, track.with_key(time, value.clone())?))
            }),
        };
        after.keys = after.keys.with(path, None);
        match track {
            Some((path, track)) => after.keys = after.keys.with(&path, Some(track)),
            None => after.lost.push(path.clone()),
        }
    }
    (after.keys != *keys).then_some(after)
}

/// The track of a `focal_length` converted to that of the `fov` which replaces it when one of them is edited. Focal
/// lengths are texts, which hold until the next key, and so do these fields of view.
fn as_field_of_view(path: &KeyPath, track: &Track, now: &ObjectState) -> Option<(KeyPath, Track)> {
    let (sensor, film) = now.sensor.as_ref().zip(now.film.as_ref())?;
    if path.as_str() != "focal_length" {
        return None;
    }
    let aspect = film.width as f32 / film.height as f32;
    let degrees = |value: &Value| match value {
        Value::String(text) => {
            let metres = 1e-3 * millimetres(text)?;
            Some(Value::Float(field_of_view(metres, sensor.fov_axis, aspect)))
        }
        _ => None,
    };
    let keys = track.keys.iter().map(|key| {
        let value = degrees(&key.value)?;
        Some(Key { time: key.time, value })
    });
    let track = Track {
        keys: keys.collect::<Option<_>>()?,
        interpolation: Interpolation::Step,
    };
    Some((KeyPath::new("fov"), track))
}

/// The keys of the integrator after an edit of its settings: each animated setting that has changed gets a key at the
/// shown time. None if the keys do not change.
pub(crate) fn integrator_keys_after(world: &World) -> Option<IntegratorKeys> {
    let keys = &world.get_resource::<IntegratorKeys>()?.0;
    let settings = world.get_resource::<IntegratorSettings>()?;
    let authored = world.get_resource::<AuthoredScene>()?.integrator.as_ref();
    let plugin = objects::integrator(settings);
    let plugin = match authored {
        Some((_, authored)) => Draft::of_integrator(authored, plugin).object,
        None => plugin,
    };
    let time = shown_time(world);
    let mut edited = keys.clone();
    for (path, track) in keys.tracks() {
        edited = edited.with(path, None);
        let Some(path) = setting_path(&plugin, path) else {
            continue;
        };
        let now = value_at(&plugin, path.as_str()).filter(|now| **now != track.at(time));
        let track = match now {
            Some(now) => track.with_key(time, now.clone()),
            None => Some(Track::clone(track)),
        };
        edited = edited.with(&path, track);
    }
    (edited != *keys).then_some(IntegratorKeys(edited))
}

/// The present path of a setting of the integrator: with layers its integrator is nested in `aov`.
fn setting_path(plugin: &Object, path: &KeyPath) -> Option<KeyPath> {
    let words = path.as_str();
    let outside = words.rsplit_once('.').map(|(_, name)| name.to_owned());
    let inside = || format!("{}.{words}", Category::Integrator.name());
    let other = outside.unwrap_or_else(inside);
    let mut paths = [path.clone(), KeyPath::new(other)].into_iter();
    paths.find(|path| value_at(plugin, path.as_str()).is_some())
}

/// The default of a value that a file leaves out and gives by no other parameter.
fn unwritten(plugin: &Object, path: &KeyPath, track: &Track) -> Option<Value> {
    let mut names = plugin.properties.iter().map(|property| &*property.name);
    if names.any(|name| superseded_by(name).contains(&path.as_str())) {
        return None;
    }
    if path.as_str().contains('.') || plugin.children.iter().any(|child| child.name() == Some(path.as_str())) {
        return None;
    }
    unwritten_value(path.as_str(), &track.keys[0].value)
}

impl Keys {
    /// The keys of a moved copy: `by` is the transform from the original to the copy.
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

/// The plugin of a thing with every parameter spelled out, without the materials and media in it.
fn plugin_of(world: &World, state: &ObjectState) -> Option<Object> {
    let home = home_of(world);
    let folder = folder(&home);
    let to_world = state.to_world.map_or(Affine3A::IDENTITY, |pose| pose.0);
    if let Some(shape) = &state.shape {
        Some(objects::shape(
            shape,
            &to_world,
            state.angles,
            state.area_light.as_ref(),
            folder,
        ))
    } else if let Some(material) = &state.material {
        Some(objects::material(material, folder))
    } else if let Some(medium) = &state.medium {
        Some(objects::medium(medium, folder))
    } else if let Some(emitter) = &state.emitter {
        Some(lights::emitter(emitter, &to_world, state.angles, folder))
    } else {
        let (sensor, film) = state.sensor.as_ref().zip(state.film.as_ref())?;
        Some(objects::sensor(sensor, film, &to_world))
    }
}

/// The plugin of a thing in the spelling of its file.
fn plugin_in_file(world: &World, thing: Entity, state: &ObjectState) -> Option<Object> {
    let plugin = plugin_of(world, state)?;
    Some(Draft::new(world.get::<Authored>(thing), plugin).object)
}
