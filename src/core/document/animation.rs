//! Key frames: `<animation name="...">` in place of a value, with a value tag for each key.
//!
//! ```xml
//! <animation name="to_world" interpolation="ease">
//!     <transform time="0"> <rotate y="1" angle="0"/> </transform>
//!     <transform time="2"> <rotate y="1" angle="360"/> </transform>
//! </animation>
//! ```
//!
//! The element has the form that Mitsuba 0.6 read for transforms. Here every value may have keys. Times are in seconds.
//! Before the first key and after the last one the value stays what it is there.
//!
//! A document always shows one moment: its properties have the values of that moment, and [`Document::at`] makes the
//! document of another one.

mod between;

use std::collections::HashSet;
use std::mem::discriminant;
use std::sync::Arc;

use glam::{Affine3A, Mat3A, Mat4, Vec3};

pub use self::between::affine_between;
use self::between::{are_alike, between};
use super::{Child, Document, Interpolation, Key, Object, Track, TransformOp, Value};

impl Interpolation {
    /// The eased fraction of a segment, in [0, 1], after the fraction `share` of its time.
    fn way(self, share: f64) -> f64 {
        match self {
            Self::Linear => share,
            Self::Ease => share * share * (3.0 - 2.0 * share),
            Self::Step => 0.0,
        }
    }
}

impl Track {
    /// The value at `time`, in seconds. A key also applies at times that round to its time in single precision: the
    /// time of a frame may be a rounding error before the key that a file has for this frame.
    pub fn at(&self, time: f64) -> Value {
        let reached = time.max(key_time(time));
        let after = self.keys.partition_point(|key| key.time <= reached);
        match (
            after.checked_sub(1).map(|before| &self.keys[before]),
            self.keys.get(after),
        ) {
            (Some(before), Some(after)) => {
                let share = (time - before.time).max(0.0) / (after.time - before.time);
                between(&before.value, &after.value, self.interpolation.way(share))
            }
            (Some(key), None) | (None, Some(key)) => key.value.clone(),
            (None, None) => unreachable!("a track has a key"),
        }
    }

    /// The track with the value `value` at `time`, in seconds, in place of a key there or as a new one. None if its
    /// keys are of another type.
    ///
    /// Whole turns stay whole: where keys are half a turn or more apart, and the steps of the new key are of other
    /// kinds, its difference becomes one more step of all keys, which is the identity in the others.
    pub fn with_key(&self, time: f64, value: Value) -> Option<Self> {
        let time = key_time(time);
        let mut track = self.clone();
        let value = match (&self.keys[0].value, value) {
            (Value::Spectrum(_), Value::Rgb(color)) if color == Vec3::splat(color.x) => Value::Spectrum(color.x),
            (Value::Spectrum(_), Value::Rgb(color)) => {
                for key in &mut track.keys {
                    if let Value::Spectrum(level) = key.value {
                        key.value = Value::Rgb(Vec3::splat(level));
                    }
                }
                Value::Rgb(color)
            }
            (Value::Transform(_), Value::Transform(steps)) if track.has_far_turns() => {
                let Value::Transform(old) = self.at(time) else {
                    return None;
                };
                Value::Transform(track.with_steps_like(&old, steps))
            }
            (_, value) => value,
        };
        if discriminant(&track.keys[0].value) != discriminant(&value) {
            return None;
        }
        let place = track.keys.partition_point(|key| key.time < time);
        match track.keys.get_mut(place).filter(|key| key.time == time) {
            Some(key) => key.value = value,
            None => track.keys.insert(place, Key { time, value }),
        }
        Some(track)
    }

    /// Whether neighbouring keys are half a turn or more apart, which steps of other kinds cannot express.
    fn has_far_turns(&self) -> bool {
        let far = |pair: (&TransformOp, &TransformOp)| match pair {
            (TransformOp::Rotate { degrees, .. }, TransformOp::Rotate { degrees: end, .. }) => {
                (end - degrees).abs() >= 180.0
            }
            _ => false,
        };
        let pairs = self
            .keys
            .windows(2)
            .map(|pair| [steps_of(&pair[0]), steps_of(&pair[1])]);
        pairs
            .into_iter()
            .any(|[one, other]| are_alike(one, other) && one.iter().zip(other).any(far))
    }

    /// The steps `now` of a new key in the kinds that all keys have; `old` are the present steps at that time. If these
    /// kinds cannot express them, all keys get one more step.
    fn with_steps_like(&mut self, old: &[TransformOp], now: Vec<TransformOp>) -> Vec<TransformOp> {
        if are_alike(old, &now) || !self.keys.iter().all(|key| are_alike(steps_of(key), old)) {
            return now;
        }
        let mut steps = old.to_vec();
        let (last, neutral) = match now.split_last() {
            Some((TransformOp::Translate(by), before)) if before == old => {
                (TransformOp::Translate(*by), TransformOp::Translate(Vec3::ZERO))
            }
            _ => {
                let is_tail = steps.len() > 1 && matches!(steps.last(), Some(TransformOp::Matrix(_)));
                if is_tail {
                    steps.pop();
                }
                let tail = TransformOp::compose(&now) * TransformOp::compose(&steps).inverse();
                (
                    TransformOp::Matrix(Mat4::from(tail)),
                    TransformOp::Matrix(Mat4::IDENTITY),
                )
            }
        };
        if steps.len() == old.len() {
            for key in &mut self.keys {
                if let Value::Transform(steps) = &mut key.value {
                    steps.push(neutral);
                }
            }
        }
        steps.push(last);
        steps
    }

    /// The track after a move by `by`, which is applied to the transform or the point of every key.
    pub fn moved(&self, by: &Affine3A) -> Self {
        let mut track = self.clone();
        for key in &mut track.keys {
            match &mut key.value {
                Value::Transform(steps) if by.matrix3 == Mat3A::IDENTITY => {
                    let offset = Vec3::from(by.translation);
                    match steps.last_mut() {
                        Some(TransformOp::Translate(last)) => *last += offset,
                        Some(TransformOp::LookAt { origin, target, .. }) => {
                            *origin += offset;
                            *target += offset;
                        }
                        _ => steps.push(TransformOp::Translate(offset)),
                    }
                }
                Value::Transform(steps) => steps.push(TransformOp::Matrix(Mat4::from(*by))),
                Value::Point(place) => *place = by.transform_point3(*place),
                Value::Vector(direction) => *direction = by.transform_vector3(*direction),
                _ => {}
            }
        }
        track
    }

    /// Whether there is a key at `time`, in seconds.
    pub fn has_key(&self, time: f64) -> bool {
        self.keys.iter().any(|key| key.time == key_time(time))
    }

    /// The times of the first and the last key in seconds.
    pub fn span(&self) -> (f64, f64) {
        (self.keys[0].time, self.keys[self.keys.len() - 1].time)
    }
}

impl Document {
    /// The document at a time in seconds: every animated property has its value at that time. Objects without keys are
    /// shared.
    pub fn at(&self, time: f64) -> Self {
        let mut document = Self { time, ..self.clone() };
        if let Some(root) = posed(&self.root, time) {
            document.root = root;
        }
        document
    }

    /// The times of the first and the last key in seconds; None if nothing is animated.
    pub fn animated_span(&self) -> Option<(f64, f64)> {
        span_of(&self.root)
    }
}

/// The times of the first and the last key in the subtree of an object, in seconds; None if nothing is animated.
pub fn span_of(object: &Object) -> Option<(f64, f64)> {
    let mut spans = Vec::new();
    let mut waiting = vec![object];
    while let Some(object) = waiting.pop() {
        let tracks = object.properties.iter().filter_map(|property| property.keys.as_ref());
        spans.extend(tracks.map(|track| track.span()));
        waiting.extend(object.objects());
    }
    let both = |(first, last): (f64, f64), (start, end)| (first.min(start), last.max(end));
    spans.into_iter().reduce(both)
}

/// The object at a time; None if nothing in its subtree is animated.
fn posed(object: &Arc<Object>, time: f64) -> Option<Arc<Object>> {
    let mut changed: Option<Object> = None;
    for (index, property) in object.properties.iter().enumerate() {
        if let Some(track) = &property.keys {
            let posed = changed.get_or_insert_with(|| Object::clone(object));
            posed.properties[index].value = track.at(time);
        }
    }
    for (index, child) in object.children.iter().enumerate() {
        if let Child::Object(inner) = child
            && let Some(inner) = posed(inner, time)
        {
            changed.get_or_insert_with(|| Object::clone(object)).children[index] = Child::Object(inner);
        }
    }
    changed.map(Arc::new)
}

/// Whether a property in the subtree of an object is animated.
pub fn is_animated(object: &Object) -> bool {
    object.properties.iter().any(|property| property.keys.is_some()) || object.objects().any(is_animated)
}

/// The addresses of `root` and the objects below it for which [`is_animated`] is true, found in one traversal.
pub fn animated_objects(root: &Object) -> HashSet<usize> {
    fn note(object: &Object, animated: &mut HashSet<usize>) -> bool {
        let mut is_animated = object.properties.iter().any(|property| property.keys.is_some());
        for inner in object.objects() {
            is_animated |= note(inner, animated);
        }
        if is_animated {
            animated.insert(std::ptr::from_ref(object).addr());
        }
        is_animated
    }
    let mut animated = HashSet::new();
    note(root, &mut animated);
    animated
}

/// The greatest absolute time of a key, in seconds.
pub const MOST_TIME: f64 = 1e9;

/// The time in seconds at which a key is stored for `time`: files hold times in single precision.
pub fn key_time(time: f64) -> f64 {
    f64::from(time as f32)
}

/// Removes all keys; properties keep their present values.
pub fn stand_still(object: &mut Object) {
    for property in &mut object.properties {
        property.keys = None;
    }
    for child in &mut object.children {
        if let Child::Object(inner) = child
            && is_animated(inner)
        {
            stand_still(Arc::make_mut(inner));
        }
    }
}

fn steps_of(key: &Key) -> &[TransformOp] {
    match &key.value {
        Value::Transform(steps) => steps,
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Category;

    fn track(interpolation: Interpolation, keys: &[(f64, Value)]) -> Track {
        let keys = keys.iter().cloned().map(|(time, value)| Key { time, value });
        Track {
            keys: keys.collect(),
            interpolation,
        }
    }

    #[test]
    fn all_that_moves_is_found_in_one_walk() {
        let key = Key {
            time: 0.0,
            value: Value::Float(1.0),
        };
        let track = Track {
            keys: vec![key],
            interpolation: Interpolation::Linear,
        };
        let object = |plugin: &str| Object::new(Category::Texture, plugin);
        let mut moving = object("moving").with("scale", Value::Float(1.0));
        moving.properties[0].keys = Some(Arc::new(track));
        let root = object("root")
            .with_child(object("around").with_child(object("still")).with_child(moving))
            .with_child(object("beside"));
        let animated = animated_objects(&root);
        let mut found = Vec::new();
        let mut waiting = vec![&root];
        while let Some(object) = waiting.pop() {
            let is_found = animated.contains(&std::ptr::from_ref(object).addr());
            assert_eq!(is_found, is_animated(object), "{}", object.plugin);
            found.extend(is_found.then_some(object.plugin.as_str()));
            waiting.extend(object.objects());
        }
        assert_eq!(found, ["root", "around", "moving"]);
        assert_eq!(animated.len(), 3);
    }

    #[test]
    fn numbers_go_from_key_to_key_and_hold_at_the_ends() {
        let keys = [
            (1.0, Value::Float(2.0)),
            (3.0, Value::Float(6.0)),
            (4.0, Value::Float(0.0)),
        ];
        let value = |interpolation, time| match track(interpolation, &keys).at(time) {
            Value::Float(value) => value,
            other => panic!("{other:?}"),
        };
        let linear = [
            (-5.0, 2.0),
            (1.0, 2.0),
            (2.0, 4.0),
            (3.0, 6.0),
            (3.25, 4.5),
            (4.0, 0.0),
            (9.0, 0.0),
        ];
        for (time, expected) in linear {
            assert_eq!(value(Interpolation::Linear, time), expected, "{time}");
        }
        // A quarter of the time is 5/32 of the interval.
        assert_eq!(value(Interpolation::Ease, 1.5), 2.0 + 4.0 * 5.0 / 32.0);
        assert_eq!(value(Interpolation::Step, 2.999), 2.0);
        assert_eq!(value(Interpolation::Step, 3.0), 6.0);
        assert_eq!(track(Interpolation::Linear, &keys).span(), (1.0, 4.0));
    }

    #[test]
    fn a_frame_has_the_value_of_its_key() {
        for fps in [23.976, 24.0, 29.97, 30.0, 60.0] {
            let time = |frame: i64| frame as f64 / fps;
            let keys = |of: fn(i64) -> Value| {
                (0..=48)
                    .map(|frame| (key_time(time(frame)), of(frame)))
                    .collect::<Vec<_>>()
            };
            let numbers = track(Interpolation::Step, &keys(Value::Integer));
            let texts = track(Interpolation::Linear, &keys(|frame| Value::String(frame.to_string())));
            let levels = track(Interpolation::Linear, &keys(|frame| Value::Float(frame as f32)));
            for frame in 0..=48 {
                assert_eq!(numbers.at(time(frame)), Value::Integer(frame), "{fps}");
                assert_eq!(texts.at(time(frame)), Value::String(frame.to_string()), "{fps}");
                let Value::Float(level) = levels.at(time(frame)) else {
                    panic!("a number");
                };
                assert!(level >= frame as f32 && level < frame as f32 + 1e-4, "{fps}: {level}");
                let before = time(frame) - 0.01 / fps;
                assert_eq!(numbers.at(before), Value::Integer((frame - 1).max(0)), "{fps}");
            }
        }
    }

    #[test]
    fn a_key_replaces_the_one_of_its_time_or_comes_between() {
        let track = track(
            Interpolation::Ease,
            &[(0.0, Value::Float(1.0)), (2.0, Value::Float(3.0))],
        );
        let times = |track: &Track| track.keys.iter().map(|key| key.time).collect::<Vec<_>>();
        let between = track.with_key(0.5, Value::Float(7.0)).expect("a number");
        assert_eq!(
            (times(&between), between.at(0.5)),
            (vec![0.0, 0.5, 2.0], Value::Float(7.0))
        );
        let replaced = track.with_key(2.0, Value::Float(7.0)).expect("a number");
        assert_eq!(
            (times(&replaced), replaced.at(9.0)),
            (vec![0.0, 2.0], Value::Float(7.0))
        );
        assert_eq!(track.with_key(1.0, Value::Integer(1)), None);
    }

    #[test]
    fn keys_of_even_spectra_become_colours_for_a_colour() {
        let even = track(
            Interpolation::Linear,
            &[(0.0, Value::Spectrum(1.0)), (2.0, Value::Spectrum(3.0))],
        );
        let grey = even.with_key(0.0, Value::Rgb(Vec3::splat(2.0))).expect("it is even");
        assert_eq!(grey.at(1.0), Value::Spectrum(2.5));
        let red = even.with_key(0.0, Value::Rgb(Vec3::X)).expect("a colour");
        assert_eq!(
            (red.at(0.0), red.at(2.0)),
            (Value::Rgb(Vec3::X), Value::Rgb(Vec3::splat(3.0)))
        );
    }
}
