//! The meshes of the scene where its nodes place them, without materials, lights and cameras: enough for a small picture.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Affine3A;

use super::{Gltf, GltfError};
use crate::geometry::mesh::MeshData;
use crate::math::is_invertible;

impl Gltf {
    /// The meshes of the default scene with their poses at 0 s, world from local. Primitives that cannot be read, points and lines, and flattened nodes are left
    /// out, as in [`Self::scene`]. Meshes that are placed several times are shared.
    pub fn placed_meshes(&self) -> Result<Vec<(Arc<MeshData>, Affine3A)>, GltfError> {
        let first = self.first_primitives();
        let mut known: BTreeMap<u32, Option<Arc<MeshData>>> = BTreeMap::new();
        let mut placed = Vec::new();
        for place in self.placed_nodes(&self.animations())?.nodes {
            let node = self.get("node", &self.root.nodes, place.index)?;
            let pose = Affine3A::from_mat4(place.world);
            let Some(mesh) = node.mesh.filter(|_| is_invertible(&pose)) else {
                continue;
            };
            let primitives = &self.get("mesh", &self.root.meshes, mesh)?.primitives;
            for (number, primitive) in (first[mesh]..).zip(primitives) {
                let read = || self.read_primitive(number, primitive).ok();
                let mesh = known
                    .entry(number)
                    .or_insert_with(|| read().map(|loaded| Arc::new(loaded.mesh)));
                placed.extend(mesh.clone().map(|mesh| (mesh, pose)));
            }
        }
        Ok(placed)
    }
}
