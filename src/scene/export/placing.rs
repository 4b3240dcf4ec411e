//! How the vertices and triangles of a form are written: the map applied to them, the side of their normals, and their
//! winding.

use bevy::math::Affine3A;

use super::form::Form;
use super::poses::pose_of;
use crate::gltf::write::model::Pose;

/// How the vertices of a form are written.
#[derive(Clone, Copy)]
pub(super) struct Placing {
    /// A map that is applied to them.
    pub baked: Option<Affine3A>,
    /// Whether normals are flipped.
    pub is_turned: bool,
    /// Whether the pose of the node mirrors them.
    pub is_mirrored: bool,
}

impl Placing {
    /// Whether the winding of triangles is reversed, also because the map mirrors them.
    pub fn runs_backwards(&self) -> bool {
        self.is_turned ^ self.baked.is_some_and(|map| is_mirrored(&map))
    }
}

/// The triangles of a form that are written as one primitive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    All,
    /// The triangles on which pictures are not mirrored.
    Upright,
    /// The triangles on which pictures are mirrored.
    Mirrored,
}

impl Side {
    pub fn is_mirrored(self) -> bool {
        self == Self::Mirrored
    }

    pub fn turned(self) -> Self {
        match self {
            Self::All => Self::All,
            Self::Upright => Self::Mirrored,
            Self::Mirrored => Self::Upright,
        }
    }
}

/// A key for the vertices of a form.
pub(super) fn key_of(form: &Form, placing: &Placing, is_unwelded: bool) -> String {
    let Placing { baked, is_turned, .. } = placing;
    format!("{} {} {is_turned} {is_unwelded} {baked:?}", form.key, form.is_flat)
}

pub(super) fn is_mirrored(map: &Affine3A) -> bool {
    map.matrix3.determinant() < 0.0
}

/// The pose of a node; if it shears, the identity, and the map to apply to its vertices instead.
pub(super) fn pose_or_baked(local: &Affine3A) -> (Pose, Option<Affine3A>) {
    match pose_of(local) {
        Some(pose) => (pose, None),
        None => (Pose::default(), Some(*local)),
    }
}
