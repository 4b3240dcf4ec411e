//! Key frames of things whose node, or a node above it, is animated.
//!
//! World transforms are taken at all key times of these nodes, and at times between them wherever the interpolation
//! would deviate from the true pose: the scene format interpolates linearly, but a rotation about another point moves
//! along an arc.

use glam::{Affine3A, Mat4, Vec4};

use super::animation::{Animations, Curves};
use super::nodes::PlacedNodes;
use super::{Gltf, GltfError};
use crate::document::animation::affine_between;
use crate::document::{Interpolation, Key, Property, Span, Track, Value};
use crate::math::is_invertible;

/// The most poses of nodes that are computed and kept for the key frames of a file. This limits memory, and the time
/// for nodes deep in a tree.
const MOST_POSES: usize = 1 << 24;

/// The largest deviation of interpolated poses: of axes relative to their length, of positions relative to the distance
/// between two keys of the file.
const TOLERANCE: f32 = 1e-3;
/// The rounding error of positions, relative to their coordinates.
const ROUNDING: f32 = 1e-6;
/// How often the interval between two keys of the file may be halved.
const HALVINGS: u32 = 6;

/// The world transform of a node over time.
pub(super) struct Placement {
    /// World from local, at 0 s.
    pub world: Mat4,
    /// Times in seconds with world transforms; empty if the node is not animated.
    pub keys: Vec<(f32, Mat4)>,
    pub interpolation: Interpolation,
}

impl Placement {
    pub fn still(world: Mat4) -> Self {
        Self {
            world,
            keys: Vec::new(),
            interpolation: Interpolation::Linear,
        }
    }

    pub fn moves(&self) -> bool {
        !self.keys.is_empty()
    }

    /// The property with values derived from world transforms.
    pub fn property(&self, name: &str, value: impl Fn(Mat4) -> Value) -> Property {
        let mut property = Property::new(name, value(self.world), Span::default());
        if self.moves() {
            let key = |&(time, world): &(f32, Mat4)| Key {
                time: f64::from(time),
                value: value(world),
            };
            let track = Track {
                keys: self.keys.iter().map(key).collect(),
                interpolation: self.interpolation,
            };
            property.value = track.at(0.0);
            property.keys = Some(track.into());
        }
        property
    }
}

/// The matrix with the exact last row of an affine map.
pub(super) fn affine(world: Mat4) -> Mat4 {
    let mut rows = world.transpose();
    rows.w_axis = Vec4::W;
    rows.transpose()
}

/// The motion of one node.
struct Motion<'a> {
    gltf: &'a Gltf,
    /// World from the parent of the first node.
    above: Mat4,
    /// The indices of nodes from the topmost animated one down to the node, with the curves of the animated ones.
    chain: Vec<(usize, Option<&'a Curves>)>,
}

/// The number of poses that may still be computed and kept.
pub(super) struct Allowance(usize);

impl Default for Allowance {
    fn default() -> Self {
        Self(MOST_POSES)
    }
}

impl Allowance {
    pub fn spend(&mut self, poses: usize) -> Result<(), GltfError> {
        self.0 = self.0.checked_sub(poses).ok_or(GltfError::Poses(MOST_POSES))?;
        Ok(())
    }
}

impl Gltf {
    /// The placement of the node at this index of the list. An error if there are too many key frames.
    pub(super) fn placement(
        &self,
        placed: &PlacedNodes,
        animations: &Animations,
        place: usize,
        allowance: &mut Allowance,
    ) -> Result<Placement, GltfError> {
        let node = &placed.nodes[place];
        let still = Placement::still(affine(node.world));
        if !node.moves {
            return Ok(still);
        }
        let mut chain = Vec::new();
        let mut above = Mat4::IDENTITY;
        let mut next = Some(place);
        while let Some(place) = next {
            let node = &placed.nodes[place];
            if !node.moves {
                above = node.world;
                break;
            }
            chain.push((node.index, animations.nodes.get(&node.index)));
            next = node.parent;
        }
        chain.reverse();
        let motion = Motion {
            gltf: self,
            above,
            chain,
        };
        let keys = motion.keys(allowance)?;
        let differ = keys.iter().any(|&(_, world)| world != keys[0].1);
        Ok(Placement {
            keys: if differ { keys } else { Vec::new() },
            interpolation: match motion.only_steps() {
                true => Interpolation::Step,
                false => Interpolation::Linear,
            },
            ..still
        })
    }
}

impl Motion<'_> {
    fn curves(&self) -> impl Iterator<Item = &Curves> {
        self.chain.iter().filter_map(|(_, curves)| *curves)
    }

    fn only_steps(&self) -> bool {
        self.curves().all(Curves::only_step)
    }

    fn world(&self, time: f32, allowance: &mut Allowance) -> Result<Mat4, GltfError> {
        allowance.spend(self.chain.len())?;
        let nodes = &self.gltf.root.nodes;
        let local = |(index, curves): &(usize, Option<&Curves>)| match curves {
            Some(curves) => curves.local(&nodes[*index], time),
            None => nodes[*index].local(),
        };
        Ok(affine(
            self.chain.iter().fold(self.above, |above, node| above * local(node)),
        ))
    }

    fn keys(&self, allowance: &mut Allowance) -> Result<Vec<(f32, Mat4)>, GltfError> {
        allowance.spend(self.curves().map(Curves::most_times).sum())?;
        let mut times = Vec::new();
        self.curves().for_each(|curves| curves.add_times(&mut times));
        times.sort_by(f32::total_cmp);
        times.dedup();
        let mut keys: Vec<(f32, Mat4)> = Vec::with_capacity(times.len());
        let only_steps = self.only_steps();
        for time in times {
            let world = self.world(time, allowance)?;
            let before = keys.last().copied();
            match before {
                // The time before a jump is needed if values are interpolated linearly.
                Some((_, old)) if only_steps && old == world => continue,
                Some(start) if !only_steps => self.add_between(start, (time, world), &mut keys, allowance)?,
                _ => {}
            }
            keys.push((time, world));
        }
        Ok(keys)
    }

    /// Adds keys between two until the interpolation is close to the true pose.
    fn add_between(
        &self,
        start: (f32, Mat4),
        end: (f32, Mat4),
        keys: &mut Vec<(f32, Mat4)>,
        allowance: &mut Allowance,
    ) -> Result<(), GltfError> {
        let mut extent = start.1.w_axis.distance(end.1.w_axis);
        for share in [0.25, 0.5, 0.75] {
            let world = self.world(start.0 + share * (end.0 - start.0), allowance)?;
            extent = extent.max(world.w_axis.distance(start.1.w_axis));
        }
        // A stack of the intervals that are still to be checked, the earliest on top.
        let mut waiting = vec![(start, end, HALVINGS)];
        while let Some((start, end, halvings)) = waiting.pop() {
            let middle = start.0 + 0.5 * (end.0 - start.0);
            if halvings > 0 && start.0 < middle && middle < end.0 && !self.is_straight(start, end, extent, allowance)? {
                let middle = (middle, self.world(middle, allowance)?);
                waiting.push((middle, end, halvings - 1));
                waiting.push((start, middle, halvings - 1));
            } else if !waiting.is_empty() {
                keys.push(end);
            }
        }
        Ok(())
    }

    /// Whether the true poses between two keys are close to the interpolated ones.
    fn is_straight(
        &self,
        start: (f32, Mat4),
        end: (f32, Mat4),
        extent: f32,
        allowance: &mut Allowance,
    ) -> Result<bool, GltfError> {
        let [from, to] = [start, end].map(|(_, world)| Affine3A::from_mat4(world));
        for share in [0.25, 0.5, 0.75] {
            let exact = self.world(start.0 + share * (end.0 - start.0), allowance)?;
            let guess = Mat4::from(affine_between(&from, &to, f64::from(share)));
            let axes = |map: Mat4| [map.x_axis, map.y_axis, map.z_axis];
            let size = axes(exact).map(|axis| axis.length()).into_iter().fold(0.0, f32::max);
            let mut pairs = axes(exact).into_iter().zip(axes(guess));
            let far = exact.w_axis.abs().max_element();
            if !pairs.all(|(exact, guess)| exact.distance(guess) <= TOLERANCE * size)
                || exact.w_axis.distance(guess.w_axis) > TOLERANCE * extent + ROUNDING * far
            {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// Whether all poses at keys are valid: none is singular or infinite.
pub(super) fn is_sound(placement: &Placement) -> bool {
    let mut worlds = placement.keys.iter().map(|(_, world)| Affine3A::from_mat4(*world));
    worlds.all(|world| is_invertible(&world))
}
