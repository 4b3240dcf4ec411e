//! The parts of a glTF 2.0 file for writing, under the names of the specification (section 5) and of the KHR
//! extensions. Absent values are left out of the file. Materials are in `material.rs`.

use std::collections::BTreeMap;

use serde::Serialize;

use super::material::{Material, MaterialExtensions, TextureInfo};
use crate::files::checksum;
pub(super) use crate::gltf::schema::Texture;
pub use crate::gltf::schema::{NodeLight, NodeProfile, Orthographic, Perspective, Sampler, Spot};
use crate::gltf::schema::{Scene, is_usual};

/// The whole file.
#[derive(Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Root {
    pub asset: Asset,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extensions_used: Vec<&'static str>,
    #[serde(skip_serializing_if = "is_usual")]
    pub extensions: RootExtensions,
    pub scene: usize,
    pub scenes: Vec<Scene>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<Node>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<Mesh>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<Material>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub textures: Vec<Texture>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub samplers: Vec<Sampler>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub images: Vec<Image>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub cameras: Vec<Camera>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub animations: Vec<Animation>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub accessors: Vec<Accessor>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub buffer_views: Vec<BufferView>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub buffers: Vec<Buffer>,
}

#[derive(Debug, Serialize)]
pub(super) struct Asset {
    pub version: &'static str,
    pub generator: &'static str,
}

impl Default for Asset {
    fn default() -> Self {
        Self {
            version: "2.0",
            generator: concat!("Sunroom ", env!("CARGO_PKG_VERSION")),
        }
    }
}

#[derive(Debug, Default, PartialEq, Serialize)]
pub(super) struct RootExtensions {
    #[serde(rename = "KHR_lights_punctual", skip_serializing_if = "is_usual")]
    pub lights: Lights,
    #[serde(rename = "EXT_lights_ies", skip_serializing_if = "is_usual")]
    pub profiles: Profiles,
}

/// The light profiles of EXT_lights_ies.
#[derive(Debug, Default, PartialEq, Serialize)]
pub(super) struct Profiles {
    pub lights: Vec<Profile>,
}

#[derive(Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Profile {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uri: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mime_type: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub buffer_view: Option<usize>,
}

#[derive(Debug, Default, PartialEq, Serialize)]
pub(super) struct Lights {
    pub lights: Vec<Light>,
}

/// A node: a pose in the world with a mesh, a camera or a light.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Node {
    /// The name.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// The pose relative to its parent.
    #[serde(flatten)]
    pub pose: Pose,
    /// The index of the mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<usize>,
    /// The index of the camera, which looks along -z.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<usize>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    /// The indices of its child nodes, which are appended as these are added.
    pub children: Vec<usize>,
    /// The light.
    #[serde(skip_serializing_if = "is_usual")]
    pub extensions: NodeExtensions,
    /// Data for other programs that the specification does not define.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<serde_json::Value>,
    /// The position of the thing in the scene's file. It is not written.
    #[serde(skip)]
    pub order: Option<u32>,
    /// The lightmap texels per length, relative to other meshes; None means 1. It is not written.
    #[serde(skip)]
    pub lightmap_scale: Option<f32>,
}

/// A pose as in glTF: scale, then rotation, then translation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pose {
    /// The translation.
    #[serde(skip_serializing_if = "is_usual")]
    pub translation: [f32; 3],
    /// The rotation: a unit quaternion, x y z w.
    #[serde(skip_serializing_if = "is_no_turn")]
    pub rotation: [f32; 4],
    /// The factors along the axes; a negative one mirrors.
    #[serde(skip_serializing_if = "is_no_scale")]
    pub scale: [f32; 3],
}

const NO_TURN: [f32; 4] = [0.0, 0.0, 0.0, 1.0];
const NO_SCALE: [f32; 3] = [1.0; 3];

fn is_no_turn(rotation: &[f32; 4]) -> bool {
    *rotation == NO_TURN
}

fn is_no_scale(scale: &[f32; 3]) -> bool {
    *scale == NO_SCALE
}

impl Default for Pose {
    fn default() -> Self {
        Self {
            translation: [0.0; 3],
            rotation: NO_TURN,
            scale: NO_SCALE,
        }
    }
}

/// The extensions of a node.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct NodeExtensions {
    /// The light at the node.
    #[serde(rename = "KHR_lights_punctual", skip_serializing_if = "Option::is_none")]
    pub light: Option<NodeLight>,
    /// The light profile at the node.
    #[serde(rename = "EXT_lights_ies", skip_serializing_if = "Option::is_none")]
    pub profile: Option<NodeProfile>,
}

/// A light of KHR_lights_punctual, which shines along -z of its node.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Light {
    /// The name.
    pub name: String,
    /// `point`, `spot` or `directional`.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// Linear Rec. 709, at most 1.
    pub color: [f32; 3],
    /// In candela; in lux for a directional light.
    pub intensity: f32,
    /// The cone of a spot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spot: Option<Spot>,
}

/// A mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mesh {
    /// The name.
    pub name: String,
    /// Its parts, one for each material.
    pub primitives: Vec<Primitive>,
}

/// Accessors by attribute: `POSITION`, `NORMAL`, `TANGENT`, `TEXCOORD_0`, `TEXCOORD_1`, `COLOR_0`.
pub type Attributes = BTreeMap<String, usize>;

/// Triangles of one material.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Primitive {
    /// The accessors of its vertices.
    pub attributes: Attributes,
    /// The accessor of its indices.
    pub indices: usize,
    /// The index of the material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<usize>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Image {
    pub name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uri: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mime_type: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub buffer_view: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<FileExtras>,
}

/// The checksum by which a reader recognises the file as unchanged.
#[derive(Debug, Serialize)]
pub(super) struct FileExtras {
    pub sunroom_crc32: String,
}

impl FileExtras {
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let sunroom_crc32 = checksum(bytes);
        Some(Self { sunroom_crc32 })
    }
}

/// A camera.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Camera {
    /// The name.
    pub name: String,
    /// The projection with its parameters.
    #[serde(flatten)]
    pub projection: Projection,
}

/// The projections of a camera.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "camelCase")]
pub enum Projection {
    /// Perspective.
    Perspective {
        /// The parameters.
        perspective: Perspective,
    },
    /// Orthographic.
    Orthographic {
        /// The parameters.
        orthographic: Orthographic,
    },
}

#[derive(Debug, Default, Serialize)]
pub(super) struct Animation {
    pub channels: Vec<Channel>,
    pub samplers: Vec<AnimationSampler>,
}

#[derive(Debug, Serialize)]
pub(super) struct Channel {
    pub sampler: usize,
    pub target: ChannelTarget,
}

#[derive(Debug, Serialize)]
pub(super) struct ChannelTarget {
    pub node: usize,
    pub path: &'static str,
}

#[derive(Debug, Serialize)]
pub(super) struct AnimationSampler {
    pub input: usize,
    pub output: usize,
    pub interpolation: &'static str,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: usize,
    pub component_type: u32,
    pub count: usize,
    #[serde(rename = "type")]
    pub kind: &'static str,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub min: Vec<f32>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub max: Vec<f32>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub buffer: usize,
    pub byte_offset: usize,
    pub byte_length: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<u32>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub byte_length: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uri: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extras: Option<FileExtras>,
}

impl Root {
    /// The extensions that the file uses.
    pub fn used_extensions(&self) -> Vec<&'static str> {
        let any = |is_used: &dyn Fn(&Material) -> bool| self.materials.iter().any(is_used);
        let of = |is_used: &dyn Fn(&MaterialExtensions) -> bool| any(&|material| is_used(&material.extensions));
        let is_transformed = |info: &TextureInfo| info.extensions.transform.is_some();
        let all = [
            ("EXT_lights_ies", !self.extensions.profiles.lights.is_empty()),
            ("KHR_lights_punctual", !self.extensions.lights.lights.is_empty()),
            ("KHR_materials_anisotropy", of(&|has| has.anisotropy.is_some())),
            ("KHR_materials_clearcoat", of(&|has| has.clearcoat.is_some())),
            (
                "KHR_materials_diffuse_transmission",
                of(&|has| has.diffuse_transmission.is_some()),
            ),
            (
                "KHR_materials_emissive_strength",
                of(&|has| has.emissive_strength.is_some()),
            ),
            ("KHR_materials_ior", of(&|has| has.ior.is_some())),
            ("KHR_materials_sheen", of(&|has| has.sheen.is_some())),
            ("KHR_materials_specular", of(&|has| has.specular.is_some())),
            ("KHR_materials_transmission", of(&|has| has.transmission.is_some())),
            ("KHR_materials_volume", of(&|has| has.volume.is_some())),
            (
                "KHR_texture_transform",
                any(&|material| material.textures().any(is_transformed)),
            ),
        ];
        let used = all.into_iter().filter(|(_, is_used)| *is_used);
        used.map(|(name, _)| name).collect()
    }
}
