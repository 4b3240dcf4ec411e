//! The poses of nodes in glTF, and the tree of folders.

use std::collections::HashMap;

use bevy::math::{Affine3A, DMat3, DVec3, Mat3A, Vec3};

use crate::gltf::write::GltfWriter;
use crate::gltf::write::model::{Node, Pose};
use crate::math::is_invertible;

/// The largest cosine between two axes that still count as perpendicular.
const SHEAR: f64 = 1e-4;

/// The map as scale, rotation and translation; None if it shears or is not finite.
pub(super) fn pose_of(map: &Affine3A) -> Option<Pose> {
    let axes = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis].map(|axis| axis.as_dvec3());
    let [x, y, z] = axes.map(|axis| axis.try_normalize());
    let (x, y, z) = (x?, y?, z?);
    if [x.dot(y), y.dot(z), z.dot(x)].iter().any(|cosine| cosine.abs() > SHEAR) || !map.is_finite() {
        return None;
    }
    let mirror = x.cross(y).dot(z).signum();
    let mut scale = DVec3::from_array(axes.map(DVec3::length));
    scale.x *= mirror;
    let turn = bevy::math::DQuat::from_mat3(&DMat3::from_cols(mirror * x, y, z)).normalize();
    // A rotation within rounding errors is the identity.
    let is_turned = turn.xyz().length() > 1e-8;
    Some(Pose {
        translation: Vec3::from(map.translation).to_array(),
        rotation: match is_turned {
            true => turn.as_quat().to_array(),
            false => Pose::default().rotation,
        },
        scale: scale.as_vec3().to_array(),
    })
}

/// The map of a pose.
pub(super) fn map_of(pose: &Pose) -> Affine3A {
    Affine3A::from_scale_rotation_translation(
        pose.scale.into(),
        bevy::math::Quat::from_array(pose.rotation),
        pose.translation.into(),
    )
}

/// The pose of a camera or a light without scale: forward stays, up is made perpendicular to it, and a mirrored pose
/// stays mirrored.
pub(super) fn rigid(pose: &Affine3A) -> Option<Affine3A> {
    let [left, up, forward] = [pose.matrix3.x_axis, pose.matrix3.y_axis, pose.matrix3.z_axis];
    let forward = forward.try_normalize()?;
    let up = up.try_normalize()?;
    let up = (up - up.dot(forward) * forward).try_normalize()?;
    let side = up.cross(forward);
    let mirror = if side.dot(left) < 0.0 { -1.0 } else { 1.0 };
    let matrix3 = Mat3A::from_cols(mirror * side, up, forward);
    let rigid = Affine3A {
        matrix3,
        translation: pose.translation,
    };
    rigid.is_finite().then_some(rigid)
}

/// The position of a thing in the tree of nodes.
pub(super) struct Branch {
    /// The parent node.
    pub parent: Option<usize>,
    /// The transform from the space of the parent to the world.
    pub world_from_parent: Affine3A,
    /// The part of the name after the folders.
    pub leaf: String,
}

/// The nodes of folders.
#[derive(Default)]
pub(super) struct Folders {
    /// The transforms of folders that have one.
    frames: HashMap<String, Affine3A>,
    /// The nodes, with the transforms from their spaces to the world.
    nodes: HashMap<String, (usize, Affine3A)>,
    /// The extras of folders that have properties.
    extras: HashMap<String, serde_json::Value>,
}

impl Folders {
    /// `frames`: the names of folders with their transforms. `extras`: their properties.
    pub fn new(frames: impl Iterator<Item = (String, Affine3A)>, extras: HashMap<String, serde_json::Value>) -> Self {
        Self {
            frames: frames.filter(|(_, map)| is_invertible(map)).collect(),
            nodes: HashMap::new(),
            extras,
        }
    }

    /// The position of a thing with this name in the tree. Nodes of folders are made as needed.
    pub fn branch(&mut self, name: &str, writer: &mut GltfWriter) -> Branch {
        let Some((folder, leaf)) = name.trim_end_matches('/').rsplit_once('/') else {
            return Branch {
                parent: None,
                world_from_parent: Affine3A::IDENTITY,
                leaf: name.to_owned(),
            };
        };
        let (node, world_from_parent) = self.node(folder, writer);
        Branch {
            parent: Some(node),
            world_from_parent,
            leaf: leaf.to_owned(),
        }
    }

    fn node(&mut self, folder: &str, writer: &mut GltfWriter) -> (usize, Affine3A) {
        if let Some(known) = self.nodes.get(folder) {
            return *known;
        }
        let above = self.branch(folder, writer);
        let frame = self.frames.get(folder).copied().unwrap_or(above.world_from_parent);
        // A frame that shears its content is ignored: the content keeps its pose in the world.
        let pose = pose_of(&(above.world_from_parent.inverse() * frame)).unwrap_or_default();
        let node = Node {
            name: above.leaf,
            pose,
            extras: self.extras.get(folder).cloned(),
            ..Node::default()
        };
        let made = (
            writer.add_node(node, above.parent),
            above.world_from_parent * map_of(&pose),
        );
        self.nodes.insert(folder.to_owned(), made);
        made
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::Quat;

    #[test]
    fn poses_are_the_maps_that_they_were_made_of() {
        let turn = Quat::from_euler(bevy::math::EulerRot::XYZ, 0.4, -1.2, 2.5);
        for scale in [
            Vec3::ONE,
            Vec3::new(2.0, 0.5, 3.0),
            Vec3::new(-1.0, 2.0, 1.0),
            -Vec3::ONE,
        ] {
            let map = Affine3A::from_scale_rotation_translation(scale, turn, Vec3::new(1.0, -2.0, 3.0));
            let again = map_of(&pose_of(&map).expect("it does not shear"));
            // Four products with rounding 2^-24.
            assert!(map.abs_diff_eq(again, 1e-5), "{scale}: {map:?} {again:?}");
        }
        let sheared = Affine3A::from_scale(Vec3::new(1.0, 2.0, 1.0)) * Affine3A::from_rotation_z(0.5);
        assert_eq!(pose_of(&sheared), None);
        assert_eq!(pose_of(&Affine3A::IDENTITY), Some(Pose::default()));
    }
}
