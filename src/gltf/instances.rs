//! Many places of the mesh of one node (EXT_mesh_gpu_instancing): poses in the space of the node.

use std::collections::HashMap;

use glam::{Mat4, Quat, Vec3};

use super::animation::rotation;
use super::motion::Placement;
use super::placed::MOST_INSTANCES;
use super::scene::Builder;
use super::schema::Node;
use super::{Gltf, GltfError};

impl Gltf {
    /// The poses of the instances of a node, local from instance; None if its mesh stands there once.
    pub(super) fn instance_poses(&self, node: &Node) -> Result<Option<Vec<Mat4>>, GltfError> {
        let Some(instancing) = &node.extensions.instancing else {
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
        let poses = translations.into_iter().zip(rotations).zip(scales);
        let pose = |((by, turn), scale)| Mat4::from_scale_rotation_translation(scale, turn, by);
        Ok(Some(poses.map(pose).collect()))
    }
}

impl Builder<'_> {
    /// The poses of the instances of a node, as far as there may be more of them; None if its mesh stands there once, also (reported) if they cannot be
    /// read.
    pub(super) fn instances(&mut self, index: usize, node: &Node) -> Option<Vec<Mat4>> {
        let title = self.gltf.node_title(index);
        match self.gltf.instance_poses(node) {
            Ok(poses) => {
                let mut poses = poses?;
                if poses.len() > self.instances_left {
                    self.warn(format!(
                        "the file has more than {MOST_INSTANCES} instances: the last of {title} and later ones are left out"
                    ));
                    poses.truncate(self.instances_left);
                }
                self.instances_left -= poses.len();
                Some(poses)
            }
            Err(error) => {
                self.warn(format!("the instances of {title} are left out: {error}"));
                None
            }
        }
    }
}

impl Placement {
    /// Where something stands whose pose in this place is `local`.
    pub(super) fn of_inner(&self, local: Mat4) -> Self {
        Self {
            world: self.world * local,
            keys: self.keys.iter().map(|(time, world)| (*time, *world * local)).collect(),
            interpolation: self.interpolation,
        }
    }
}
