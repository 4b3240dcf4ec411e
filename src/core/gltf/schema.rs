//! The JSON of a glTF 2.0 file, as far as it is read: the objects of the specification with their defaults.
//!
//! Indices are unchecked; the code that follows one checks it. Members that are not listed here are not read.

mod materials;

use std::collections::HashMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

pub use self::materials::*;
use crate::files::checksum;

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Root {
    pub asset: Asset,
    pub extensions_required: Vec<String>,
    pub extensions_used: Vec<String>,
    pub scene: Option<usize>,
    pub scenes: Vec<Scene>,
    pub nodes: Vec<Node>,
    pub meshes: Vec<Mesh>,
    pub materials: Vec<Material>,
    pub textures: Vec<Texture>,
    pub images: Vec<Image>,
    pub samplers: Vec<Sampler>,
    pub cameras: Vec<Camera>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: Vec<Buffer>,
    pub animations: Vec<Animation>,
    pub skins: Vec<Skin>,
    pub extensions: RootExtensions,
}

impl Root {
    /// Whether a file beside this one is unchanged since it was written with it, according to its extras. Extras in
    /// files of other programs do not count: they may have been copied from a file of ours together with an object that
    /// was changed.
    pub fn is_as_written(&self, extras: &Value, content: &[u8]) -> bool {
        let generator = self.asset.generator.as_str().unwrap_or_default();
        let written = extras["sunroom_crc32"].as_str();
        !generator.starts_with("Sunroom ") || written.is_none_or(|written| written == checksum(content))
    }
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Asset {
    pub version: String,
    pub generator: Value,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct RootExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub lights: Lights,
    #[serde(rename = "EXT_lights_ies")]
    pub profiles: Profiles,
    #[serde(rename = "KHR_materials_variants")]
    pub variants: Variants,
}

/// KHR_materials_variants, as far as it is needed for a warning.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Variants {
    pub variants: Vec<Variant>,
}

/// A name of materials among which programs offer a choice.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Variant {
    pub name: String,
}

/// The light profiles of EXT_lights_ies.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Profiles {
    pub lights: Vec<Profile>,
}

/// A file of IES LM-63, in a file of its own or in a buffer.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Profile {
    pub name: Option<String>,
    pub uri: Option<String>,
    pub buffer_view: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Lights {
    pub lights: Vec<Light>,
}

#[derive(Debug, Deserialize)]
pub struct Light {
    pub name: Option<String>,
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(default = "white")]
    pub color: [f32; 3],
    #[serde(default = "one")]
    pub intensity: f32,
    #[serde(default)]
    pub spot: Spot,
}

/// The half angles of a spot's cone in radians.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Spot {
    /// The angle within which the spot has its full strength, less than the outer one.
    pub inner_cone_angle: f32,
    /// The angle at which the spot ends, at most pi / 2.
    pub outer_cone_angle: f32,
}

impl Default for Spot {
    fn default() -> Self {
        Self {
            inner_cone_angle: 0.0,
            outer_cone_angle: std::f32::consts::FRAC_PI_4,
        }
    }
}

#[derive(Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub struct Scene {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Node {
    pub name: Option<String>,
    pub children: Vec<usize>,
    pub matrix: Option<[f32; 16]>,
    pub translation: Option<[f32; 3]>,
    pub rotation: Option<[f32; 4]>,
    pub scale: Option<[f32; 3]>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    pub camera: Option<usize>,
    /// The weights of the morph targets at this node, which replace those of the mesh.
    pub weights: Option<Vec<f32>>,
    pub extensions: NodeExtensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub light: Option<NodeLight>,
    #[serde(rename = "EXT_lights_ies")]
    pub profile: Option<NodeProfile>,
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Visibility,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing>,
}

/// Accessors of the poses of many instances.
#[derive(Debug, Deserialize)]
pub struct Instancing {
    pub attributes: HashMap<String, usize>,
}

/// Whether a node is visible, with all nodes below it.
#[derive(Debug, Deserialize)]
#[serde(default)]
pub struct Visibility {
    pub visible: bool,
}

impl Default for Visibility {
    fn default() -> Self {
        Self { visible: true }
    }
}

/// A light of a node.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct NodeLight {
    /// The index of the light.
    pub light: usize,
}

/// A lamp with measured intensities at a node.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct NodeProfile {
    /// The index of the light profile.
    pub light: usize,
    /// The factor on its intensities.
    #[serde(default = "one")]
    pub multiplier: f32,
    /// A factor on them by colour, linear, at most 1.
    #[serde(default = "white")]
    pub color: [f32; 3],
}

/// The bones of skinned meshes: indices of nodes, and the accessor of the matrices from mesh to bone space.
#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Skin {
    pub joints: Vec<usize>,
    pub inverse_bind_matrices: Option<usize>,
}

#[derive(Debug, Deserialize)]
pub struct Mesh {
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
    /// The weights of the morph targets at rest.
    #[serde(default)]
    pub weights: Vec<f32>,
}

#[derive(Debug, Deserialize)]
pub struct Primitive {
    pub attributes: HashMap<String, usize>,
    pub indices: Option<usize>,
    pub material: Option<usize>,
    #[serde(default = "triangles")]
    pub mode: u32,
    #[serde(default)]
    pub targets: Vec<HashMap<String, usize>>,
    #[serde(default)]
    pub extensions: PrimitiveExtensions,
    /// The reason why its compressed values cannot be read.
    #[serde(skip)]
    pub fault: Option<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<DracoPrimitive>,
}

/// The buffer view with the Draco stream of a primitive, and the ids of attributes in it.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct DracoPrimitive {
    pub buffer_view: usize,
    #[serde(default)]
    pub attributes: HashMap<String, u32>,
}

fn triangles() -> u32 {
    4
}

#[derive(Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
pub struct Texture {
    pub source: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampler: Option<usize>,
    /// Images of other formats. They are not written.
    #[serde(skip_serializing)]
    pub extensions: FurtherSources,
}

impl Texture {
    /// The image: the PNG or JPEG picture if there is one, since it needs no conversion.
    pub fn image(&self) -> Option<usize> {
        let further = [&self.extensions.webp, &self.extensions.basis];
        let further = further.into_iter().flatten().find_map(|further| further.source);
        self.source.or(further)
    }
}

/// The images of a texture in formats of extensions.
#[derive(Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct FurtherSources {
    #[serde(rename = "EXT_texture_webp")]
    pub webp: Option<FurtherSource>,
    #[serde(rename = "KHR_texture_basisu")]
    pub basis: Option<FurtherSource>,
}

#[derive(Debug, Default, PartialEq, Deserialize)]
#[serde(default)]
pub struct FurtherSource {
    pub source: Option<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Image {
    pub name: Option<String>,
    pub uri: Option<String>,
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub extras: Value,
}

/// The filter and the wrapping of a texture, by the numbers of the specification. The default repeats, and
/// interpolates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase", default)]
pub struct Sampler {
    /// 9728 (nearest) or 9729 (linear).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mag_filter: Option<u32>,
    /// 33071 (clamp), 33648 (mirror) or 10497 (repeat).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wrap_s: Option<u32>,
    /// 33071 (clamp), 33648 (mirror) or 10497 (repeat).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wrap_t: Option<u32>,
}

#[derive(Debug, Deserialize)]
pub struct Camera {
    pub name: Option<String>,
    pub perspective: Option<Perspective>,
    pub orthographic: Option<Orthographic>,
}

/// A perspective camera.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Perspective {
    /// Width over height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aspect_ratio: Option<f32>,
    /// The field of view along y in radians.
    pub yfov: f32,
    /// The distance of the near plane.
    pub znear: f32,
    /// The distance of the far plane.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zfar: Option<f32>,
}

/// An orthographic camera.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Orthographic {
    /// Half the width of the picture.
    pub xmag: f32,
    /// Half the height of the picture.
    pub ymag: f32,
    /// The distance of the near plane.
    pub znear: f32,
    /// The distance of the far plane.
    pub zfar: f32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<Sparse>,
}

impl Accessor {
    /// The number of components of an element; None for an unknown type.
    pub fn components(&self) -> Option<usize> {
        Some(match self.kind.as_str() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" | "MAT2" => 4,
            "MAT3" => 9,
            "MAT4" => 16,
            _ => return None,
        })
    }
}

#[derive(Debug, Deserialize)]
pub struct Sparse {
    pub count: usize,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u32,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
    #[serde(default)]
    pub extensions: BufferViewExtensions,
    /// The reason why its compressed bytes cannot be read.
    #[serde(skip)]
    pub fault: Option<String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct BufferViewExtensions {
    #[serde(rename = "EXT_meshopt_compression")]
    pub meshopt: Option<CompressedView>,
    #[serde(rename = "KHR_meshopt_compression")]
    pub later_meshopt: Option<CompressedView>,
}

/// The place of a compressed stream, and the elements in it.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct CompressedView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: usize,
    pub count: usize,
    pub mode: String,
    pub filter: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    pub uri: Option<String>,
    pub byte_length: usize,
    #[serde(default)]
    pub extras: Value,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Animation {
    pub name: Option<String>,
    pub channels: Vec<Channel>,
    pub samplers: Vec<AnimationSampler>,
}

#[derive(Debug, Deserialize)]
pub struct Channel {
    pub sampler: usize,
    pub target: ChannelTarget,
}

#[derive(Debug, Deserialize)]
pub struct ChannelTarget {
    pub node: Option<usize>,
    pub path: String,
}

/// Accessors of times and values.
#[derive(Debug, Deserialize)]
pub struct AnimationSampler {
    pub input: usize,
    pub output: usize,
    pub interpolation: Option<String>,
}

fn one() -> f32 {
    1.0
}

fn white() -> [f32; 3] {
    [1.0; 3]
}
