//! Where skinned meshes stand. Their node does not place them (glTF 2.0, section 3.7.3.3), but their bones do: at rest each vertex is where the rest pose
//! of its bones takes it from the pose in which it was bound to them.

use glam::Mat4;

use super::Gltf;
use super::nodes::PlacedNodes;
use super::scene::Builder;
use super::schema::{Node, Skin};

/// The most things that a warning names.
const MOST_NAMES: usize = 5;

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

    /// Where the mesh of a node stands by its bones; None if it has no skin. At rest all bones of most meshes say the same. Where they do not, the first
    /// one counts, which is most often the root of the others.
    pub(super) fn pose_of_skin(&self, node: &Node, rest: &RestPoses) -> Option<Mat4> {
        // A skin that is not there holds nothing.
        let skin = self.root.skins.get(node.skin?);
        let pose = skin.and_then(|skin| self.pose_of_root(skin, rest));
        Some(pose.filter(Mat4::is_finite).unwrap_or(Mat4::IDENTITY))
    }

    /// The map from the mesh to the world by the first bone.
    fn pose_of_root(&self, skin: &Skin, rest: &RestPoses) -> Option<Mat4> {
        let bone = rest.0.get(*skin.joints.first()?).copied().flatten()?;
        let bound = skin.inverse_bind_matrices;
        let bound = bound.and_then(|accessor| self.vectors::<16>(accessor, "MAT4", Some(&[0])).ok());
        let from_mesh = bound.map_or(Mat4::IDENTITY, |bound| Mat4::from_cols_array(&bound[0]));
        Some(bone * from_mesh)
    }
}

impl Builder<'_> {
    /// Says which meshes of the scene would change their shape.
    pub(super) fn warn_of_deformation(&mut self, placed: &PlacedNodes) {
        let gltf = self.gltf;
        let list = |is_one: &dyn Fn(&Node) -> bool| {
            let nodes = placed.nodes.iter().filter_map(|place| gltf.root.nodes.get(place.index));
            let name = |node: &Node| {
                let mesh = node.mesh.and_then(|mesh| gltf.root.meshes.get(mesh));
                let name = node.name.clone().or_else(|| mesh?.name.clone());
                format!("`{}`", name.as_deref().unwrap_or("mesh"))
            };
            let names: Vec<String> = nodes.filter(|node| is_one(node)).map(name).collect();
            let others = names.len().saturating_sub(MOST_NAMES);
            match others {
                0 => (names.len(), names.join(", ")),
                _ => (
                    names.len(),
                    format!("{} and {others} more", names[..MOST_NAMES].join(", ")),
                ),
            }
        };
        match list(&|node| node.mesh.is_some() && node.skin.is_some()) {
            (0, _) => {}
            (1, name) => self.warn(format!("skins are not read: {name} stays in its pose at rest")),
            (_, names) => self.warn(format!("skins are not read: {names} stay in their pose at rest")),
        }
    }
}
