//! The poses of the nodes of the scene (glTF 2.0, section 3.5.3), and meshes placed by them, without materials, lights
//! and cameras: enough for a thumbnail.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use glam::{Affine3A, Mat4, Quat, Vec3};

use super::allowances::{MOST_INSTANCES, MeshAllowance, RepeatAllowance};
use super::animation::{Animations, rotation};
use super::schema::{Node, NodeExtensions};
use super::{Gltf, GltfError};
use crate::geometry::mesh::MeshData;
use crate::math::is_invertible;

/// The nodes of the scene.
#[derive(Default)]
pub(super) struct PlacedNodes {
    /// The nodes; parents come first.
    pub nodes: Vec<PlacedNode>,
    /// One sentence for each node without a valid pose.
    pub warnings: Vec<String>,
}

/// A node of the scene.
pub(super) struct PlacedNode {
    /// The node's index in the file.
    pub index: usize,
    /// The world transform at 0 s, which is finite.
    pub world: Mat4,
    /// The index of the parent in the list.
    pub parent: Option<usize>,
    /// Whether the node or one above it is animated.
    pub moves: bool,
}

impl Gltf {
    pub(super) fn placed_nodes(&self, animations: &Animations) -> Result<PlacedNodes, GltfError> {
        let nodes = &self.root.nodes;
        let roots = match (self.root.scene, self.root.scenes.first()) {
            (None, None) => {
                let children: HashSet<usize> = nodes.iter().flat_map(|node| node.children.iter().copied()).collect();
                (0..nodes.len()).filter(|index| !children.contains(index)).collect()
            }
            (Some(scene), _) => self.get("scene", &self.root.scenes, scene)?.nodes.clone(),
            (None, Some(first)) => first.nodes.clone(),
        };
        let mut waiting: Vec<(usize, Option<usize>)> = roots.into_iter().rev().map(|root| (root, None)).collect();
        let mut placed = PlacedNodes::default();
        let mut seen = vec![false; nodes.len()];
        while let Some((index, parent)) = waiting.pop() {
            let node = self.get("node", nodes, index)?;
            if std::mem::replace(&mut seen[index], true) {
                return Err(GltfError::Tree(index));
            }
            // Hidden with all nodes below.
            if !node.extensions.visibility.visible {
                continue;
            }
            let above = parent.map(|place: usize| &placed.nodes[place]);
            let curves = animations.nodes.get(&index);
            let local = curves.map_or_else(|| node.local(), |curves| curves.local(node, 0.0));
            let world = above.map_or(Mat4::IDENTITY, |above| above.world) * local;
            let moves = curves.is_some() || above.is_some_and(|above| above.moves);
            if !world.is_finite() {
                placed.warnings.push(format!(
                    "{} has a transform that is not finite: it is left out with what hangs on it",
                    self.node_title(index)
                ));
                continue;
            }
            let place = placed.nodes.len();
            placed.nodes.push(PlacedNode {
                index,
                world,
                parent,
                moves,
            });
            waiting.extend(node.children.iter().rev().map(|&child| (child, Some(place))));
        }
        Ok(placed)
    }
}

impl NodeExtensions {
    /// Whether the node has a light.
    pub(super) fn has_light(&self) -> bool {
        self.light.is_some() || self.profile.is_some()
    }
}

impl Node {
    /// Whether the node has a thing of the scene.
    pub(super) fn places_something(&self) -> bool {
        self.mesh.is_some() || self.camera.is_some() || self.extensions.has_light()
    }

    /// The transform parent from local, at rest.
    pub(super) fn local(&self) -> Mat4 {
        match self.matrix {
            Some(matrix) => Mat4::from_cols_array(&matrix),
            None => Mat4::from_scale_rotation_translation(
                self.scale.map_or(Vec3::ONE, Vec3::from),
                self.rotation.map_or(Quat::IDENTITY, rotation),
                self.translation.map_or(Vec3::ZERO, Vec3::from),
            ),
        }
    }
}

impl Gltf {
    /// The meshes of the default scene with their poses at 0 s, world from local. Unreadable primitives, points and
    /// lines, and flattened nodes are left out, as in [`Self::scene`]. Instances share their mesh, and are left out
    /// above the limit.
    pub fn placed_meshes(&self) -> Result<Vec<(Arc<MeshData>, Affine3A)>, GltfError> {
        let first = self.first_primitives();
        let mut allowance = MeshAllowance::of(self);
        let mut known: BTreeMap<(u32, Option<usize>), Option<Arc<MeshData>>> = BTreeMap::new();
        let mut placed = Vec::new();
        let mut instances_left = MOST_INSTANCES;
        let mut repeats = RepeatAllowance::default();
        let animations = self.animations();
        let nodes = self.placed_nodes(&animations)?;
        let skins = self.skins(&nodes);
        for place in nodes.nodes {
            let node = self.get("node", &self.root.nodes, place.index)?;
            let shape = self.pose(place.index, node, &skins, &animations);
            let pose = Affine3A::from_mat4(skins.place(node).unwrap_or(place.world));
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
                    let weights = shape.weights.as_deref().unwrap_or(&about.weights);
                    let weights = self.allowed_weights(primitive, weights, &mut allowance);
                    let read = self.read_primitive(number, primitive, weights, shape.bones.as_deref());
                    let mesh = read.ok()?.mesh;
                    allowance.spend(&mesh);
                    Some(Arc::new(mesh))
                };
                let own = shape.is_own().then_some(place.index);
                let mesh = known.entry((number, own)).or_insert_with(read);
                if let Some(mesh) = mesh {
                    let poses = &poses[..repeats.spend(number, poses.len())];
                    placed.extend(poses.iter().map(|pose| (mesh.clone(), *pose)));
                }
            }
        }
        Ok(placed)
    }
}
