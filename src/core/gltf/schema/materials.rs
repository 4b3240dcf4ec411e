//! The materials of a glTF file and their use of textures. The layers are shared by the reader and the writer.

use std::collections::BTreeMap;

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use serde_json::Value;

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Material {
    pub name: Option<String>,
    pub pbr_metallic_roughness: Pbr,
    pub normal_texture: Option<TextureInfo>,
    pub emissive_texture: Option<TextureInfo>,
    pub emissive_factor: [f32; 3],
    pub alpha_mode: Option<String>,
    pub alpha_cutoff: Option<f32>,
    pub double_sided: bool,
    pub extensions: MaterialExtensions,
}

/// The metallic-roughness model.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Pbr {
    /// Linear Rec. 709 with alpha.
    pub base_color_factor: [f32; 4],
    /// sRGB with alpha.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_color_texture: Option<TextureInfo>,
    /// 0 to 1.
    pub metallic_factor: f32,
    /// 0 to 1.
    pub roughness_factor: f32,
    /// Roughness in green, metallic in blue.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metallic_roughness_texture: Option<TextureInfo>,
}

impl Default for Pbr {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
        }
    }
}

/// The layers, which are extensions.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct MaterialExtensions {
    /// A factor on the emission.
    #[serde(rename = "KHR_materials_emissive_strength", skip_serializing_if = "Option::is_none")]
    pub emissive_strength: Option<EmissiveStrength>,
    /// Transmission of light through the surface.
    #[serde(rename = "KHR_materials_transmission", skip_serializing_if = "Option::is_none")]
    pub transmission: Option<Transmission>,
    /// The volume below the surface.
    #[serde(rename = "KHR_materials_volume", skip_serializing_if = "Option::is_none")]
    pub volume: Option<Volume>,
    /// The index of refraction.
    #[serde(rename = "KHR_materials_ior", skip_serializing_if = "Option::is_none")]
    pub ior: Option<IndexOfRefraction>,
    /// A clear coat.
    #[serde(rename = "KHR_materials_clearcoat", skip_serializing_if = "Option::is_none")]
    pub clearcoat: Option<Clearcoat>,
    /// The sheen of cloth.
    #[serde(rename = "KHR_materials_sheen", skip_serializing_if = "Option::is_none")]
    pub sheen: Option<Sheen>,
    /// The specular reflection of dielectrics.
    #[serde(rename = "KHR_materials_specular", skip_serializing_if = "Option::is_none")]
    pub specular: Option<Specular>,
    /// The stretch of highlights.
    #[serde(rename = "KHR_materials_anisotropy", skip_serializing_if = "Option::is_none")]
    pub anisotropy: Option<Anisotropy>,
    /// Matt light that goes through the surface.
    #[serde(
        rename = "KHR_materials_diffuse_transmission",
        skip_serializing_if = "Option::is_none"
    )]
    pub diffuse_transmission: Option<DiffuseTransmission>,
    #[serde(rename = "KHR_materials_iridescence", skip_serializing)]
    pub(in crate::gltf) iridescence: Option<Iridescence>,
    #[serde(rename = "KHR_materials_dispersion", skip_serializing)]
    pub(in crate::gltf) dispersion: Option<Dispersion>,
    /// A colour without shading.
    #[serde(rename = "KHR_materials_unlit", skip_serializing_if = "Option::is_none")]
    pub unlit: Option<Value>,
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness", skip_serializing)]
    pub(in crate::gltf) specular_glossiness: Option<SpecularGlossiness>,
    /// All other extensions of the file, by name. They are not read.
    #[serde(flatten, skip_serializing)]
    pub unread: BTreeMap<String, IgnoredAny>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct SpecularGlossiness {
    pub diffuse_factor: [f32; 4],
    pub diffuse_texture: Option<TextureInfo>,
    pub specular_factor: [f32; 3],
    pub glossiness_factor: f32,
    pub specular_glossiness_texture: Option<TextureInfo>,
}

impl Default for SpecularGlossiness {
    fn default() -> Self {
        Self {
            diffuse_factor: [1.0; 4],
            diffuse_texture: None,
            specular_factor: [1.0; 3],
            glossiness_factor: 1.0,
            specular_glossiness_texture: None,
        }
    }
}

/// KHR_materials_emissive_strength.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct EmissiveStrength {
    /// At least 0.
    #[serde(default = "super::one")]
    pub emissive_strength: f32,
}

/// KHR_materials_transmission.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Transmission {
    /// The share of transmitted light, 0 to 1.
    pub transmission_factor: f32,
    /// A factor on it, in the red channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transmission_texture: Option<TextureInfo>,
}

/// KHR_materials_volume.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Volume {
    /// The thickness for rasterizers; above 0.
    pub thickness_factor: f32,
    /// The distance after which light has the attenuation colour.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attenuation_distance: Option<f32>,
    /// Linear Rec. 709.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attenuation_color: Option<[f32; 3]>,
}

/// KHR_materials_ior.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct IndexOfRefraction {
    /// At least 1.
    #[serde(default = "glass")]
    pub ior: f32,
}

fn glass() -> f32 {
    1.5
}

/// KHR_materials_clearcoat.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Clearcoat {
    /// 0 to 1.
    pub clearcoat_factor: f32,
    /// A factor on it, in the red channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearcoat_texture: Option<TextureInfo>,
    /// 0 to 1.
    pub clearcoat_roughness_factor: f32,
    /// A factor on it, in the green channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearcoat_roughness_texture: Option<TextureInfo>,
    /// The normals of the coat in tangent space.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearcoat_normal_texture: Option<TextureInfo>,
}

/// KHR_materials_sheen.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Sheen {
    /// Linear Rec. 709.
    pub sheen_color_factor: [f32; 3],
    /// sRGB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sheen_color_texture: Option<TextureInfo>,
    /// 0 to 1.
    pub sheen_roughness_factor: f32,
    /// A factor on it, in the alpha channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sheen_roughness_texture: Option<TextureInfo>,
}

/// KHR_materials_anisotropy.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Anisotropy {
    /// 0 to 1. Facets are widened along the tangent.
    pub anisotropy_strength: f32,
    /// Radians, counter-clockwise from the tangent.
    #[serde(skip_serializing_if = "is_usual")]
    pub anisotropy_rotation: f32,
    /// The direction in red and green, and a factor on the strength in blue.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub anisotropy_texture: Option<TextureInfo>,
}

/// KHR_materials_diffuse_transmission.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase", default)]
pub struct DiffuseTransmission {
    /// The share of matt light that is transmitted, 0 to 1.
    pub diffuse_transmission_factor: f32,
    /// A factor on it, in the alpha channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diffuse_transmission_texture: Option<TextureInfo>,
    /// Linear Rec. 709.
    pub diffuse_transmission_color_factor: [f32; 3],
    /// A factor on it, sRGB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diffuse_transmission_color_texture: Option<TextureInfo>,
}

impl Default for DiffuseTransmission {
    fn default() -> Self {
        Self {
            diffuse_transmission_factor: 0.0,
            diffuse_transmission_texture: None,
            diffuse_transmission_color_factor: [1.0; 3],
            diffuse_transmission_color_texture: None,
        }
    }
}

/// KHR_materials_iridescence, as far as it is needed for a warning.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Iridescence {
    pub iridescence_factor: f32,
}

/// KHR_materials_dispersion.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct Dispersion {
    pub dispersion: f32,
}

/// KHR_materials_specular.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Specular {
    /// A factor on the reflectance, 0 to 1.
    #[serde(default = "super::one")]
    pub specular_factor: f32,
    /// A factor on it, in the alpha channel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub specular_texture: Option<TextureInfo>,
    /// The reflectance at normal incidence, linear Rec. 709; white if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub specular_color_factor: Option<[f32; 3]>,
    /// A factor on it, sRGB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub specular_color_texture: Option<TextureInfo>,
}

/// The use of a texture by a material.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureInfo {
    /// The index of the texture.
    pub index: usize,
    /// The set of texture coordinates.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub tex_coord: usize,
    /// The scale of a normal texture. It is not written.
    #[serde(default = "super::one", skip_serializing)]
    pub scale: f32,
    /// The transform of its coordinates.
    #[serde(default, skip_serializing_if = "is_usual")]
    pub extensions: TextureExtensions,
}

/// The extensions of a texture's use.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct TextureExtensions {
    /// Applied to the coordinates before the look-up.
    #[serde(rename = "KHR_texture_transform", skip_serializing_if = "Option::is_none")]
    pub transform: Option<TextureTransform>,
}

/// KHR_texture_transform: scale, then rotation, then translation of the coordinates.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase", default)]
pub struct TextureTransform {
    /// The translation.
    pub offset: [f32; 2],
    /// Radians, counter-clockwise in the picture.
    pub rotation: f32,
    /// The factors.
    pub scale: [f32; 2],
    /// The set of texture coordinates, which replaces that of the texture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tex_coord: Option<usize>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self {
            offset: [0.0; 2],
            rotation: 0.0,
            scale: [1.0; 2],
            tex_coord: None,
        }
    }
}

/// Whether a value is the default.
pub fn is_usual<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
