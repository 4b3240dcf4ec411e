//! The files of a bake.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use glam::{UVec2, UVec3};
use serde_json::Value;

use super::blueprint::{Baked, Blueprint};
use super::error::BakeError;
use super::finish::{LightmapPicture, add};
use super::ktx2;
use super::layers::{Layer, LayerKind};
use super::manifest::{
    LayerFiles, LightmapFiles, LightmapLayer, Manifest, ReflectionFiles, ReflectionLayer, VolumeFiles, VolumeLayer,
};
use super::prefilter::Prefiltered;
use super::probes::{ProbeKind, ProbePicture};
use crate::color::Rgb;
use crate::files::{FileSet, LARGEST_DATA, WriteError, check_writable, checksum, finish_set, read, read_text};
use crate::render::image_io::{FileFormat, FileOptions, encode_layered};
use crate::render::layered_image::LayeredImage;

const LEVEL: &str = "level.glb";
/// The manifest, which names the other files.
const MANIFEST: &str = "lightmaps.json";
/// The size limit of the manifest, in bytes: enough for a million nodes.
const LARGEST_MANIFEST: u64 = 256 << 20;
/// The prefixes of the names of all other files.
const OURS: [&str; 3] = ["lightmap-", "reflection-", "irradiance-"];

/// The output folder of a bake. When dropped, it removes the folders that it has made if they are empty.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// The folders that were made, innermost first.
    made: Vec<PathBuf>,
}

impl OutputFolder {
    /// Makes the folder, and tests whether files can be written there. The error is a sentence.
    pub fn prepare(folder: &Path) -> Result<Self, String> {
        let fails = |error| format!("cannot write to {}: {error}", folder.display());
        if folder.is_file() {
            return Err(format!("{} is a file: a bake needs a folder", folder.display()));
        }
        let above = folder.ancestors().filter(|above| !above.as_os_str().is_empty());
        let prepared = Self {
            path: folder.to_owned(),
            made: above.take_while(|above| !above.exists()).map(Path::to_owned).collect(),
        };
        fs::create_dir_all(folder).map_err(fails)?;
        check_writable(&folder.join(MANIFEST)).map_err(fails)?;
        // If the set cannot be finished, this bake replaces it.
        let _ = finish_set(&folder.join(MANIFEST));
        Ok(prepared)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Drop for OutputFolder {
    fn drop(&mut self) {
        for folder in &self.made {
            // This fails if the folder is not empty.
            if fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
}

/// Whether a bake may replace a file of this name in its output folder.
pub fn is_name_of_bake(name: &str) -> bool {
    name == LEVEL || name == MANIFEST || OURS.iter().any(|ours| name.starts_with(ours))
}

/// The files in the folder that a bake may replace.
pub fn replaceable(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let is_ours = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default();
        is_name_of_bake(&name.to_string_lossy())
    };
    entries.map(|entry| entry.path()).filter(is_ours).collect()
}

/// The amount of light in a bake.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Content {
    /// The number of samples of each texel of a lightmap.
    pub samples: u32,
    /// The number of finished probes.
    pub probes: usize,
}

impl Content {
    /// The content of the bake written into the folder; None if there is none or a file is missing.
    pub fn of_folder(folder: &Path) -> Option<Self> {
        let manifest = manifest_of(folder).filter(|manifest| are_of_one_bake(folder, manifest))?;
        let probes = |list: &str| manifest[list].as_array().map_or(0, Vec::len);
        Some(Self {
            samples: manifest["samples"].as_u64()?.try_into().ok()?,
            probes: probes("reflection_probes") + probes("irradiance_volumes"),
        })
    }

    /// Whether a bake that is ended early may replace a bake with the content `there`: it needs more samples and at
    /// least as many probes, so that no work is lost silently.
    pub fn may_replace(&self, there: &Self) -> bool {
        self.samples > there.samples && self.probes >= there.probes
    }
}

impl fmt::Display for Content {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        let counted = |number: usize, what: &str| format!("{number} {what}{}", if number == 1 { "" } else { "s" });
        let samples = counted(self.samples as usize, "sample");
        write!(formatter, "{samples} per texel and {}", counted(self.probes, "probe"))
    }
}

/// The files of a bake, which replace the files of the previous bake in one step.
struct Files<'a> {
    folder: &'a Path,
    set: FileSet,
    /// The checksums of the files so far, for the manifest.
    sums: BTreeMap<String, String>,
}

impl Files<'_> {
    fn write(&mut self, name: &str, bytes: &[u8]) -> Result<(), BakeError> {
        self.set.add(&self.folder.join(name), bytes)?;
        self.sums.insert(name.to_owned(), checksum(bytes));
        Ok(())
    }

    /// Writes a lightmap, as the radiance of white diffuse surfaces. `name` has no extension.
    fn write_lightmap(&mut self, name: &str, size: UVec2, white: Vec<Rgb>) -> Result<[String; 2], BakeError> {
        let [exr, ktx2] = ["exr", "ktx2"].map(|extension| format!("{name}.{extension}"));
        let mut image = LayeredImage::new(size.x, size.y);
        image.add_rgb("", &white);
        let content = encode_layered(&image, FileFormat::Exr, &FileOptions::default());
        let content = content.map_err(|error| BakeError::Write {
            path: self.folder.join(&exr),
            reason: error.to_string(),
        })?;
        self.write(&exr, &content)?;
        self.write(&ktx2, &ktx2::picture(size, white))?;
        Ok([exr, ktx2])
    }

    /// Writes a lightmap and its layers.
    fn write_lightmaps(&mut self, baked: &Baked, layers: &mut [LayerFiles]) -> Result<Vec<LightmapFiles>, BakeError> {
        let mut files = Vec::new();
        for (lightmap, picture) in baked.lightmaps.iter().enumerate() {
            let mut whole = white(picture);
            let parts = baked.lightmap_layers.get(lightmap).into_iter().flatten();
            for (number, (layer, picture)) in parts.enumerate() {
                let part = white(picture);
                // The sum of what the files hold, which is not that of irradiance to the last bit.
                if number == 0 {
                    whole.fill(Rgb::ZERO);
                }
                add(&mut whole, &part);
                let name = format!("lightmap-{lightmap}-layer-{layer}");
                let [exr, ktx2] = self.write_lightmap(&name, picture.size, part)?;
                let layers = &mut layers[*layer].lightmaps;
                layers.push(LightmapLayer { lightmap, exr, ktx2 });
            }
            let [exr, ktx2] = self.write_lightmap(&format!("lightmap-{lightmap}"), picture.size, whole)?;
            files.push(LightmapFiles {
                exr,
                ktx2,
                width: picture.size.x,
                height: picture.size.y,
            });
        }
        Ok(files)
    }

    /// Writes the cubes of a reflection probe, for mirrors and for diffuse surfaces.
    fn write_reflection(&mut self, name: &str, pictures: &Prefiltered) -> Result<[String; 2], BakeError> {
        let [specular, diffuse] = ["specular", "diffuse"].map(|kind| format!("{name}-{kind}.ktx2"));
        self.write(&specular, &ktx2::cube(&pictures.specular))?;
        self.write(&diffuse, &ktx2::cube(std::slice::from_ref(&pictures.diffuse)))?;
        Ok([specular, diffuse])
    }

    /// Writes the texture of an irradiance volume.
    fn write_volume(&mut self, name: &str, size: UVec3, texels: &[Rgb]) -> Result<String, BakeError> {
        let ktx2 = format!("{name}.ktx2");
        self.write(&ktx2, &ktx2::volume(size, texels.iter().copied()))?;
        Ok(ktx2)
    }

    /// Writes the probes and their layers.
    fn write_probes(
        &mut self,
        blueprint: &Blueprint,
        baked: &Baked,
        layers: &mut [LayerFiles],
    ) -> Result<(Vec<ReflectionFiles>, Vec<VolumeFiles>), BakeError> {
        let (mut reflections, mut volumes) = (Vec::new(), Vec::new());
        let probes = blueprint.probes.iter().zip(&baked.probes).enumerate();
        for (index, (probe, picture)) in probes {
            let (name, place) = (probe.name.clone(), (&probe.world_from_box).into());
            let (number, stem) = match probe.kind {
                ProbeKind::Reflection { .. } => (reflections.len(), format!("reflection-{}", reflections.len())),
                ProbeKind::Volume { .. } => (volumes.len(), format!("irradiance-{}", volumes.len())),
            };
            for (layer, picture) in baked.probe_layers.get(index).into_iter().flatten() {
                let stem = format!("{stem}-layer-{layer}");
                let files = &mut layers[*layer];
                match picture {
                    ProbePicture::Reflection(pictures) => {
                        let [specular, diffuse] = self.write_reflection(&stem, pictures)?;
                        files.reflection_probes.push(ReflectionLayer {
                            probe: number,
                            specular,
                            diffuse,
                        });
                    }
                    ProbePicture::Volume { size, texels, .. } => {
                        let ktx2 = self.write_volume(&stem, *size, texels)?;
                        files.irradiance_volumes.push(VolumeLayer { volume: number, ktx2 });
                    }
                }
            }
            match (probe.kind, picture) {
                (ProbeKind::Reflection { parallax, .. }, Some(ProbePicture::Reflection(pictures))) => {
                    let [specular, diffuse] = self.write_reflection(&stem, pictures)?;
                    reflections.push(ReflectionFiles {
                        name,
                        place,
                        parallax,
                        specular,
                        diffuse,
                    });
                }
                (ProbeKind::Volume { points }, Some(ProbePicture::Volume { samples, size, texels })) => {
                    volumes.push(VolumeFiles {
                        name,
                        place,
                        points: points.to_array(),
                        samples: *samples,
                        ktx2: self.write_volume(&stem, *size, texels)?,
                    });
                }
                _ => {}
            }
        }
        Ok((reflections, volumes))
    }
}

/// The radiance of white diffuse surfaces.
fn white(picture: &LightmapPicture) -> Vec<Rgb> {
    let texels = picture.irradiance.iter();
    texels.map(|light| *light / std::f32::consts::PI).collect()
}

impl From<WriteError> for BakeError {
    fn from(WriteError { path, source }: WriteError) -> Self {
        let reason = source.to_string();
        Self::Write { path, reason }
    }
}

/// Replaces the files of the previous bake by the files of this one, and removes the files no longer needed.
pub fn write(folder: &Path, blueprint: &Blueprint, baked: &Baked) -> Result<(), BakeError> {
    let mut target = Files {
        folder,
        set: FileSet::new(&folder.join(MANIFEST)),
        sums: BTreeMap::new(),
    };
    target.write(LEVEL, &blueprint.level)?;
    let layer = |layer: &Layer| LayerFiles {
        name: layer.name.clone(),
        kind: layer.kind,
        factor: [1.0; 3],
        nodes: layer.nodes.clone(),
        lightmaps: Vec::new(),
        reflection_probes: Vec::new(),
        irradiance_volumes: Vec::new(),
    };
    let mut layers: Vec<LayerFiles> = blueprint.division.layers.iter().map(layer).collect();
    let lightmaps = target.write_lightmaps(baked, &mut layers)?;
    let (reflection_probes, irradiance_volumes) = target.write_probes(blueprint, baked, &mut layers)?;
    for name in files_of(folder) {
        if !target.sums.contains_key(&name) {
            target.set.remove(&folder.join(name));
        }
    }
    // A rest without light is no layer.
    layers.pop_if(|rest| rest.kind == LayerKind::Rest && !rest.has_files());
    let manifest = Manifest {
        format: Manifest::FORMAT,
        version: Manifest::VERSION,
        generator: Manifest::GENERATOR,
        level: LEVEL.to_owned(),
        coordinates: Manifest::COORDINATES,
        quantity: Manifest::QUANTITY,
        light: blueprint.light,
        light_units: Manifest::LIGHT_UNITS,
        texels_per_unit: blueprint.texels_per_unit,
        samples: baked.samples,
        seed: blueprint.seed,
        denoised: blueprint.denoise,
        lightmaps,
        nodes: blueprint.nodes.clone(),
        reflection_probes,
        irradiance_volumes,
        layers,
        crc32: std::mem::take(&mut target.sums),
    };
    let text = manifest.text().map_err(|error| BakeError::Write {
        path: folder.join(MANIFEST),
        reason: error.to_string(),
    })?;
    target.write(MANIFEST, &text)?;
    Ok(target.set.replace()?)
}

/// The manifest of the bake in the folder.
fn manifest_of(folder: &Path) -> Option<Value> {
    let text = read_text(&folder.join(MANIFEST), LARGEST_MANIFEST).ok()?;
    let manifest: Value = serde_json::from_str(&text).ok()?;
    (manifest["format"] == Manifest::FORMAT).then_some(manifest)
}

/// Whether the checksums of the manifest match the files beside it. Manifests of older versions have no checksums.
fn are_of_one_bake(folder: &Path, manifest: &Value) -> bool {
    let mut sums = manifest["crc32"].as_object().into_iter().flatten();
    sums.all(|(name, sum)| {
        is_name_of_bake(name)
            && !name.contains(['/', '\\'])
            && read(&folder.join(name), LARGEST_DATA).is_ok_and(|bytes| *sum == checksum(&bytes))
    })
}

/// The names of the lightmaps and probes of the bake in the folder.
fn files_of(folder: &Path) -> Vec<String> {
    let Some(manifest) = manifest_of(folder) else {
        return Vec::new();
    };
    let lists = ["lightmaps", "reflection_probes", "irradiance_volumes"];
    let files = lists
        .iter()
        .flat_map(|list| manifest[list].as_array().into_iter().flatten());
    let names = files.flat_map(|files| ["exr", "ktx2", "specular", "diffuse"].map(|kind| files[kind].as_str()));
    // Those of layers are named with their checksums.
    let sums = manifest["crc32"].as_object().into_iter().flatten();
    let names = names.flatten().chain(sums.map(|(name, _)| name.as_str()));
    let is_ours = |name: &&str| OURS.iter().any(|ours| name.starts_with(ours)) && !name.contains(['/', '\\']);
    names.filter(is_ours).map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_replaced_early_by_more_light_alone() {
        let content = |samples, probes| Content { samples, probes };
        let there = content(64, 2);
        for (samples, probes, may) in [
            (65, 2, true),
            (65, 3, true),
            (64, 2, false),
            (3, 2, false),
            (65, 1, false),
        ] {
            assert_eq!(content(samples, probes).may_replace(&there), may, "{samples} {probes}");
        }
        assert_eq!(there.to_string(), "64 samples per texel and 2 probes");
        assert_eq!(content(1, 0).to_string(), "1 sample per texel and 0 probes");
    }

    #[test]
    fn the_content_of_a_folder_is_that_of_its_manifest() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        assert_eq!(Content::of_folder(folder.path()), None);
        std::fs::write(folder.path().join(LEVEL), "").expect("a writable folder");
        for (text, expected) in [
            (
                r#"{"format": "sunroom-lightmaps", "samples": 7, "reflection_probes": [{}], "irradiance_volumes": [{}, {}]}"#,
                Some((7, 3)),
            ),
            (r#"{"format": "sunroom-lightmaps", "samples": -1}"#, None),
            // The checksum of no bytes.
            (
                r#"{"format": "sunroom-lightmaps", "samples": 7, "crc32": {"level.glb": "00000000"}}"#,
                Some((7, 0)),
            ),
            (
                r#"{"format": "sunroom-lightmaps", "samples": 7, "crc32": {"level.glb": "00000001"}}"#,
                None,
            ),
            (
                r#"{"format": "sunroom-lightmaps", "samples": 7, "crc32": {"lightmap-0.exr": "00000000"}}"#,
                None,
            ),
            (r#"{"format": "another", "samples": 7}"#, None),
            ("[", None),
        ] {
            std::fs::write(folder.path().join(MANIFEST), text).expect("a writable folder");
            let found = Content::of_folder(folder.path());
            assert_eq!(
                found.map(|content| (content.samples, content.probes)),
                expected,
                "{text}"
            );
        }
    }
}
