//! The placement of skinned meshes. Their node does not place them (glTF 2.0, section 3.7.3.3), but their bones do: at
//! rest each vertex moves from the bind pose of its bones to their rest pose.

use glam::Mat4;

use super::Gltf;
use super::limits::first_names;
use super::nodes::PlacedNodes;
use super::scene::Builder;
use super::schema::{Node, Skin};

/// The largest difference of two bone poses that count as equal, relative to the largest number of one.
const SAME_POSE: f32 = 1e-3;

/// The poses of the nodes of the scene at rest, world from local.
pub(super) struct RestPoses(Vec<Option<Mat4>>);

impl Gltf {
    pub(super) fn rest_poses(&self, placed: &PlacedNodes) -> RestPoses {
        let mut poses = vec![None; self.root.nodes.len()];
        if self.root.skins.is_empty() {
            return RestPoses(poses);
        }
        // Parents come first.
        for node in &placed.nodes {
            let above = node.parent.and_then(|parent| poses[placed.nodes[parent].index]);
            let local = self.root.nodes.get(node.index).map_or(Mat4::IDENTITY, Node::local);
            poses[node.index] = Some(above.unwrap_or(Mat4::IDENTITY) * local);
        }
        RestPoses(poses)
    }

    /// The pose of a node's mesh by its bones; None if it has no skin. At rest all bones of most meshes agree.
    /// Otherwise the first one counts, which is usually the root of the others.
    pub(super) fn pose_of_skin(&self, node: &Node, rest: &RestPoses) -> Option<Mat4> {
        // A missing skin has no bones.
        let skin = self.root.skins.get(node.skin?);
        let pose = skin.and_then(|skin| self.pose_of_root(skin, rest));
        Some(pose.filter(Mat4::is_finite).unwrap_or(Mat4::IDENTITY))
    }

    /// The transform from the mesh to the world by the first bone.
    fn pose_of_root(&self, skin: &Skin, rest: &RestPoses) -> Option<Mat4> {
        self.poses_of_bones(skin, rest, 1).first().copied()?
    }

    /// The transforms from the mesh to the world by the first `count` bones. None for bones outside the scene.
    fn poses_of_bones(&self, skin: &Skin, rest: &RestPoses, count: usize) -> Vec<Option<Mat4>> {
        let joints = &skin.joints[..count.min(skin.joints.len())];
        let used: Vec<u32> = (0..).take(joints.len()).collect();
        let bound = skin.inverse_bind_matrices;
        let bound = bound.and_then(|accessor| self.vectors::<16>(accessor, "MAT4", Some(&used)).ok());
        let pose = |(number, &joint): (usize, &usize)| {
            let bone = rest.0.get(joint).copied().flatten()?;
            let from_mesh = bound.as_ref().map(|bound| Mat4::from_cols_array(&bound[number]));
            Some(bone * from_mesh.unwrap_or(Mat4::IDENTITY))
        };
        joints.iter().enumerate().map(pose).collect()
    }

    /// Whether the bones of a skin deform a mesh: they may be animated, or they disagree at rest.
    fn deforms(&self, skin: &Skin, rest: &RestPoses) -> bool {
        let poses = self.poses_of_bones(skin, rest, usize::MAX);
        let is_same = |one: Mat4, other: Mat4| {
            let size = one
                .to_cols_array()
                .into_iter()
                .fold(1.0, |size: f32, number| size.max(number.abs()));
            one.abs_diff_eq(other, SAME_POSE * size)
        };
        let mut poses = poses.into_iter().flatten();
        let first = poses.next();
        !self.root.animations.is_empty() || first.is_some_and(|first| !poses.all(|pose| is_same(first, pose)))
    }
}

impl Builder<'_> {
    /// Warns of meshes that would be deformed.
    pub(super) fn warn_of_deformation(&mut self, placed: &PlacedNodes, rest: &RestPoses) {
        let gltf = self.gltf;
        let skins = gltf.root.skins.iter();
        let deforming: Vec<bool> = skins.map(|skin| gltf.deforms(skin, rest)).collect();
        let nodes = placed.nodes.iter().filter_map(|place| gltf.root.nodes.get(place.index));
        let is_deformed = |node: &&Node| {
            let skin = node.skin.filter(|_| node.mesh.is_some());
            skin.is_some_and(|skin| deforming.get(skin).copied().unwrap_or(true))
        };
        let deformed: Vec<&Node> = nodes.filter(is_deformed).collect();
        let name = |node: &&Node| {
            let mesh = node.mesh.and_then(|mesh| gltf.root.meshes.get(mesh));
            let name = node.name.clone().or_else(|| mesh?.name.clone());
            format!("`{}`", name.as_deref().unwrap_or("mesh"))
        };
        let names = first_names(&deformed, name);
        match deformed.len() {
            0 => {}
            1 => self.warn(format!(
                "{names} stands where its bones hold it at rest, and is not deformed by them"
            )),
            _ => self.warn(format!(
                "{names} stand where their bones hold them at rest, and are not deformed by them"
            )),
        }
    }
}
