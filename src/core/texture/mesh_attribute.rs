//! A value stored with the mesh itself, per vertex or per face.

use std::sync::Arc;

use super::{MeshPoint, TextureId};
use crate::color::Rgb;

/// The attribute with a name, of the mesh at the lookup; black on surfaces without it.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshAttribute {
    /// The name with its prefix: `vertex_color`, `face_material_id`.
    pub name: Arc<str>,
    /// The factor on the value.
    pub scale: f32,
    /// A texture before this one in the table, which multiplies the value.
    pub times: Option<TextureId>,
}

impl MeshAttribute {
    /// The value before the multiplication by the texture `times`.
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

    /// A guess, since meshes differ: half of `scale`, without the texture `times`.
    pub(super) fn mean(&self) -> f32 {
        0.5 * self.scale
    }
}
