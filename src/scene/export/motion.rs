//! Key frames of poses as animations of glTF: linear between times, with rotations along the shortest arc.

use bevy::math::{Affine3A, Quat, Vec3};

use super::messages::Messages;
use super::poses::{map_of, pose_of};
use crate::document::{Interpolation, Track, TransformOp, Value};
use crate::gltf::write::model::Pose;
use crate::gltf::write::{self, GltfWriter};
use crate::scene::{KeyPath, Keys};

/// The largest deviation of interpolated poses, relative to the size of things and to the distance between two keys.
const TOLERANCE: f32 = 1e-3;
/// How often the interval between two keys may be halved.
const HALVINGS: u32 = 6;

/// The motion of a thing: its pose at each time.
pub(super) struct Motion<'m> {
    pub keys: &'m Keys,
    /// The transform to local space from that of a value of the thing, such as the centre of a sphere within its shape.
    pub local: &'m dyn Fn(&Value) -> Option<Affine3A>,
}

/// The map of a value that places a thing.
pub(super) fn placed(value: &Value) -> Option<Affine3A> {
    match value {
        Value::Transform(steps) => Some(TransformOp::compose(steps)),
        Value::Point(place) => Some(Affine3A::from_translation(*place)),
        Value::Vector(direction) => direction
            .try_normalize()
            .map(|_| crate::scene::components::emitter::frame_along(*direction)),
        _ => None,
    }
}

impl Motion<'_> {
    /// The track of the pose, if it is animated.
    fn track(&self) -> Option<&Track> {
        let mut tracks = self.keys.tracks();
        tracks.find(|(path, _)| path.is_place()).map(|(_, track)| &**track)
    }

    /// Animates a node as the thing is; motion that glTF cannot express is noted.
    pub fn write(&self, node: usize, kind: &'static str, name: &str, writer: &mut GltfWriter, messages: &mut Messages) {
        let others: Vec<&KeyPath> = self
            .keys
            .tracks()
            .map(|(path, _)| path)
            .filter(|path| !path.is_place())
            .collect();
        if !others.is_empty() || self.keys.follows() {
            let listed: Vec<String> = others.iter().map(|path| format!("`{path}`")).collect();
            let what = if listed.is_empty() {
                "what it refers to".to_owned()
            } else {
                listed.join(", ")
            };
            messages.note(kind, name, format!("only the place moves, {what} does not"));
        }
        let Some(track) = self.track() else {
            return;
        };
        if track.span().0 < 0.0 {
            messages.note(kind, name, "the keys before 0 s are left out, where glTF has no time");
        }
        let Some(keys) = self.poses(track) else {
            let what = "nothing moves, because a pose at a key or between two shears or has no extent";
            messages.note(kind, name, what);
            return;
        };
        if keys.windows(2).all(|pair| pair[0].1 == pair[1].1) {
            return;
        }
        let interpolation = match track.interpolation {
            Interpolation::Step => write::Interpolation::Step,
            Interpolation::Linear | Interpolation::Ease => write::Interpolation::Linear,
        };
        let times: Vec<f32> = keys.iter().map(|(time, _)| *time).collect();
        let times = writer.add_times(&times);
        let shifts: Vec<[f32; 3]> = keys.iter().map(|(_, pose)| pose.translation).collect();
        let turns: Vec<[f32; 4]> = keys.iter().map(|(_, pose)| pose.rotation).collect();
        let scales: Vec<[f32; 3]> = keys.iter().map(|(_, pose)| pose.scale).collect();
        // A node without a channel keeps its rest pose.
        if differ(&shifts) {
            writer.animate(node, "translation", times, &shifts, interpolation);
        }
        if differ(&turns) {
            writer.animate(node, "rotation", times, &turns, interpolation);
        }
        if differ(&scales) {
            writer.animate(node, "scale", times, &scales, interpolation);
        }
    }

    fn pose(&self, track: &Track, time: f32) -> Option<Pose> {
        pose_of(&(self.local)(&track.at(f64::from(time)))?)
    }

    /// The poses at ascending times from 0 s on. None if glTF cannot express one of them.
    fn poses(&self, track: &Track) -> Option<Vec<(f32, Pose)>> {
        let mut times: Vec<f32> = track.keys.iter().map(|key| key.time as f32).collect();
        // Animations of glTF begin at 0 s at the earliest.
        if times.iter().any(|time| *time < 0.0) {
            times.retain(|time| *time > 0.0);
            times.insert(0, 0.0);
        }
        times.dedup();
        let mut keys: Vec<(f32, Pose)> = Vec::new();
        for time in times {
            let pose = self.pose(track, time)?;
            if let Some(start) = keys
                .last()
                .copied()
                .filter(|_| track.interpolation != Interpolation::Step)
            {
                self.add_between(track, start, (time, pose), &mut keys)?;
            }
            keys.push((time, pose));
        }
        // Rotations follow the shortest arc if neighbouring quaternions are on one side.
        for index in 1..keys.len() {
            let before = Quat::from_array(keys[index - 1].1.rotation);
            let turn = Quat::from_array(keys[index].1.rotation);
            if before.dot(turn) < 0.0 {
                keys[index].1.rotation = (-turn).to_array();
            }
        }
        Some(keys)
    }

    /// Adds poses between two until the interpolation is close to the true pose.
    fn add_between(
        &self,
        track: &Track,
        start: (f32, Pose),
        end: (f32, Pose),
        keys: &mut Vec<(f32, Pose)>,
    ) -> Option<()> {
        let mut extent = distance(&start.1, &end.1);
        for share in [0.25, 0.5, 0.75] {
            let pose = self.pose(track, start.0 + share * (end.0 - start.0))?;
            extent = extent.max(distance(&pose, &start.1));
        }
        // A stack of the intervals that are still to be checked, the earliest on top.
        let mut waiting = vec![(start, end, HALVINGS)];
        while let Some((start, end, halvings)) = waiting.pop() {
            let middle = start.0 + 0.5 * (end.0 - start.0);
            if halvings > 0 && start.0 < middle && middle < end.0 && !self.is_straight(track, start, end, extent)? {
                let middle = (middle, self.pose(track, middle)?);
                waiting.push((middle, end, halvings - 1));
                waiting.push((start, middle, halvings - 1));
            } else if !waiting.is_empty() {
                keys.push(end);
            }
        }
        Some(())
    }

    /// Whether glTF's interpolation between two poses is close to the true one.
    fn is_straight(&self, track: &Track, start: (f32, Pose), end: (f32, Pose), extent: f32) -> Option<bool> {
        for share in [0.25, 0.5, 0.75] {
            let exact = map_of(&self.pose(track, start.0 + share * (end.0 - start.0))?);
            let guess = map_of(&between(&start.1, &end.1, share));
            let axes = |map: &Affine3A| [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
            let size = axes(&exact).map(|axis| axis.length()).into_iter().fold(0.0, f32::max);
            let mut pairs = axes(&exact).into_iter().zip(axes(&guess));
            if !pairs.all(|(exact, guess)| exact.distance(guess) <= TOLERANCE * size)
                || exact.translation.distance(guess.translation) > TOLERANCE * extent
            {
                return Some(false);
            }
        }
        Some(true)
    }
}

fn differ<T: PartialEq>(values: &[T]) -> bool {
    values.windows(2).any(|pair| pair[0] != pair[1])
}

fn distance(a: &Pose, b: &Pose) -> f32 {
    Vec3::from(a.translation).distance(b.translation.into())
}

fn between(from: &Pose, to: &Pose, share: f32) -> Pose {
    let mix = |from: [f32; 3], to: [f32; 3]| Vec3::from(from).lerp(to.into(), share).to_array();
    let turn = Quat::from_array(from.rotation).slerp(Quat::from_array(to.rotation), share);
    Pose {
        translation: mix(from.translation, to.translation),
        rotation: turn.to_array(),
        scale: mix(from.scale, to.scale),
    }
}
