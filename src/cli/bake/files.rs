//! The files of a bake.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use sunroom::bake::finish::LightmapPicture;
use sunroom::bake::ktx2;
use sunroom::bake::level::BakeLevel;
use sunroom::bake::manifest::{BakedLight, LightmapFiles, Manifest, ReflectionFiles, VolumeFiles};
use sunroom::color::Rgb;
use sunroom::files::{LARGEST_DATA, check_writable, read_text, write_atomically};
use sunroom::gltf::write::GltfWriter;
use sunroom::render::image_io::{FileOptions, write_layered};
use sunroom::render::layered_image::LayeredImage;

use super::probes::Probes;
use crate::cli::report::Failure;

const LEVEL: &str = "level.glb";
/// It is written last, so that the files that it names are there.
const MANIFEST: &str = "lightmaps.json";
/// How the names of all other files begin.
const OURS: [&str; 3] = ["lightmap-", "reflection-", "irradiance-"];

/// What the manifest says of the light.
pub struct About {
    pub light: BakedLight,
    pub samples: u32,
    pub seed: u32,
    pub denoised: bool,
}

/// Makes the folder, and tries whether files can be written there.
pub fn prepare(folder: &Path) -> Result<(), Failure> {
    let fails = |error| format!("cannot write to {}: {error}", folder.display());
    if folder.is_file() {
        return Err(format!("{} is a file: a bake needs a folder", folder.display()).into());
    }
    fs::create_dir_all(folder).map_err(fails)?;
    Ok(check_writable(&folder.join(MANIFEST)).map_err(fails)?)
}

/// The files in the folder that a bake may replace.
pub fn replaceable(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let is_ours = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name == LEVEL || name == MANIFEST || OURS.iter().any(|ours| name.starts_with(ours))
    };
    entries.map(|entry| entry.path()).filter(is_ours).collect()
}

/// Writes all files, each in one step.
pub fn write(
    folder: &Path,
    writer: GltfWriter,
    level: &BakeLevel,
    pictures: &[LightmapPicture],
    probes: &Probes,
    about: &About,
) -> Result<(), Failure> {
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        write_atomically(&path, bytes).map_err(|error| format!("cannot write {}: {error}", path.display()))
    };
    write(LEVEL, &writer.binary()?)?;
    let mut lightmaps = Vec::new();
    for (number, picture) in pictures.iter().enumerate() {
        let files = LightmapFiles {
            exr: format!("lightmap-{number}.exr"),
            ktx2: format!("lightmap-{number}.ktx2"),
            width: picture.size.x,
            height: picture.size.y,
        };
        let white: Vec<Rgb> = picture
            .irradiance
            .iter()
            .map(|light| *light / std::f32::consts::PI)
            .collect();
        let mut image = LayeredImage::new(files.width, files.height);
        image.add_rgb("", &white);
        write_layered(&folder.join(&files.exr), &image, &FileOptions::default())?;
        write(&files.ktx2, &ktx2::picture(picture.size, white))?;
        lightmaps.push(files);
    }
    let mut reflection_probes = Vec::new();
    for (number, probe) in probes.reflections.iter().enumerate() {
        let files = ReflectionFiles {
            name: probe.name.clone(),
            place: (&probe.world_from_box).into(),
            parallax: probe.parallax,
            specular: format!("reflection-{number}-specular.ktx2"),
            diffuse: format!("reflection-{number}-diffuse.ktx2"),
        };
        write(&files.specular, &ktx2::cube(&probe.pictures.specular))?;
        write(
            &files.diffuse,
            &ktx2::cube(std::slice::from_ref(&probe.pictures.diffuse)),
        )?;
        reflection_probes.push(files);
    }
    let mut irradiance_volumes = Vec::new();
    for (number, volume) in probes.volumes.iter().enumerate() {
        let files = VolumeFiles {
            name: volume.name.clone(),
            place: (&volume.grid.world_from_box).into(),
            points: volume.grid.points.to_array(),
            samples: volume.samples,
            ktx2: format!("irradiance-{number}.ktx2"),
        };
        write(&files.ktx2, &ktx2::volume(volume.size, volume.texels.iter().copied()))?;
        irradiance_volumes.push(files);
    }
    let of_lightmaps = lightmaps.iter().flat_map(|files| [&files.exr, &files.ktx2]);
    let of_reflections = reflection_probes
        .iter()
        .flat_map(|files| [&files.specular, &files.diffuse]);
    let of_volumes = irradiance_volumes.iter().map(|files| &files.ktx2);
    let kept: HashSet<&String> = of_lightmaps.chain(of_reflections).chain(of_volumes).collect();
    let mut outdated = files_of(folder);
    outdated.retain(|name| !kept.contains(name));
    let manifest = Manifest {
        format: Manifest::FORMAT,
        version: Manifest::VERSION,
        generator: Manifest::GENERATOR,
        level: LEVEL.to_owned(),
        coordinates: Manifest::COORDINATES,
        quantity: Manifest::QUANTITY,
        light: about.light,
        texels_per_unit: level.texels_per_unit,
        samples: about.samples,
        seed: about.seed,
        denoised: about.denoised,
        lightmaps,
        nodes: level.nodes.clone(),
        reflection_probes,
        irradiance_volumes,
    };
    write(MANIFEST, &manifest.text()?)?;
    // What is there no longer needs no removal.
    outdated
        .iter()
        .for_each(|name| drop(fs::remove_file(folder.join(name))));
    Ok(())
}

/// The names of the lightmaps and probes of the bake that is in the folder.
fn files_of(folder: &Path) -> Vec<String> {
    let text = read_text(&folder.join(MANIFEST), LARGEST_DATA).unwrap_or_default();
    let manifest: Value = serde_json::from_str(&text).unwrap_or_default();
    if manifest["format"] != Manifest::FORMAT {
        return Vec::new();
    }
    let lists = ["lightmaps", "reflection_probes", "irradiance_volumes"];
    let files = lists
        .iter()
        .flat_map(|list| manifest[list].as_array().into_iter().flatten());
    let names = files.flat_map(|files| ["exr", "ktx2", "specular", "diffuse"].map(|kind| &files[kind]));
    let is_ours = |name: &&str| OURS.iter().any(|ours| name.starts_with(ours)) && !name.contains(['/', '\\']);
    names
        .filter_map(Value::as_str)
        .filter(is_ours)
        .map(str::to_owned)
        .collect()
}
