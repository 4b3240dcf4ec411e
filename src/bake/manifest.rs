//! The file that says how the files of a bake belong together: `lightmaps.json`. docs/baking.md describes it.

use serde::Serialize;

use super::level::BakedNode;

/// The content of the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Manifest {
    /// `sunroom-lightmaps`.
    pub format: &'static str,
    /// The version of the format.
    pub version: u32,
    /// The program that wrote it.
    pub generator: &'static str,
    /// The name of the level's file beside this one.
    pub level: String,
    /// The attribute of meshes with the coordinates of lightmaps.
    pub coordinates: &'static str,
    /// What texels hold.
    pub quantity: &'static str,
    /// The light that is in the lightmaps.
    pub light: BakedLight,
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
}

/// The light that is in the lightmaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BakedLight {
    /// All.
    All,
    /// All but what comes straight from point lights, spots and directional lights.
    WithoutDirectPunctual,
}

/// The files of a lightmap, which hold the same picture.
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

impl Manifest {
    /// [`Self::format`].
    pub const FORMAT: &'static str = "sunroom-lightmaps";
    /// [`Self::version`].
    pub const VERSION: u32 = 1;
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
