//! Materials of a glTF 2.0 file as they are written: metallic-roughness, and the layers of the KHR extensions.

use serde::Serialize;

/// Whether a value is the one that is meant where the file does not say any.
pub(super) fn is_usual<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// A material.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Material {
    /// The name.
    pub name: String,
    /// The base of it.
    pub pbr_metallic_roughness: Pbr,
    /// Normals in tangent space, y up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_texture: Option<TextureInfo>,
    /// The light that it sends out, at most 1.
    #[serde(skip_serializing_if = "is_usual")]
    pub emissive_factor: [f32; 3],
    /// The same, by colour over the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emissive_texture: Option<TextureInfo>,
    /// `MASK` or `BLEND`; None is opaque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alpha_mode: Option<&'static str>,
    /// Whether its back is seen as well.
    #[serde(skip_serializing_if = "is_usual")]
    pub double_sided: bool,
    /// Whether the light that it sends out leaves the front alone, for which glTF has no word.
    #[serde(skip)]
    pub shines_from_front: bool,
    /// Further layers.
    #[serde(skip_serializing_if = "is_usual")]
    pub extensions: MaterialExtensions,
}

/// The metallic-roughness model.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
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
            metallic_factor: 0.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
        }
    }
}

/// The layers that are extensions.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct MaterialExtensions {
    /// A factor on the light that is sent out.
    #[serde(rename = "KHR_materials_emissive_strength", skip_serializing_if = "Option::is_none")]
    pub emissive_strength: Option<EmissiveStrength>,
    /// Light that goes through.
    #[serde(rename = "KHR_materials_transmission", skip_serializing_if = "Option::is_none")]
    pub transmission: Option<Transmission>,
    /// What is inside of the surface.
    #[serde(rename = "KHR_materials_volume", skip_serializing_if = "Option::is_none")]
    pub volume: Option<Volume>,
    /// The index of refraction.
    #[serde(rename = "KHR_materials_ior", skip_serializing_if = "Option::is_none")]
    pub ior: Option<IndexOfRefraction>,
    /// A clear layer of lacquer.
    #[serde(rename = "KHR_materials_clearcoat", skip_serializing_if = "Option::is_none")]
    pub clearcoat: Option<Clearcoat>,
    /// The glow of cloth.
    #[serde(rename = "KHR_materials_sheen", skip_serializing_if = "Option::is_none")]
    pub sheen: Option<Sheen>,
    /// The strength of the mirror image of what is no metal.
    #[serde(rename = "KHR_materials_specular", skip_serializing_if = "Option::is_none")]
    pub specular: Option<Specular>,
}

/// KHR_materials_emissive_strength.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct EmissiveStrength {
    /// At least 0.
    pub emissive_strength: f32,
}

/// KHR_materials_transmission.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Transmission {
    /// The share of light, 0 to 1.
    pub transmission_factor: f32,
    /// The same in red.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transmission_texture: Option<TextureInfo>,
}

/// KHR_materials_volume.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Volume {
    /// How thick it is for programs that do not trace light through it; above 0.
    pub thickness_factor: f32,
    /// After this distance light has the attenuation colour.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attenuation_distance: Option<f32>,
    /// Linear Rec. 709.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub attenuation_color: Option<[f32; 3]>,
}

/// KHR_materials_ior.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IndexOfRefraction {
    /// At least 1.
    pub ior: f32,
}

/// KHR_materials_clearcoat.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Clearcoat {
    /// 0 to 1.
    pub clearcoat_factor: f32,
    /// The same in red.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearcoat_texture: Option<TextureInfo>,
    /// 0 to 1.
    pub clearcoat_roughness_factor: f32,
}

/// KHR_materials_sheen.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Sheen {
    /// Linear Rec. 709.
    pub sheen_color_factor: [f32; 3],
    /// 0 to 1.
    pub sheen_roughness_factor: f32,
}

/// KHR_materials_specular.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Specular {
    /// A factor on the reflectance, 0 to 1.
    pub specular_factor: f32,
}

/// A texture as a material uses it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct TextureInfo {
    /// The index of the texture.
    pub index: usize,
    /// The set of texture coordinates.
    #[serde(skip_serializing_if = "is_usual")]
    pub tex_coord: usize,
    /// How it lies.
    #[serde(skip_serializing_if = "is_usual")]
    pub extensions: TextureExtensions,
}

/// The extensions of a texture's use.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TextureExtensions {
    /// Applied to the coordinates before the look-up.
    #[serde(rename = "KHR_texture_transform", skip_serializing_if = "Option::is_none")]
    pub transform: Option<TextureTransform>,
}

/// KHR_texture_transform: a scale, then a turn, then a shift of the coordinates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TextureTransform {
    /// The shift.
    pub offset: [f32; 2],
    /// Radians, counter-clockwise in the picture.
    pub rotation: f32,
    /// The factors.
    pub scale: [f32; 2],
}

impl Material {
    /// The textures that it uses.
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
