//! Instances of the mesh of a node (EXT_mesh_gpu_instancing): poses in the space of the node.

use std::collections::HashMap;

use glam::{Mat4, Quat, Vec3};

use super::allowances::MOST_INSTANCES;
use super::animation::rotation;
use super::motion::Placement;
use super::scene::Builder;
use super::schema::Node;
use super::{Gltf, GltfError};

/// The instances of a node.
pub(super) struct Instances {
    /// The transforms local from instance.
    pub poses: Vec<Mat4>,
    /// Whether no instance of the file is left out.
    pub are_all: bool,
}

impl Gltf {
    /// The number of shapes that a mesh becomes, at least 1.
    pub(super) fn pieces(&self, mesh: usize) -> usize {
        let mesh = self.root.meshes.get(mesh);
        mesh.map_or(1, |mesh| mesh.primitives.len().max(1))
    }

    /// The instances of a node, at most `left` shapes in all; None if the node has a single mesh.
    pub(super) fn instances(&self, node: &Node, left: &mut usize) -> Result<Option<Instances>, GltfError> {
        let (Some(instancing), Some(mesh)) = (&node.extensions.instancing, node.mesh) else {
            return Ok(None);
        };
        let attributes: &HashMap<String, usize> = &instancing.attributes;
        let named = |name: &str| attributes.get(name).copied();
        let accessors = [named("TRANSLATION"), named("ROTATION"), named("SCALE")];
        let counts = accessors.iter().flatten().map(|index| Ok(self.accessor(*index)?.count));
        let counts: Vec<usize> = counts.collect::<Result<_, GltfError>>()?;
        let count = counts.first().copied().unwrap_or(0);
        if counts.iter().any(|other| *other != count) || count > MOST_INSTANCES {
            let index = accessors.into_iter().flatten().next().unwrap_or(0);
            let what = format!("has {count} instances: all attributes need as many, and at most {MOST_INSTANCES}");
            return Err(GltfError::Accessor { index, what });
        }
        let pieces = self.pieces(mesh);
        let possible = count.min(*left / pieces);
        let are_all = possible == count;
        *left = if are_all { *left - count * pieces } else { 0 };
        // Many nodes may name the same long accessors, which are not read in vain.
        if possible == 0 {
            return Ok(Some(Instances {
                poses: Vec::new(),
                are_all,
            }));
        }
        let [translations, rotations, scales] = accessors;
        let vectors = |index: Option<usize>, usual: Vec3| match index {
            Some(index) => Ok(self
                .vectors::<3>(index, "VEC3", None)?
                .into_iter()
                .map(Vec3::from)
                .collect()),
            None => Ok(vec![usual; count]),
        };
        let translations: Vec<Vec3> = vectors(translations, Vec3::ZERO)?;
        let scales: Vec<Vec3> = vectors(scales, Vec3::ONE)?;
        let rotations: Vec<Quat> = match rotations {
            Some(index) => self
                .vectors::<4>(index, "VEC4", None)?
                .into_iter()
                .map(rotation)
                .collect(),
            None => vec![Quat::IDENTITY; count],
        };
        let poses = translations.into_iter().zip(rotations).zip(scales).take(possible);
        let pose = |((by, turn), scale)| Mat4::from_scale_rotation_translation(scale, turn, by);
        Ok(Some(Instances {
            poses: poses.map(pose).collect(),
            are_all,
        }))
    }
}

impl Builder<'_> {
    /// The poses of the instances of a node, up to the limit; None if the node has a single mesh, or if they cannot be
    /// read (reported).
    pub(super) fn instances(&mut self, index: usize, node: &Node) -> Option<Vec<Mat4>> {
        match self.gltf.instances(node, &mut self.instances_left) {
            Ok(instances) => {
                let instances = instances?;
                if !instances.are_all {
                    self.warn(format!(
                        "the file has more than {MOST_INSTANCES} instances of primitives: the last ones are left out"
                    ));
                }
                Some(instances.poses)
            }
            Err(error) => {
                let title = self.gltf.node_title(index);
                self.warn(format!("the instances of {title} are left out: {error}"));
                None
            }
        }
    }
}

impl Placement {
    /// The placement of an object with the pose `local` in this placement.
    pub(super) fn of_inner(&self, local: Mat4) -> Self {
        Self {
            world: self.world * local,
            keys: self.keys.iter().map(|(time, world)| (*time, *world * local)).collect(),
            interpolation: self.interpolation,
        }
    }
}
