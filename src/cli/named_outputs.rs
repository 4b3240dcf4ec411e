//! The files of a picture as far as the scene decides on them: their name where none is given, and whether they can
//! hold its layers.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use sunroom::layer::Layer;
use sunroom::render::image_io::ExrCompression;
use sunroom::scene::{ActiveSensor, Film, IntegratorSettings, PictureFormat};

use super::outputs;
use super::report::Failure;
use super::sequence::SequenceArgs;

/// The picture's file where none is named: beside the scene, with the ending that the film asks for. It never replaces
/// a file, which may be a picture that the scene shows.
pub fn default_output(world: &World, scene: &Path, sequence: &SequenceArgs) -> Result<PathBuf, Failure> {
    let sensor = world.resource::<ActiveSensor>().0;
    let film = sensor.and_then(|sensor| world.get::<Film>(sensor));
    let format = film.and_then(|film| film.storage.file);
    let path = scene.with_extension(format.unwrap_or(PictureFormat::OpenExr).extension());
    let first = sequence.first_outputs(std::slice::from_ref(&path))?;
    outputs::check_pictures(&first)?;
    match first.iter().find(|path| path.exists()) {
        Some(taken) => {
            let taken = taken.display();
            Err(Failure::Usage(format!(
                "{taken} is there already: name a file with `-o`"
            )))
        }
        None => Ok(path),
    }
}

/// An error if the compression would damage a layer, before anything is rendered.
pub fn check_compression(world: &World, compression: ExrCompression, outputs: &[PathBuf]) -> Result<(), Failure> {
    let layers = world.resource::<IntegratorSettings>().layers;
    if !outputs::has_exr(outputs) {
        return Ok(());
    }
    let is_damaged = |layer: &Layer| match layer {
        Layer::CryptoObject | Layer::CryptoMaterial => !compression.keeps_floats(),
        // Whole numbers are kept.
        Layer::ObjectId | Layer::MaterialId => false,
        _ => compression.takes_y_for_luminance() && layer.channels_in_pictures().contains(&"Y"),
    };
    let Some(layer) = layers.iter().find(is_damaged) else {
        return Ok(());
    };
    let (layer, compression) = (layer.name(), compression.name());
    Err(Failure::Usage(format!(
        "the layer `{layer}` would be damaged by the compression `{compression}`: choose one without loss, such as `zip`"
    )))
}
