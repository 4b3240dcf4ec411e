//! The poses of the nodes of the scene (glTF 2.0, section 3.5.3).

use std::collections::HashSet;

use glam::{Mat4, Quat, Vec3, Vec4};

use super::schema::Node;
use super::{Gltf, GltfError};

/// The nodes of the scene.
#[derive(Default)]
pub(super) struct PlacedNodes {
    /// The indices with world transforms, which are finite; parents come first.
    pub nodes: Vec<(usize, Mat4)>,
    /// One sentence for each node without a pose.
    pub warnings: Vec<String>,
}

impl Gltf {
    pub(super) fn placed_nodes(&self) -> Result<PlacedNodes, GltfError> {
        let nodes = &self.root.nodes;
        let roots = match (self.root.scene, self.root.scenes.first()) {
            (None, None) => {
                let children: HashSet<usize> = nodes.iter().flat_map(|node| node.children.iter().copied()).collect();
                (0..nodes.len()).filter(|index| !children.contains(index)).collect()
            }
            (Some(scene), _) => self.get("scene", &self.root.scenes, scene)?.nodes.clone(),
            (None, Some(first)) => first.nodes.clone(),
        };
        let mut waiting: Vec<(usize, Mat4)> = roots.into_iter().rev().map(|root| (root, Mat4::IDENTITY)).collect();
        let mut placed = PlacedNodes::default();
        let mut seen = vec![false; nodes.len()];
        while let Some((index, parent)) = waiting.pop() {
            let node = self.get("node", nodes, index)?;
            if std::mem::replace(&mut seen[index], true) {
                return Err(GltfError::Tree(index));
            }
            let world = parent * node.local();
            if !world.is_finite() {
                let name = node.name.as_deref().unwrap_or("unnamed");
                placed.warnings.push(format!(
                    "node {index} ({name}) has a transform that is not finite: it is left out with what hangs on it"
                ));
                continue;
            }
            placed.nodes.push((index, world));
            waiting.extend(node.children.iter().rev().map(|&child| (child, world)));
        }
        Ok(placed)
    }
}

impl Node {
    fn local(&self) -> Mat4 {
        // A quaternion without a direction turns nothing.
        let rotation = |turn| Vec4::from_array(turn).try_normalize().map(Quat::from_vec4);
        match self.matrix {
            Some(matrix) => Mat4::from_cols_array(&matrix),
            None => Mat4::from_scale_rotation_translation(
                self.scale.map_or(Vec3::ONE, Vec3::from),
                self.rotation.and_then(rotation).unwrap_or(Quat::IDENTITY),
                self.translation.map_or(Vec3::ZERO, Vec3::from),
            ),
        }
    }
}
