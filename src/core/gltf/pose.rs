//! The shape that a mesh has at a node: its morph weights, and the transforms of its bones.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use glam::{Mat3, Mat4, Vec3};

use super::schema::Node;

/// The shape of a mesh.
#[derive(Clone, Default)]
pub(super) struct Pose {
    /// The weights of its morph targets; None for those of the mesh.
    pub weights: Option<Rc<[f32]>>,
    /// The transforms world from mesh by the bones, if they deform it. None for bones outside of the scene.
    pub bones: Option<Rc<[Option<Mat4>]>>,
}

impl Pose {
    /// Whether the mesh has this shape at one node only.
    pub fn is_own(&self) -> bool {
        self.weights.is_some() || self.bones.is_some()
    }
}

/// The skins of a file, at 0 s.
#[derive(Default)]
pub(super) struct Skins {
    /// The transforms world from mesh by the bones of each skin that deforms meshes.
    pub deforming: BTreeMap<usize, Rc<[Option<Mat4>]>>,
    /// The transform of each other skin.
    pub placing: BTreeMap<usize, Mat4>,
    /// The skins whose bones move.
    pub moving: BTreeSet<usize>,
    /// Warnings of skins whose inverse bind matrices cannot be read.
    pub unbound: Vec<String>,
}

impl Skins {
    /// The pose of a node's mesh by its bones, if the node has a skin. A mesh that its bones deform is in world space.
    pub fn place(&self, node: &Node) -> Option<Mat4> {
        let placed = self.placing.get(&node.skin?).copied();
        Some(placed.filter(Mat4::is_finite).unwrap_or(Mat4::IDENTITY))
    }
}

/// Moves values of vertices by their bones, if there are some: positions, or (`are_normals`) normals.
pub(super) fn skinned(values: &mut [Vec3], bones: Option<&[Mat4]>, are_normals: bool) {
    for (value, bone) in values.iter_mut().zip(bones.into_iter().flatten()) {
        *value = match are_normals {
            false => bone.transform_point3(*value),
            true => {
                let map = Mat3::from_mat4(*bone);
                // The matrix of cofactors: the transposed inverse times the determinant, which may be zero. Normals
                // stay outside where it is negative.
                let cofactors = Mat3::from_cols(
                    map.y_axis.cross(map.z_axis),
                    map.z_axis.cross(map.x_axis),
                    map.x_axis.cross(map.y_axis),
                );
                (orientation(bone) * (cofactors * *value)).normalize_or_zero()
            }
        };
    }
}

/// -1 for a transform that mirrors, and 1 for others.
pub(super) fn orientation(transform: &Mat4) -> f32 {
    match transform.determinant() < 0.0 {
        true => -1.0,
        false => 1.0,
    }
}

/// Turns the triangles of which bones mirror most corners, so that their sides stay outside.
pub(super) fn turn_mirrored(triangles: &mut [[u32; 3]], bones: &[Mat4]) {
    for triangle in triangles {
        let corners = triangle.map(|vertex| bones.get(vertex as usize).map_or(1.0, orientation));
        if corners.iter().sum::<f32>() < 0.0 {
            triangle.swap(0, 1);
        }
    }
}
