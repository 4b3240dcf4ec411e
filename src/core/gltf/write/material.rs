//! Materials of a glTF 2.0 file for writing: metallic-roughness, and the layers of the KHR extensions.

use serde::Serialize;

use crate::gltf::schema::is_usual;
pub use crate::gltf::schema::{
    Anisotropy, Clearcoat, DiffuseTransmission, EmissiveStrength, IndexOfRefraction, MaterialExtensions, Pbr, Sheen,
    Specular, TextureExtensions, TextureInfo, TextureTransform, Transmission, Volume,
};

/// A material.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Material {
    /// The name.
    pub name: String,
    /// The metallic-roughness base.
    pub pbr_metallic_roughness: Pbr,
    /// The normal map in tangent space, y up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_texture: Option<TextureInfo>,
    /// The emission, at most 1.
    #[serde(skip_serializing_if = "is_usual")]
    pub emissive_factor: [f32; 3],
    /// A factor on the emission, by colour over the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emissive_texture: Option<TextureInfo>,
    /// `MASK` or `BLEND`; None for opaque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alpha_mode: Option<&'static str>,
    /// Whether the back is visible as well.
    #[serde(skip_serializing_if = "is_usual")]
    pub double_sided: bool,
    /// Whether only the front emits, which glTF cannot express.
    #[serde(skip)]
    pub shines_from_front: bool,
    /// Further layers.
    #[serde(skip_serializing_if = "is_usual")]
    pub extensions: MaterialExtensions,
}

impl Material {
    /// All textures of the material.
    pub(super) fn textures(&self) -> impl Iterator<Item = &TextureInfo> {
        let extensions = &self.extensions;
        let of_transmission = extensions
            .transmission
            .as_ref()
            .map(|layer| &layer.transmission_texture);
        let of_coat = extensions.clearcoat.as_ref().map(|layer| &layer.clearcoat_texture);
        let pbr = &self.pbr_metallic_roughness;
        let own = [
            &pbr.base_color_texture,
            &pbr.metallic_roughness_texture,
            &self.normal_texture,
            &self.emissive_texture,
        ];
        own.into_iter().chain(of_transmission).chain(of_coat).flatten()
    }
}
