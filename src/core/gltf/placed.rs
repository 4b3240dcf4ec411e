//! The meshes of the scene where its nodes place them, without materials, lights and cameras: enough for a small
//! picture.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Affine3A;

use super::allowances::{MOST_INSTANCES, MeshAllowance, RepeatAllowance};
use super::{Gltf, GltfError};
use crate::geometry::mesh::MeshData;
use crate::math::is_invertible;

impl Gltf {
    /// The meshes of the default scene with their poses at 0 s, world from local. Primitives that cannot be read,
    /// points and lines, and flattened nodes are left out, as in [`Self::scene`]. Meshes that are placed several
    /// times are shared, and those of very many places are left out in the last ones.
    pub fn placed_meshes(&self) -> Result<Vec<(Arc<MeshData>, Affine3A)>, GltfError> {
        let first = self.first_primitives();
        let mut allowance = MeshAllowance::of(self);
        let mut known: BTreeMap<u32, Option<Arc<MeshData>>> = BTreeMap::new();
        let mut placed = Vec::new();
        let mut instances_left = MOST_INSTANCES;
        let mut repeats = RepeatAllowance::default();
        let nodes = self.placed_nodes(&self.animations())?;
        let rest = self.rest_poses(&nodes);
        for place in nodes.nodes {
            let node = self.get("node", &self.root.nodes, place.index)?;
            let pose = Affine3A::from_mat4(self.pose_of_skin(node, &rest).unwrap_or(place.world));
            let Some(mesh) = node.mesh.filter(|_| is_invertible(&pose)) else {
                continue;
            };
            let about = self.get("mesh", &self.root.meshes, mesh)?;
            let instances = match node.skin {
                None => self.instances(node, &mut instances_left).ok().flatten(),
                Some(_) => None,
            };
            let poses: Vec<Affine3A> = match instances {
                Some(instances) => {
                    let poses = instances.poses.into_iter();
                    let poses = poses.map(|inner| pose * Affine3A::from_mat4(inner));
                    poses.filter(is_invertible).collect()
                }
                None => vec![pose],
            };
            for (number, primitive) in (first[mesh]..).zip(&about.primitives) {
                let read = || {
                    if allowance.is_spent() {
                        return None;
                    }
                    let mesh = self.read_primitive(number, primitive, &about.weights).ok()?.mesh;
                    allowance.spend(&mesh);
                    Some(Arc::new(mesh))
                };
                let mesh = known.entry(number).or_insert_with(read);
                if let Some(mesh) = mesh {
                    let poses = &poses[..repeats.spend(number, poses.len())];
                    placed.extend(poses.iter().map(|pose| (mesh.clone(), *pose)));
                }
            }
        }
        Ok(placed)
    }
}
