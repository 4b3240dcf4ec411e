//! Animations: the curves of the translation, rotation and scale of nodes (glTF 2.0, section 3.11).
//!
//! All animations play together from 0 s on. An animation that cannot be read, or that drives a part of a node's pose
//! that an earlier one drives, is left out as a whole, because files hold alternatives ("walk", "run") as well as the
//! parts of one motion.

mod weights;

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use glam::{Mat4, Quat, Vec3, Vec4};

use super::schema::{Animation, AnimationSampler, Node};
use super::{Gltf, GltfError};
use crate::document::animation::MOST_TIME;

/// The scale that replaces smaller ones, above all 0, by which animations hide objects: shapes must not be flattened.
const LEAST_SCALE: f32 = 1e-4;

/// The animations of a file.
#[derive(Default)]
pub(super) struct Animations {
    /// The curves of each node, by its index.
    pub nodes: HashMap<usize, Curves>,
    /// The morph weights of each node at 0 s.
    pub weights: HashMap<usize, Rc<[f32]>>,
    /// The parts that are left out.
    pub passed_over: PassedOver,
}

/// The animated parts of a node's pose.
#[derive(Clone, Default)]
pub(super) struct Curves {
    translation: Option<Curve<3>>,
    rotation: Option<Curve<4>>,
    scale: Option<Curve<3>>,
}

/// A curve of vectors over time.
#[derive(Clone)]
struct Curve<const N: usize> {
    /// Ascending, in seconds; at least one.
    times: Rc<[[f32; 1]]>,
    /// One value for each time; for cubic curves three: in-tangent, value, out-tangent.
    values: Rc<[[f32; N]]>,
    way: Way,
}

/// The interpolation between values.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Way {
    Step,
    Linear,
    Cubic,
}

/// The parts of a pose.
#[derive(Clone)]
enum Part {
    Translation(Curve<3>),
    Rotation(Curve<4>),
    Scale(Curve<3>),
}

/// The elements of an accessor.
#[derive(Clone)]
struct Elements<const N: usize> {
    list: Rc<[[f32; N]]>,
    /// The reason why they cannot be used, if there is one.
    fault: Option<&'static str>,
}

/// The accessors read so far, because many curves share their times; for an unreadable one, the reason.
type Read<const N: usize> = HashMap<usize, Result<Elements<N>, String>>;

struct Known {
    times: Read<1>,
    triples: Read<3>,
    quadruples: Read<4>,
    /// The number of bytes of elements that may still be read.
    left: u64,
}

impl Gltf {
    pub(super) fn animations(&self) -> Animations {
        let mut all = Animations::default();
        let mut known = Known {
            times: HashMap::new(),
            triples: HashMap::new(),
            quadruples: HashMap::new(),
            left: self.curve_allowance(),
        };
        // The indices of the animations that drive each part of each node.
        let mut drivers: HashMap<(usize, &str), usize> = HashMap::new();
        for (index, animation) in self.root.animations.iter().enumerate() {
            let parts = match self.parts((index, animation), &mut known, &mut all.passed_over) {
                Ok(parts) => parts,
                Err(error) => {
                    let sentence = || format!("{} is left out: {error}", self.animation_title(index));
                    all.passed_over.note(Kind::Broken, sentence);
                    continue;
                }
            };
            let rival = parts.keys().find_map(|key| Some((key, drivers.get(key)?)));
            if let Some(((node, path), rival)) = rival {
                all.passed_over.note(Kind::Rival, || {
                    let node = self.node_title(*node);
                    let [title, rival] = [index, *rival].map(|animation| self.animation_title(animation));
                    format!("{title} is left out: it drives the {path} of {node}, as {rival} does")
                });
                continue;
            }
            for channel in animation
                .channels
                .iter()
                .filter(|channel| channel.target.path == "weights")
            {
                if let Some(node) = channel.target.node.filter(|node| !all.weights.contains_key(node))
                    && let Ok(weights) = self.first_weights(node, animation, channel, &mut known)
                    && !weights.is_empty()
                {
                    all.weights.insert(node, weights);
                }
            }
            for ((node, path), part) in parts {
                drivers.insert((node, path), index);
                let curves = all.nodes.entry(node).or_default();
                match part {
                    Part::Translation(curve) => curves.translation = Some(curve),
                    Part::Rotation(curve) => curves.rotation = Some(curve),
                    Part::Scale(curve) => curves.scale = Some(curve),
                }
            }
        }
        all
    }

    /// The node's index with its name.
    pub(super) fn node_title(&self, index: usize) -> String {
        let name = self.root.nodes.get(index).and_then(|node| node.name.as_deref());
        format!("node {index} ({})", short(name.unwrap_or("unnamed")))
    }

    /// The animation's index with its name.
    fn animation_title(&self, index: usize) -> String {
        match &self.root.animations[index].name {
            Some(name) => format!("animation {index} ({})", short(name)),
            None => format!("animation {index}"),
        }
    }

    /// The curves of an animation, by the node and the path of their targets.
    fn parts<'a>(
        &self,
        (number, animation): (usize, &'a Animation),
        known: &mut Known,
        passed_over: &mut PassedOver,
    ) -> Result<BTreeMap<(usize, &'a str), Part>, GltfError> {
        let mut parts = BTreeMap::new();
        let mut here = PassedOver::default();
        for channel in &animation.channels {
            let path = channel.target.path.as_str();
            // Targets without a node belong to extensions.
            let Some(index) = channel.target.node else {
                continue;
            };
            if !["translation", "rotation", "scale"].contains(&path) {
                let (kind, what, fate) = match path {
                    "weights" => (Kind::Weights, "morph weights", "stay as they are at 0 s"),
                    _ => (Kind::Property, path, "are not read"),
                };
                here.note(kind, || {
                    let (title, node) = (self.animation_title(number), self.node_title(index));
                    format!("{title}: the {} of {node} {fate}", short(what))
                });
                continue;
            }
            let node = self.get("node", &self.root.nodes, index)?;
            if node.matrix.is_some() {
                here.note(Kind::Matrix, || {
                    let (title, node) = (self.animation_title(number), self.node_title(index));
                    format!("{title}: {node} has a matrix and stands still")
                });
                continue;
            }
            let sampler = self.get("sampler", &animation.samplers, channel.sampler)?;
            let part = match path {
                "translation" => Part::Translation(self.curve(channel.sampler, sampler, known, "VEC3")?),
                "rotation" => Part::Rotation(self.curve(channel.sampler, sampler, known, "VEC4")?),
                _ => Part::Scale(self.curve(channel.sampler, sampler, known, "VEC3")?),
            };
            parts.entry((index, path)).or_insert(part);
        }
        passed_over.append(here);
        Ok(parts)
    }

    fn curve<const N: usize>(
        &self,
        index: usize,
        sampler: &AnimationSampler,
        known: &mut Known,
        kind: &str,
    ) -> Result<Curve<N>, GltfError>
    where
        Known: Holds<N>,
    {
        let bad = |what: String| GltfError::Sampler { index, what };
        let way = match sampler.interpolation.as_deref().unwrap_or("LINEAR") {
            "STEP" => Way::Step,
            "LINEAR" => Way::Linear,
            "CUBICSPLINE" => Way::Cubic,
            other => return Err(bad(format!("has the unknown interpolation `{other}`"))),
        };
        let input = self.shared::<1>(sampler.input, "SCALAR", known, fault_of_times)?;
        let output = self.shared::<N>(sampler.output, kind, known, fault_of_values)?;
        let (times, values) = (input.list, output.list);
        let expected = match way {
            Way::Cubic => times.len().saturating_mul(3),
            Way::Step | Way::Linear => times.len(),
        };
        if times.is_empty() {
            return Err(bad("has no keys".to_owned()));
        }
        if values.len() != expected {
            let (keys, found) = (times.len(), values.len());
            return Err(bad(format!(
                "has {keys} times, to which {expected} values belong, but {found} values"
            )));
        }
        match input.fault.or(output.fault) {
            Some(fault) => Err(bad(fault.to_owned())),
            None => Ok(Curve { times, values, way }),
        }
    }

    /// The elements of an accessor, which are read and checked only once.
    fn shared<const N: usize>(
        &self,
        index: usize,
        kind: &str,
        known: &mut Known,
        fault: fn(&[[f32; N]]) -> Option<&'static str>,
    ) -> Result<Elements<N>, GltfError>
    where
        Known: Holds<N>,
    {
        let bad = |what: String| GltfError::Accessor { index, what };
        if let Some(read) = known.of_width().get(&index) {
            return read.clone().map_err(bad);
        }
        let bytes = 4 * N as u64 * self.accessor(index)?.count as u64;
        let left = known.left.checked_sub(bytes);
        known.left = left.ok_or_else(|| bad("is one of too many for the size of the buffers".to_owned()))?;
        let read = match self.vectors(index, kind, None) {
            Ok(list) => Ok(Elements {
                fault: fault(&list),
                list: list.into(),
            }),
            Err(GltfError::Accessor { what, .. }) => Err(what),
            Err(other) => return Err(other),
        };
        known.of_width().insert(index, read.clone());
        read.map_err(bad)
    }
}

fn fault_of_times(times: &[[f32; 1]]) -> Option<&'static str> {
    if !times.is_sorted_by(|a, b| a[0] < b[0]) || !times.iter().all(|time| time[0].is_finite()) {
        return Some("has times that do not rise");
    }
    let is_late = times.iter().any(|time| f64::from(time[0].abs()) > MOST_TIME);
    is_late.then_some("has times beyond 1e9 s")
}

fn fault_of_values<const N: usize>(values: &[[f32; N]]) -> Option<&'static str> {
    let are_finite = values.iter().flatten().all(|number| number.is_finite());
    (!are_finite).then_some("has values that are not finite")
}

/// Implemented by lists of accessors with `N` numbers per element.
trait Holds<const N: usize> {
    fn of_width(&mut self) -> &mut Read<N>;
}

impl Holds<1> for Known {
    fn of_width(&mut self) -> &mut Read<1> {
        &mut self.times
    }
}

impl Holds<3> for Known {
    fn of_width(&mut self) -> &mut Read<3> {
        &mut self.triples
    }
}

impl Holds<4> for Known {
    fn of_width(&mut self) -> &mut Read<4> {
        &mut self.quadruples
    }
}

impl Curves {
    /// The transform parent from local at a time in seconds.
    pub fn local(&self, node: &Node, time: f32) -> Mat4 {
        let triple = |curve: &Option<Curve<3>>, rest: Option<[f32; 3]>| match curve {
            Some(curve) => Some(curve.at(time, |from, to, share| {
                Vec3::from(from).lerp(Vec3::from(to), share).to_array()
            })),
            None => rest,
        };
        let turn = |curve: &Curve<4>| {
            // Rotations along the shortest arc.
            curve.at(time, |from, to, share| {
                rotation(from).slerp(rotation(to), share).to_array()
            })
        };
        let scale = triple(&self.scale, node.scale).map_or(Vec3::ONE, Vec3::from);
        let seen = |size: f32| size.abs().max(LEAST_SCALE).copysign(size);
        Mat4::from_scale_rotation_translation(
            match self.scale {
                Some(_) => Vec3::from_array(scale.to_array().map(seen)),
                None => scale,
            },
            self.rotation
                .as_ref()
                .map(turn)
                .or(node.rotation)
                .map_or(Quat::IDENTITY, rotation),
            triple(&self.translation, node.translation).map_or(Vec3::ZERO, Vec3::from),
        )
    }

    /// Whether all curves have step interpolation.
    pub fn only_step(&self) -> bool {
        self.ways().all(|way| way == Way::Step)
    }

    fn ways(&self) -> impl Iterator<Item = Way> {
        let ways = [
            self.translation.as_ref().map(|curve| curve.way),
            self.rotation.as_ref().map(|curve| curve.way),
            self.scale.as_ref().map(|curve| curve.way),
        ];
        ways.into_iter().flatten()
    }

    /// The largest number of times that [`Self::times`] adds.
    pub fn most_times(&self) -> usize {
        let count = |times: Option<&Rc<[[f32; 1]]>>| times.map_or(0, |times| 2 * times.len());
        count(self.translation.as_ref().map(|curve| &curve.times))
            + count(self.rotation.as_ref().map(|curve| &curve.times))
            + count(self.scale.as_ref().map(|curve| &curve.times))
    }

    /// Adds the times in seconds between which the motion is smooth.
    pub fn add_times(&self, times: &mut Vec<f32>) {
        self.translation.iter().for_each(|curve| curve.add_times(times));
        self.rotation.iter().for_each(|curve| curve.add_times(times));
        self.scale.iter().for_each(|curve| curve.add_times(times));
    }
}

/// A name shortened for messages to 60 letters.
fn short(name: &str) -> Cow<'_, str> {
    match name.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &name[..end]).into(),
        None => name.into(),
    }
}

/// A rotation from the numbers of a file; the identity for a zero quaternion.
pub(super) fn rotation(turn: [f32; 4]) -> Quat {
    let unit = Vec4::from_array(turn).try_normalize();
    unit.map_or(Quat::IDENTITY, Quat::from_vec4)
}

/// The time of a jump: a rounding error before the key. Frames at n / 24 s must not come before a key that has the same
/// time in single precision.
fn jump(time: f32) -> f32 {
    time.next_down()
}

impl<const N: usize> Curve<N> {
    /// The value at a time in seconds; `mix` interpolates two values of a linear curve.
    fn at(&self, time: f32, mix: impl Fn([f32; N], [f32; N], f32) -> [f32; N]) -> [f32; N] {
        let after = match self.way {
            Way::Step => self.times.partition_point(|key| jump(key[0]) <= time),
            Way::Linear | Way::Cubic => self.times.partition_point(|key| key[0] <= time),
        };
        let value = |key: usize| match self.way {
            Way::Step | Way::Linear => self.values[key],
            Way::Cubic => self.values[3 * key + 1],
        };
        let Some(before) = after.checked_sub(1) else {
            return value(0);
        };
        if self.way == Way::Step || after == self.times.len() {
            return value(before);
        }
        let (start, end) = (self.times[before][0], self.times[after][0]);
        let share = (time - start) / (end - start);
        match self.way {
            Way::Cubic => {
                let [leaving, arriving] = [self.values[3 * before + 2], self.values[3 * after]];
                let (square, cube) = (share * share, share * share * share);
                let (from, to) = (value(before), value(after));
                std::array::from_fn(|i| {
                    (2.0 * cube - 3.0 * square + 1.0) * from[i]
                        + (cube - 2.0 * square + share) * (end - start) * leaving[i]
                        + (3.0 * square - 2.0 * cube) * to[i]
                        + (cube - square) * (end - start) * arriving[i]
                })
            }
            Way::Step | Way::Linear => mix(value(before), value(after), share),
        }
    }

    fn add_times(&self, times: &mut Vec<f32>) {
        let keys = self.times.iter().map(|key| key[0]);
        match self.way {
            Way::Linear | Way::Cubic => times.extend(keys),
            Way::Step => {
                times.push(self.times[0][0]);
                times.extend(keys.skip(1).flat_map(|key| [jump(key).next_down(), jump(key)]));
            }
        }
    }
}

/// The kinds of parts that are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A channel of morph weights.
    Weights,
    /// A channel of another property that is not read.
    Property,
    /// A channel of a node with a matrix.
    Matrix,
    /// An animation that drives a part that an earlier one drives.
    Rival,
    /// An animation that cannot be read.
    Broken,
}

impl Kind {
    fn things(self) -> &'static str {
        match self {
            Self::Weights | Self::Property | Self::Matrix => "channel",
            Self::Rival | Self::Broken => "animation",
        }
    }
}

/// The parts of animations that are left out: the first of each kind, in words, and the number of further ones, because
/// a file may have thousands of channels.
#[derive(Clone, Default)]
pub(super) struct PassedOver(Vec<(Kind, String, usize)>);

impl PassedOver {
    /// Adds one; `sentence` describes it, without a full stop.
    fn note(&mut self, kind: Kind, sentence: impl FnOnce() -> String) {
        self.add(kind, sentence, 0);
    }

    /// Adds all of `others`.
    fn append(&mut self, others: Self) {
        for (kind, sentence, more) in others.0 {
            self.add(kind, || sentence, more);
        }
    }

    fn add(&mut self, kind: Kind, sentence: impl FnOnce() -> String, more: usize) {
        match self.0.iter_mut().find(|(known, ..)| *known == kind) {
            Some((_, _, others)) => *others += 1 + more,
            None => self.0.push((kind, sentence(), more)),
        }
    }

    /// A sentence for each kind.
    pub fn sentences(self) -> impl Iterator<Item = String> {
        self.0.into_iter().map(|(kind, sentence, more)| match more {
            0 => sentence,
            1 => format!("{sentence}; so it is with another {}", kind.things()),
            _ => format!("{sentence}; so it is with {more} other {}s", kind.things()),
        })
    }
}
