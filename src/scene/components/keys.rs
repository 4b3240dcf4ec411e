//! The key frames of a thing: a track for each animated value.
//!
//! The components of an entity have the values at the shown time. [`Keys`] has the tracks, by the names of the values
//! in the file, so that every value in a file can be animated in the same way: [`crate::scene::edits::posing`] writes
//! the values at a time into the plugins of the file and reads the components from them.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::{self, Display};
use std::sync::Arc;

use bevy::prelude::*;
use smol_str::{SmolStr, format_smolstr};

use crate::document::animation::{MOST_TIME, is_animated, key_time};
use crate::document::{Category, Child, Index, Interpolation, Key, Object, Property, Span, Track, Value};

/// The parameters that place a thing, in the order in which they are tried.
const PLACES: [&str; 3] = ["to_world", "position", "direction"];

/// Parameters that replace each other: writing the first removes the others.
const SUPERSEDES: [(&str, &[&str]); 9] = [
    ("fov", &["focal_length"]),
    ("focal_length", &["fov", "fov_axis"]),
    ("alpha", &["alpha_u", "alpha_v"]),
    ("material", &["eta", "k"]),
    ("eta", &["material"]),
    ("k", &["material"]),
    ("position", &["to_world"]),
    ("direction", &["to_world"]),
    ("to_world", &["position", "direction"]),
];

/// The parameters that this one replaces.
pub(in crate::scene) fn superseded_by(name: &str) -> &'static [&'static str] {
    let found = SUPERSEDES.iter().find(|(winner, _)| *winner == name);
    found.map_or(&[], |(_, others)| others)
}

/// The most animated values of a thing. Real things have fewer, and showing a time looks up each of them.
pub(in crate::scene) const MOST_TRACKS: usize = 1000;

/// The path of a value in the plugin of a thing: the parameter's name, after the names of the plugins around it, joined
/// by dots: `to_world`, `emitter.radiance`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct KeyPath(SmolStr);

impl KeyPath {
    /// The path given by this text.
    pub fn new(path: impl Into<SmolStr>) -> Self {
        Self(path.into())
    }

    /// The path as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Whether it is a parameter that places the thing.
    pub fn is_place(&self) -> bool {
        PLACES.contains(&self.as_str())
    }
}

impl Display for KeyPath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// The tracks of the animated values of a thing; absent if there are none.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct Keys {
    tracks: BTreeMap<KeyPath, Arc<Track>>,
    /// Whether it refers to an animated element that is no thing itself, such as a texture at the top level of the
    /// file.
    follows: bool,
}

/// The tracks of the integrator's settings. The integrator is no entity; [`crate::scene::IntegratorSettings`] has the
/// values at the shown time.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct IntegratorKeys(pub Keys);

impl Keys {
    /// The tracks of a plugin in the file. None if nothing of it is animated. `animated`: the
    /// [`animated_objects`](crate::document::animation::animated_objects) of the file. Many plugins may refer to one
    /// large object, which is not traversed for each of them.
    pub(in crate::scene) fn of(object: &Object, index: &Index, animated: &HashSet<usize>) -> Option<Self> {
        let mut keys = Self::default();
        keys.collect(object, index, animated, "");
        (!keys.is_empty()).then_some(keys)
    }

    fn collect(&mut self, object: &Object, index: &Index, animated: &HashSet<usize>, before: &str) {
        for property in &object.properties {
            if let Some(track) = &property.keys
                && self.tracks.len() < MOST_TRACKS
            {
                let path = KeyPath(format_smolstr!("{before}{}", property.name));
                self.tracks.insert(path, track.clone());
            }
        }
        let mut steps = Steps::default();
        for child in &object.children {
            let step = steps.next(child);
            let Some(inner) = index.resolve(child).filter(|inner| is_part(inner)) else {
                continue;
            };
            if !animated.contains(&std::ptr::from_ref(inner).addr()) {
                continue;
            }
            match child {
                Child::Object(_) => self.collect(inner, index, animated, &format!("{before}{step}.")),
                Child::Reference { .. } => self.follows = true,
            }
        }
    }

    /// Whether nothing is animated.
    pub(in crate::scene) fn is_empty(&self) -> bool {
        self.tracks.is_empty() && !self.follows
    }

    /// Whether it refers to an animated element.
    pub(in crate::scene) fn follows(&self) -> bool {
        self.follows
    }

    /// An estimate of the allocated memory in bytes. Shared tracks count in full.
    pub(crate) fn bytes(&self) -> usize {
        /// The size of the steps of a transform.
        const VALUE: usize = 128;
        let tracks = self.tracks.values();
        tracks.map(|track| track.keys.len() * (size_of::<Key>() + VALUE)).sum()
    }

    /// The tracks, in the order of their paths.
    pub fn tracks(&self) -> impl Iterator<Item = (&KeyPath, &Arc<Track>)> {
        self.tracks.iter()
    }

    /// The track of a value.
    pub fn track(&self, path: &KeyPath) -> Option<&Arc<Track>> {
        self.tracks.get(path)
    }

    /// The keys with the track for this value replaced, or removed if None.
    pub fn with(&self, path: &KeyPath, track: Option<Track>) -> Self {
        let mut keys = self.clone();
        match track {
            Some(track) => keys.tracks.insert(path.clone(), Arc::new(track)),
            None => keys.tracks.remove(path),
        };
        keys
    }

    /// These keys as a component: None if there are none.
    pub fn some(self) -> Option<Self> {
        (!self.is_empty()).then_some(self)
    }

    /// The path by which these keys or the plugin place the thing.
    pub fn place_in(keys: Option<&Self>, object: &Object) -> KeyPath {
        let has_track = |name: &&&str| keys.is_some_and(|keys| keys.track(&KeyPath::new(**name)).is_some());
        let has_value = |name: &&&str| object.properties.iter().any(|property| property.name == **name);
        let name = PLACES.iter().find(has_track).or_else(|| PLACES.iter().find(has_value));
        KeyPath::new(*name.unwrap_or(&PLACES[0]))
    }

    /// Gives a plugin exactly these tracks. The values become those at the time in seconds.
    pub(in crate::scene) fn attach(keys: Option<&Self>, object: &mut Object, time: f64) {
        detach(object);
        for (path, track) in keys.into_iter().flat_map(Self::tracks) {
            if let Some(property) = property_at(object, path.as_str()) {
                property.value = track.at(time);
                property.keys = Some(track.clone());
            }
        }
    }
}

/// The number of animated values of a plugin, without nested things.
pub(in crate::scene) fn track_count(object: &Object) -> usize {
    let own = object.properties.iter().filter(|property| property.keys.is_some());
    let parts = object.objects().filter(|inner| is_part(inner));
    own.count() + parts.map(track_count).sum::<usize>()
}

/// Removes all tracks from a plugin. Nested things keep theirs.
pub(in crate::scene) fn detach(object: &mut Object) {
    for property in &mut object.properties {
        property.keys = None;
    }
    for child in &mut object.children {
        if let Child::Object(inner) = child
            && is_part(inner)
            && is_animated(inner)
        {
            detach(Arc::make_mut(inner));
        }
    }
}

/// The value at a path; None if the plugin does not give it.
pub(in crate::scene) fn value_at<'o>(object: &'o Object, path: &str) -> Option<&'o Value> {
    if let Some(property) = object.properties.iter().find(|property| property.name == path) {
        return Some(&property.value);
    }
    let (place, rest) = inner(object, path).or_else(|| constant_volume(object, path))?;
    match &object.children[place] {
        Child::Object(inner) => value_at(inner, rest),
        Child::Reference { .. } => None,
    }
}

/// The property at a path, which is added if its plugin exists and gives the parameter in no other form.
fn property_at<'o>(object: &'o mut Object, path: &str) -> Option<&'o mut Property> {
    if let Some(place) = object.properties.iter().position(|property| property.name == path) {
        return Some(&mut object.properties[place]);
    }
    if let Some((place, rest)) = inner(object, path).or_else(|| constant_volume(object, path)) {
        return match &mut object.children[place] {
            Child::Object(inner) => property_at(Arc::make_mut(inner), rest),
            Child::Reference { .. } => None,
        };
    }
    if path.contains('.') || object.children.iter().any(|child| child.name() == Some(path)) {
        return None;
    }
    let others = superseded_by(path);
    object.properties.retain(|property| !others.contains(&&*property.name));
    let property = Property::new(path, Value::Float(0.0), Span::default());
    object.properties.push(property);
    object.properties.last_mut()
}

/// The index of the nested plugin that a path enters, and the rest of the path.
fn inner<'p>(object: &Object, path: &'p str) -> Option<(usize, &'p str)> {
    let (first, rest) = path.split_once('.')?;
    let numbered = first.rsplit_once('#');
    let numbered = numbered.and_then(|(name, number)| Some((name, number.parse::<usize>().ok()?)));
    let mut count = 0;
    let place = object.children.iter().position(|child| {
        let name = step_name(child);
        let is_numbered = numbered.is_some_and(|(numbered, number)| {
            count += usize::from(numbered == name);
            numbered == name && count == number
        });
        name == first || is_numbered
    })?;
    Some((place, rest))
}

/// The index of the constant volume with the value of a parameter, and the volume's own parameter. A colour is written
/// in such a volume as soon as it is above one, and its track goes with it.
fn constant_volume<'p>(object: &Object, path: &str) -> Option<(usize, &'p str)> {
    let is_one = |child: &Child| matches!(child, Child::Object(inner) if inner.plugin == "constvolume");
    let mut children = object.children.iter();
    let place = children.position(|child| child.name() == Some(path) && is_one(child))?;
    Some((place, "value"))
}

/// Numbers the steps of paths into the nested plugins, visited in order, if several have one name.
#[derive(Default)]
struct Steps<'o> {
    counts: HashMap<&'o str, usize>,
}

impl<'o> Steps<'o> {
    fn next(&mut self, child: &'o Child) -> SmolStr {
        let name = step_name(child);
        let count = self.counts.entry(name).or_default();
        *count += 1;
        match *count {
            1 => name.into(),
            count => format_smolstr!("{name}#{count}"),
        }
    }
}

/// The step of a path into a plugin without its number: the parameter name, or else the tag.
fn step_name(child: &Child) -> &str {
    match child {
        Child::Object(inner) => inner.name.as_deref().unwrap_or_else(|| inner.category.name()),
        Child::Reference { name, .. } => name.as_deref().unwrap_or_default(),
    }
}

/// Whether a nested plugin is a part of its thing, and no thing of its own.
pub(in crate::scene) fn is_part(inner: &Object) -> bool {
    !matches!(inner.category, Category::Bsdf | Category::Shape | Category::Medium)
}

/// A change of the track of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum KeyEdit {
    /// Sets a key with the present value at the shown time.
    Set,
    /// Removes the key at the shown time; the last key goes with the track.
    Remove,
    /// Removes all keys: the value at the shown time stays.
    RemoveAll,
    /// Moves a key from one time to another, in seconds, in place of a key there.
    Move {
        /// The time of the key.
        from: f64,
        /// Its new time.
        to: f64,
    },
    /// Sets the interpolation between keys.
    Interpolate(Interpolation),
}

impl KeyEdit {
    /// The track after the edit. `time` is the shown time, `value` the value then, `track` the present track. None: the
    /// value is not animated any more. An error, in words, if the edit is impossible.
    pub(in crate::scene) fn apply(
        self,
        track: Option<&Track>,
        value: Option<&Value>,
        time: f64,
    ) -> Result<Option<Track>, String> {
        let time = key_time(time);
        let Some(track) = track else {
            let value = match (self, value) {
                (Self::Set, Some(value)) => value.clone(),
                (Self::Set, None) => return Err("there is no such value".to_owned()),
                _ => return Err("it has no keys".to_owned()),
            };
            return Ok(Some(Track {
                keys: vec![Key { time, value }],
                interpolation: Interpolation::default(),
            }));
        };
        let mut track = track.clone();
        let place = |track: &Track, time: f64| {
            let place = track.keys.iter().position(|key| key.time == key_time(time));
            place.ok_or_else(|| format!("it has no key at {time} s"))
        };
        match self {
            Self::Set => return Ok(track.with_key(time, track.at(time))),
            Self::RemoveAll => return Ok(None),
            Self::Remove => {
                track.keys.remove(place(&track, time)?);
            }
            Self::Move { to, .. } if !(-MOST_TIME..=MOST_TIME).contains(&to) => {
                return Err("there is no such time".to_owned());
            }
            Self::Move { from, to } => {
                let key = track.keys.remove(place(&track, from)?);
                let to = key_time(to);
                track.keys.retain(|key| key.time != to);
                let place = track.keys.partition_point(|key| key.time < to);
                track.keys.insert(place, Key { time: to, ..key });
            }
            Self::Interpolate(interpolation) => track.interpolation = interpolation,
        }
        Ok((!track.keys.is_empty()).then_some(track))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_one_name_are_numbered() {
        let light = |number: f32| Object::new(Category::Emitter, "area").with("radiance", Value::Float(number));
        let mut named = light(3.0);
        named.name = Some("emitter#2".into());
        let shape = Object::new(Category::Shape, "sphere");
        let mut shape = [light(1.0), light(2.0), named, light(4.0)]
            .into_iter()
            .fold(shape, Object::with_child);
        let mut steps = Steps::default();
        let steps: Vec<SmolStr> = shape.children.iter().map(|child| steps.next(child)).collect();
        // Of two parts with one step the first counts.
        assert_eq!(steps, ["emitter", "emitter#2", "emitter#2", "emitter#3"]);
        for (step, value) in [
            ("emitter", Some(1.0)),
            ("emitter#2", Some(2.0)),
            ("emitter#3", Some(4.0)),
            ("emitter#4", None),
            ("emitter#0", None),
            ("light", None),
        ] {
            let path = format!("{step}.radiance");
            assert_eq!(value_at(&shape, &path), value.map(Value::Float).as_ref(), "{path}");
            let property = property_at(&mut shape, &path);
            assert_eq!(property.map(|property| property.value.clone()), value.map(Value::Float));
        }
    }
}
