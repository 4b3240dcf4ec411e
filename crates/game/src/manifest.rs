//! The file `lightmaps.json` as an asset.

use std::collections::BTreeMap;

use bevy::asset::io::Reader;
use bevy::asset::{Asset, AssetLoader, LoadContext};
use bevy::log::warn;
use bevy::reflect::TypePath;
use serde::Deserialize;
use thiserror::Error;

/// What a game needs of the file. docs/baking.md of Sunroom describes all of it.
#[derive(Asset, TypePath, Clone, Debug, PartialEq, Deserialize)]
pub struct LevelManifest {
    format: String,
    version: u32,
    light: String,
    /// The units of the punctual lights.
    #[serde(default)]
    light_units: Option<String>,
    /// The files of each lightmap.
    pub lightmaps: Vec<LightmapFiles>,
    /// What reflecting surfaces see.
    #[serde(default)]
    pub reflection_probes: Vec<ReflectionFiles>,
    /// The light for what has no lightmap.
    #[serde(default)]
    pub irradiance_volumes: Vec<VolumeFiles>,
    /// The light of each lamp by itself.
    #[serde(default)]
    pub layers: Vec<LayerFiles>,
    /// The CRC-32 of each file of the bake by its name.
    #[serde(default)]
    crc32: BTreeMap<String, String>,
}

/// The files of a lightmap, beside the manifest.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct LightmapFiles {
    /// OpenEXR.
    pub exr: String,
    /// KTX 2.
    pub ktx2: String,
}

/// The files of a reflection probe, beside the manifest.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct ReflectionFiles {
    /// The name in the scene.
    pub name: String,
    /// The place of a cube from -0.5 to 0.5 in the space of the level, column by column.
    #[serde(rename = "box")]
    pub place: [f32; 16],
    /// Whether what is seen stands on the sides of the box.
    pub parallax: bool,
    /// Radiance, in levels for perceptual roughness from 0 to 1.
    pub specular: String,
    /// Irradiance divided by pi.
    pub diffuse: String,
}

/// The file of an irradiance volume, beside the manifest.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct VolumeFiles {
    /// The name in the scene.
    pub name: String,
    /// The place of a cube from -0.5 to 0.5 in the space of the level, column by column.
    #[serde(rename = "box")]
    pub place: [f32; 16],
    /// Ambient cubes of irradiance divided by pi.
    pub ktx2: String,
}

/// The kind of the lights of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LayerKind {
    /// A lamp.
    Lamp,
    /// A sky, with its sun if it has one.
    Sky,
    /// Parallel light.
    Sun,
    /// Light that cannot be dimmed.
    Rest,
}

/// The files of a layer. Textures that are not named are black in it.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct LayerFiles {
    /// The name of the lamp in the scene.
    pub name: String,
    /// The kind of its lights.
    pub kind: LayerKind,
    /// Its share of lightmaps.
    pub lightmaps: Vec<LightmapLayer>,
    /// Its share of reflection probes.
    pub reflection_probes: Vec<ReflectionLayer>,
    /// Its share of irradiance volumes.
    pub irradiance_volumes: Vec<VolumeLayer>,
}

/// A layer of a lightmap.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct LightmapLayer {
    /// The index of the lightmap.
    pub lightmap: usize,
    /// KTX 2.
    pub ktx2: String,
}

/// A layer of a reflection probe.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct ReflectionLayer {
    /// The index of the probe.
    pub probe: usize,
    /// The layer's part of [`ReflectionFiles::specular`].
    pub specular: String,
    /// The layer's part of [`ReflectionFiles::diffuse`].
    pub diffuse: String,
}

/// A layer of an irradiance volume.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
pub struct VolumeLayer {
    /// The index of the volume.
    pub volume: usize,
    /// The layer's part of [`VolumeFiles::ktx2`].
    pub ktx2: String,
}

impl LevelManifest {
    /// Whether the direct light of points, spots and directional lights is in the lightmaps.
    pub fn has_direct_light(&self) -> bool {
        self.light == "all"
    }

    /// The lumens of the level's punctual lights that are one watt: the levels of older bakes have watts.
    pub(crate) fn lumens_per_watt(&self) -> f32 {
        match self.light_units.as_deref() {
            Some("candela and lux") => 683.0,
            _ => 1.0,
        }
    }

    fn read(bytes: &[u8]) -> Result<Self, ManifestError> {
        let manifest: Self = serde_json::from_slice(bytes)?;
        match (&*manifest.format, manifest.version) {
            ("sunroom-lightmaps", 1) => Ok(manifest),
            (format, version) => Err(ManifestError::Version(format!("{format} {version}"))),
        }
    }
}

/// The reason why a manifest cannot be read.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum ManifestError {
    #[error("the file cannot be read: {0}")]
    File(#[from] std::io::Error),
    #[error("the file is no manifest of lightmaps: {0}")]
    Json(#[from] serde_json::Error),
    #[error("a manifest of the format {0}; this version reads sunroom-lightmaps 1")]
    Version(String),
}

#[derive(TypePath)]
pub(crate) struct ManifestLoader;

impl AssetLoader for ManifestLoader {
    type Asset = LevelManifest;
    type Settings = ();
    type Error = ManifestError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        (): &(),
        context: &mut LoadContext<'_>,
    ) -> Result<LevelManifest, ManifestError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let manifest = LevelManifest::read(&bytes)?;
        // Games need no `.exr` files. What is missing is told where it is loaded.
        for (file, sum) in manifest.crc32.iter().filter(|(file, _)| !file.ends_with(".exr")) {
            if let Ok(path) = context.path().resolve_embed_str(file)
                && let Ok(bytes) = context.read_asset_bytes(path).await
                && format!("{:08x}", crc32fast::hash(&bytes)) != *sum
            {
                warn!(
                    "{file} is of another bake than {}: bake the level again, or copy all of its files",
                    context.path()
                );
            }
        }
        Ok(manifest)
    }

    // Asked by the type of the asset, so that it takes no other `.json` file.
    fn extensions(&self) -> &[&str] {
        &[]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_are_read() {
        let text = r#"{"format":"sunroom-lightmaps","version":1,"light":"all","lightmaps":[],"layers":[
            {"name":"bulb","kind":"lamp","factor":[1,1,1],"nodes":[2],
            "lightmaps":[{"lightmap":0,"exr":"a.exr","ktx2":"a.ktx2"}],
            "reflection_probes":[{"probe":0,"specular":"s.ktx2","diffuse":"d.ktx2"}],
            "irradiance_volumes":[{"volume":1,"ktx2":"v.ktx2"}]}]}"#;
        let manifest = LevelManifest::read(text.as_bytes()).expect("a manifest");
        let [layer] = &manifest.layers[..] else {
            panic!("{:?}", manifest.layers);
        };
        assert_eq!((&*layer.name, layer.kind), ("bulb", LayerKind::Lamp));
        assert_eq!(layer.reflection_probes[0].diffuse, "d.ktx2");
        assert_eq!(layer.irradiance_volumes[0].volume, 1);
    }

    #[test]
    fn only_manifests_of_this_version_are_read() {
        let text = |version: u32| {
            format!(
                r#"{{"format":"sunroom-lightmaps","version":{version},"light":"all","samples":3,
                "lightmaps":[{{"exr":"a.exr","ktx2":"a.ktx2","width":8,"height":8}}]}}"#
            )
        };
        let manifest = LevelManifest::read(text(1).as_bytes()).expect("a manifest");
        assert!(manifest.has_direct_light() && manifest.layers.is_empty());
        assert_eq!(manifest.lumens_per_watt(), 1.0);
        let in_units = text(1).replace(r#""light":"#, r#""light_units":"candela and lux","light":"#);
        let manifest = LevelManifest::read(in_units.as_bytes()).expect("a manifest");
        assert_eq!(manifest.lumens_per_watt(), 683.0);
        assert_eq!(manifest.lightmaps[0].ktx2, "a.ktx2");
        assert!(matches!(
            LevelManifest::read(text(2).as_bytes()),
            Err(ManifestError::Version(_))
        ));
        assert!(matches!(LevelManifest::read(b"{}"), Err(ManifestError::Json(_))));
    }
}
