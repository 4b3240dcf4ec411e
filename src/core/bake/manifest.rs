//! The manifest of a bake, `lightmaps.json`, which says how its files belong together. docs/baking.md describes it.

use std::collections::BTreeMap;

use glam::{Affine3A, Mat4};
use serde::Serialize;

use super::layers::LayerKind;
use super::level::BakedNode;

/// The content of the manifest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Manifest {
    /// Always `sunroom-lightmaps`.
    pub format: &'static str,
    /// The version of the format.
    pub version: u32,
    /// The program that wrote it.
    pub generator: &'static str,
    /// The name of the glTF file of the level, beside this one.
    pub level: String,
    /// The vertex attribute with the coordinates of lightmaps.
    pub coordinates: &'static str,
    /// The physical quantity that texels hold.
    pub quantity: &'static str,
    /// The light that the lightmaps hold: all of it, or indirect light alone.
    pub light: BakedLight,
    /// The units of the level's punctual lights: candela and lux, of which 683 are one W/sr or W/m^2. Older manifests
    /// do not have the field, nor their lights these units.
    pub light_units: &'static str,
    /// Texels per unit of length.
    pub texels_per_unit: f32,
    /// Samples of each texel.
    pub samples: u32,
    /// The seed of the random numbers.
    pub seed: u32,
    /// Whether noise was removed.
    pub denoised: bool,
    /// The files of each lightmap.
    pub lightmaps: Vec<LightmapFiles>,
    /// The nodes of the level that have a place in a lightmap.
    pub nodes: Vec<BakedNode>,
    /// The probes for reflections.
    pub reflection_probes: Vec<ReflectionFiles>,
    /// The probes for objects without a lightmap.
    pub irradiance_volumes: Vec<VolumeFiles>,
    /// The layers of the light, which sum up to the whole; none in a bake without layers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<LayerFiles>,
    /// The [checksums](crate::files::checksum) of all other files by name: they show whether the files are of one bake.
    pub crc32: BTreeMap<String, String>,
}

/// The column-major transform of a cube from -0.5 to 0.5 to the space of the level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct BoxPlace([f32; 16]);

impl From<&Affine3A> for BoxPlace {
    fn from(world_from_box: &Affine3A) -> Self {
        Self(Mat4::from(*world_from_box).to_cols_array())
    }
}

/// The files of a reflection probe. All are cube maps in the space of the box.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReflectionFiles {
    /// The name in the scene.
    pub name: String,
    /// The box.
    #[serde(rename = "box")]
    pub place: BoxPlace,
    /// Whether the surroundings stand on the sides of the box, so that reflections are corrected for parallax.
    pub parallax: bool,
    /// KTX 2: radiance, with mip levels for perceptual roughness from 0 to 1.
    pub specular: String,
    /// KTX 2: irradiance divided by pi.
    pub diffuse: String,
}

/// The file of an irradiance volume. It holds all light except the direct light of point lights, spots and directional
/// lights.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeFiles {
    /// The name in the scene.
    pub name: String,
    /// The box.
    #[serde(rename = "box")]
    pub place: BoxPlace,
    /// The number of points along each axis of the box.
    pub points: [u32; 3],
    /// Samples of each side of a point.
    pub samples: u32,
    /// KTX 2: ambient cubes of irradiance divided by pi.
    pub ktx2: String,
}

/// The light that the lightmaps hold: all of it, or indirect light alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BakedLight {
    /// All.
    All,
    /// All except the direct light of point lights, spots and directional lights.
    WithoutDirectPunctual,
}

/// The files of a lightmap, all with the same picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LightmapFiles {
    /// OpenEXR, 32-bit floats.
    pub exr: String,
    /// KTX 2, 16-bit floats.
    pub ktx2: String,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
}

/// A layer of the light: its share of lightmaps and probes. Pictures that are not named are black in it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LayerFiles {
    /// The name of the lamp in the scene.
    pub name: String,
    /// The kind of the lights.
    pub kind: LayerKind,
    /// The factor of the layer in the whole, red, green and blue: always 1.
    pub factor: [f32; 3],
    /// The nodes of the level that are the lamp: shapes that shine, and punctual lights.
    pub nodes: Vec<usize>,
    /// Its share of lightmaps.
    pub lightmaps: Vec<LightmapLayer>,
    /// Its share of reflection probes.
    pub reflection_probes: Vec<ReflectionLayer>,
    /// Its share of irradiance volumes.
    pub irradiance_volumes: Vec<VolumeLayer>,
}

impl LayerFiles {
    /// Whether it has a share of any picture.
    pub(super) fn has_files(&self) -> bool {
        !self.lightmaps.is_empty() || !self.reflection_probes.is_empty() || !self.irradiance_volumes.is_empty()
    }
}

/// A layer of a lightmap.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LightmapLayer {
    /// The index of the lightmap.
    pub lightmap: usize,
    /// OpenEXR, 32-bit floats.
    pub exr: String,
    /// KTX 2, 16-bit floats.
    pub ktx2: String,
}

/// A layer of a reflection probe.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReflectionLayer {
    /// The index of the probe.
    pub probe: usize,
    /// The layer's part of [`ReflectionFiles::specular`].
    pub specular: String,
    /// The layer's part of [`ReflectionFiles::diffuse`].
    pub diffuse: String,
}

/// A layer of an irradiance volume.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeLayer {
    /// The index of the volume.
    pub volume: usize,
    /// The layer's part of [`VolumeFiles::ktx2`].
    pub ktx2: String,
}

impl Manifest {
    /// [`Self::format`].
    pub const FORMAT: &'static str = "sunroom-lightmaps";
    /// [`Self::version`].
    pub const VERSION: u32 = 1;
    /// [`Self::light_units`].
    pub const LIGHT_UNITS: &'static str = "candela and lux";
    /// [`Self::generator`].
    pub const GENERATOR: &'static str = concat!("Sunroom ", env!("CARGO_PKG_VERSION"));
    /// [`Self::coordinates`].
    pub const COORDINATES: &'static str = "TEXCOORD_1";
    /// [`Self::quantity`].
    pub const QUANTITY: &'static str = "irradiance / pi, linear Rec. 709: the radiance of a white diffuse surface";

    /// The text of the file.
    pub fn text(&self) -> Result<Vec<u8>, serde_json::Error> {
        let mut text = serde_json::to_vec_pretty(self)?;
        text.push(b'\n');
        Ok(text)
    }
}
