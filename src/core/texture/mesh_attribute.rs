//! A value stored with the mesh itself, per vertex or per face.

use std::sync::Arc;

use super::{MeshPoint, TextureId};
use crate::color::Rgb;

/// The attribute of that name of whatever mesh it is looked up on; black on surfaces without it.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshAttribute {
    /// The name with its prefix: `vertex_color`, `face_material_id`.
    pub name: Arc<str>,
    /// Multiplies the value.
    pub scale: f32,
    /// A texture before this one in the table that multiplies it as well.
    pub times: Option<TextureId>,
}

impl MeshAttribute {
    /// The value without the texture that multiplies it.
    pub(super) fn color(&self, at: Option<MeshPoint>) -> Rgb {
        at.and_then(|at| {
            Some(
                at.mesh
                    .attribute(&self.name)?
                    .value(&at.mesh.triangles, at.triangle, at.barycentric),
            )
        })
        .map_or(Rgb::ZERO, |value| self.scale * value)
    }

    /// A guess, since meshes differ: half of what the scale makes of 1, without the texture that multiplies it.
    pub(super) fn mean(&self) -> f32 {
        0.5 * self.scale
    }
}
