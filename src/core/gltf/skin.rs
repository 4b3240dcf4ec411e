//! The bones and the morph weights of meshes (glTF 2.0, sections 3.7.2.2 and
//! 3.7.3). Both are those at 0 s of the animations.
//!
//! The node of a skinned mesh does not place it, but its bones do. Where all of them agree, they place the mesh as a
//! node would; where they do not, each vertex goes along with its own bones, and the mesh that results is in world
//! space.

use std::collections::BTreeSet;
use std::rc::Rc;

use glam::{Mat4, Vec3};

use super::allowances::MOST_MOVES;
use super::animation::Animations;
use super::limits::first_names;
use super::mesh::{into_vectors, weighted};
use super::nodes::{PlacedNode, PlacedNodes};
use super::pose::{Pose, Skins};
use super::scene::Builder;
use super::schema::{Node, Primitive, Skin};
use super::{Gltf, GltfError};
use crate::memory::{self, Reservation};

/// The largest difference of two bone poses that count as equal, relative to the largest number of one.
const SAME_POSE: f32 = 1e-3;

/// Bytes for each vertex of a mesh that bones deform: a sum of weighted transforms (80), the joints and the weights
/// (32), and the transform (64).
const BONE_BYTES: u64 = 176;

/// The most transforms of bones of all skins together.
const MOST_BONES: usize = 1 << 22;

impl Gltf {
    /// The skins of the nodes of the scene.
    pub(super) fn skins(&self, placed: &PlacedNodes) -> Skins {
        let mut skins = Skins::default();
        let mut poses: Vec<Option<&PlacedNode>> = vec![None; self.root.nodes.len()];
        for node in &placed.nodes {
            poses[node.index] = Some(node);
        }
        let nodes = placed.nodes.iter().filter_map(|place| self.root.nodes.get(place.index));
        let used: BTreeSet<usize> = nodes.filter_map(|node| node.skin).collect();
        let mut left = MOST_BONES;
        for index in used {
            let Some(skin) = self.root.skins.get(index) else {
                continue;
            };
            left = left.saturating_sub(skin.joints.len());
            let bones: Vec<Option<Mat4>> = match left {
                0 => Vec::new(),
                _ => {
                    let bound = self.bound(skin).unwrap_or_else(|error| {
                        skins.unbound.push(format!(
                            "the inverse bind matrices of skin {index} are left out: {error}"
                        ));
                        None
                    });
                    bones(skin, bound.as_deref(), &poses)
                }
            };
            let mut known = bones.iter().flatten();
            let first = known.next();
            match first {
                Some(first) if known.all(|pose| is_same(*first, *pose)) => {
                    skins.placing.insert(index, *first);
                }
                Some(_) => {
                    skins.deforming.insert(index, bones.into());
                }
                None => {}
            }
            let moves = |joint: &usize| poses.get(*joint).copied().flatten().is_some_and(|node| node.moves);
            if skin.joints.iter().any(moves) {
                skins.moving.insert(index);
            }
        }
        skins
    }

    /// The inverse bind matrices of a skin, if it has some.
    fn bound(&self, skin: &Skin) -> Result<Option<Vec<[f32; 16]>>, GltfError> {
        let used: Vec<u32> = (0..).take(skin.joints.len()).collect();
        let bound = skin.inverse_bind_matrices;
        bound
            .map(|accessor| self.vectors(accessor, "MAT4", Some(&used)))
            .transpose()
    }

    /// The shape of the mesh of a node.
    pub(super) fn pose(&self, index: usize, node: &Node, skins: &Skins, animations: &Animations) -> Pose {
        let animated = animations.weights.get(&index).cloned();
        Pose {
            weights: animated.or_else(|| node.weights.clone().map(Rc::from)),
            bones: node.skin.and_then(|skin| skins.deforming.get(&skin).cloned()),
        }
    }

    /// The transform of each used vertex of a primitive by the bones, world from mesh, and the memory for it.
    pub(super) fn vertex_bones(
        &self,
        primitive: &Primitive,
        bones: &[Option<Mat4>],
        (vertices, used): (usize, Option<&[u32]>),
    ) -> Result<(Vec<Mat4>, Reservation), GltfError> {
        let count = used.map_or(vertices, <[u32]>::len);
        let memory = memory::reserve(BONE_BYTES.saturating_mul(count as u64)).map_err(GltfError::Memory)?;
        let mut sums = vec![(Mat4::ZERO, 0.0); count];
        for set in 0.. {
            let accessor = |name: &str| primitive.attributes.get(&format!("{name}_{set}")).copied();
            let (Some(joints), Some(weights)) = (accessor("JOINTS"), accessor("WEIGHTS")) else {
                break;
            };
            for index in [joints, weights] {
                if self.accessor(index)?.count != vertices {
                    let what = format!("has another number of bones than the {vertices} vertices");
                    return Err(GltfError::Accessor { index, what });
                }
            }
            let joints = self.vectors::<4>(joints, "VEC4", used)?;
            let weights = self.vectors::<4>(weights, "VEC4", used)?;
            for ((sum, total), (joints, weights)) in sums.iter_mut().zip(joints.iter().zip(&weights)) {
                for (joint, weight) in joints.iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
                    if let Some(bone) = bones.get(*joint as usize).copied().flatten() {
                        *sum += *weight * bone;
                        *total += *weight;
                    }
                }
            }
        }
        // A vertex without bones goes along with the first one.
        let first = bones.iter().flatten().next().copied().unwrap_or(Mat4::IDENTITY);
        let mean = |(sum, total): (Mat4, f32)| if total > 0.0 { sum * total.recip() } else { first };
        Ok((sums.into_iter().map(mean).collect(), memory))
    }
}

/// The transforms from the mesh to the world by the bones, with the inverse bind matrices. None for bones outside of
/// the scene.
fn bones(skin: &Skin, bound: Option<&[[f32; 16]]>, poses: &[Option<&PlacedNode>]) -> Vec<Option<Mat4>> {
    let pose = |(number, joint): (usize, &usize)| {
        let bone = poses.get(*joint).copied().flatten()?.world;
        let from_mesh = bound.and_then(|bound| bound.get(number));
        Some(bone * from_mesh.map_or(Mat4::IDENTITY, Mat4::from_cols_array))
    };
    skin.joints.iter().enumerate().map(pose).collect()
}

fn is_same(one: Mat4, other: Mat4) -> bool {
    let numbers = one.to_cols_array().into_iter();
    let size = numbers.fold(1.0, |size: f32, number| size.max(number.abs()));
    one.abs_diff_eq(other, SAME_POSE * size)
}

impl Gltf {
    /// Adds the morph targets to the values of the `used` ones of a mesh's `vertices`.
    pub(super) fn morph(
        &self,
        name: &str,
        primitive: &Primitive,
        weights: &[f32],
        (vertices, used): (usize, Option<&[u32]>),
        values: &mut [Vec3],
    ) -> Result<(), GltfError> {
        if values.is_empty() || self.moves > MOST_MOVES {
            return Ok(());
        }
        for (target, weight) in weighted(primitive, weights) {
            let Some(&accessor) = target.get(name) else {
                continue;
            };
            if self.accessor(accessor)?.count == vertices {
                let moved: Vec<Vec3> = into_vectors(self.vectors::<3>(accessor, "VEC3", used)?);
                for (value, by) in values.iter_mut().zip(moved) {
                    *value += weight * by;
                }
            }
        }
        Ok(())
    }
}

impl Builder<'_> {
    /// Warns of meshes whose bones move, and of skins that cannot be read or are not there.
    pub(super) fn warn_of_bones(&mut self, placed: &PlacedNodes, skins: &Skins) {
        let gltf = self.gltf;
        skins.unbound.iter().for_each(|sentence| self.warn(sentence.clone()));
        let nodes = placed.nodes.iter().filter_map(|place| gltf.root.nodes.get(place.index));
        let is_moved = |node: &&Node| {
            let skin = node.skin.filter(|_| node.mesh.is_some());
            skin.is_some_and(|skin| skins.moving.contains(&skin))
        };
        let moved: Vec<&Node> = nodes.clone().filter(is_moved).collect();
        let count = gltf.root.skins.len();
        let lost: Vec<&Node> = nodes
            .filter(|node| node.skin.is_some_and(|skin| skin >= count))
            .collect();
        let name = |node: &&Node| {
            let mesh = node.mesh.and_then(|mesh| gltf.root.meshes.get(mesh));
            let name = node.name.clone().or_else(|| mesh?.name.clone());
            format!("`{}`", name.as_deref().unwrap_or("mesh"))
        };
        let names = first_names(&moved, name);
        if !lost.is_empty() {
            let names = first_names(&lost, name);
            self.warn(format!("the skin of {names} is not there"));
        }
        match moved.len() {
            0 => {}
            1 => self.warn(format!(
                "{names} has the shape that its bones give it at 0 s, and stands still"
            )),
            _ => self.warn(format!(
                "{names} have the shapes that their bones give them at 0 s, and stand still"
            )),
        }
    }
}
