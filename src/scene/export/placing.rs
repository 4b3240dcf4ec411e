//! How the vertices and the triangles of a form are written: through which map, on which side, and in which order.

use bevy::math::Affine3A;

use super::form::Form;
use super::poses::pose_of;
use crate::gltf::write::model::Pose;

/// How the vertices of a form are written.
#[derive(Clone, Copy)]
pub(super) struct Placing {
    /// A map that they go through.
    pub baked: Option<Affine3A>,
    /// Whether normals are turned around.
    pub is_turned: bool,
    /// Whether the pose of the node mirrors them.
    pub is_mirrored: bool,
}

impl Placing {
    /// Whether corners are written the other way around. What was mirrored by hand runs the other way.
    pub fn runs_backwards(&self) -> bool {
        self.is_turned ^ self.baked.is_some_and(|map| is_mirrored(&map))
    }
}

/// The triangles of a form that are written together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    All,
    /// The triangles on which pictures are seen as they are.
    Upright,
    /// The triangles on which pictures lie mirrored.
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

/// What the vertices of a form are made from.
pub(super) fn key_of(form: &Form, placing: &Placing, is_unwelded: bool) -> String {
    let Placing { baked, is_turned, .. } = placing;
    format!("{} {} {is_turned} {is_unwelded} {baked:?}", form.key, form.is_flat)
}

pub(super) fn is_mirrored(map: &Affine3A) -> bool {
    map.matrix3.determinant() < 0.0
}

/// The pose of a node; or, if it shears, none, and the map that its vertices have to go through instead.
pub(super) fn pose_or_baked(local: &Affine3A) -> (Pose, Option<Affine3A>) {
    match pose_of(local) {
        Some(pose) => (pose, None),
        None => (Pose::default(), Some(*local)),
    }
}
