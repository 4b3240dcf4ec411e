//! The outputs of commands: image files, standard output, and a temporary file for a picture that no output could take.

use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use bevy::prelude::World;
use sunroom::files::{SameFiles, check_writable, is_same_file, recorded_reads};
use sunroom::layer::Layer;
use sunroom::render::image_io::{
    ExrCompression, FileFormat, FileOptions, ImageIoError, encode_layered, write_layered, write_to_temporary_folder,
};
use sunroom::render::layered_image::LayeredImage;
use sunroom::scene::IntegratorSettings;
use sunroom::scene::export::ExportError;

use super::report::{self, Failure};

/// The input of `sunroom merge` in words, for [`check_inputs_stay`].
pub const PART: &str = "one of the parts";

/// Whether this is `-`, standard output.
pub fn is_stdout(path: &Path) -> bool {
    path == Path::new("-")
}

/// Whether this file is among the outputs.
pub fn has_file(outputs: &[PathBuf], path: &Path) -> bool {
    outputs
        .iter()
        .any(|output| !is_stdout(output) && is_same_file(output, path))
}

/// Refuses two outputs with the same file.
pub fn check_distinct(outputs: &[PathBuf]) -> Result<(), String> {
    for (number, path) in outputs.iter().enumerate() {
        if outputs[..number].iter().any(|before| is_same_file(before, path)) {
            return Err(format!("{}: this output is named twice", path.display()));
        }
    }
    Ok(())
}

/// Refuses an output that is an input file, which would be lost. `what` describes the inputs, such as `one of the
/// parts`.
pub fn check_inputs_stay(outputs: &[PathBuf], inputs: &[PathBuf], what: &str) -> Result<(), String> {
    match outputs.iter().find(|output| has_file(inputs, output)) {
        Some(output) => {
            let output = output.display();
            Err(format!(
                "{output}: this output is {what}, which is not replaced: name another file"
            ))
        }
        None => Ok(()),
    }
}

/// Refuses an output that is a file of the scene. Call it once the scene is loaded.
pub fn check_scene_stays(outputs: impl IntoIterator<Item = impl AsRef<Path>>) -> Result<(), ExportError> {
    let files = SameFiles::of(recorded_reads());
    let is_lost = |path: &Path| !is_stdout(path) && files.has(path);
    match outputs.into_iter().find(|output| is_lost(output.as_ref())) {
        Some(output) => {
            let path = output.as_ref().to_owned();
            Err(ExportError::InUse { path })
        }
        None => Ok(()),
    }
}

/// Tests the outputs of a picture before it is rendered, and refuses two with the same file. A disk that becomes full
/// cannot be foreseen.
pub fn check_pictures(outputs: &[PathBuf]) -> Result<(), Failure> {
    check_distinct(outputs).map_err(Failure::Usage)?;
    for path in outputs.iter().filter(|path| !is_stdout(path)) {
        FileFormat::from_path(path).map_err(|error| Failure::Usage(error.to_string()))?;
        check_writable(path).map_err(|source| ImageIoError::Write {
            path: path.clone(),
            source,
        })?;
    }
    Ok(())
}

/// An error if the compression would damage a layer, before anything is rendered.
pub fn check_compression(world: &World, compression: ExrCompression, outputs: &[PathBuf]) -> Result<(), Failure> {
    let layers = world.resource::<IntegratorSettings>().layers;
    if !outputs.iter().any(|path| is_exr(path)) {
        return Ok(());
    }
    let is_damaged = |layer: &Layer| match layer {
        Layer::CryptoObject | Layer::CryptoMaterial => !compression.keeps_floats(),
        // Integers are stored without loss.
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

/// Tests whether a text can be written to this file.
pub fn check_text(path: &Path) -> Result<(), String> {
    check_writable(path).map_err(|error| format!("cannot write {}: {error}", path.display()))
}

/// Writes the picture to all outputs and reports those that fail. If all fail, the picture is written to a temporary
/// file, which is reported too. Returns the outputs that were written.
pub fn write_pictures<'o>(outputs: &'o [PathBuf], image: &LayeredImage, options: &FileOptions) -> Vec<&'o Path> {
    let written = write_each(outputs, |path| write_picture(path, image, options));
    if written.is_empty() {
        keep_elsewhere(image);
    }
    written
}

/// Writes to each output, and reports those that fail. Returns the others.
pub fn write_each(outputs: &[PathBuf], write: impl Fn(&Path) -> Result<(), ImageIoError>) -> Vec<&Path> {
    let mut written = Vec::new();
    for path in outputs {
        match write(path) {
            Ok(()) => written.push(path.as_path()),
            Err(error) => drop(report::error(error)),
        }
    }
    written
}

/// Whether the file has the extension of EXR.
pub fn is_exr(path: &Path) -> bool {
    FileFormat::from_path(path).is_ok_and(|format| format == FileFormat::Exr)
}

/// Writes a picture to a temporary file, and reports its path.
pub fn keep_elsewhere(image: &LayeredImage) {
    match write_to_temporary_folder(image) {
        Ok(place) => report::line(format_args!("the picture is kept in {}", place.display())),
        Err(error) => report::line(format_args!("the picture could not be kept elsewhere: {error}")),
    }
}

/// The names of the files among these outputs, for a message.
pub fn names_of_files(outputs: &[&Path]) -> String {
    let files = outputs.iter().filter(|path| !is_stdout(path));
    files
        .map(|path| path.display().to_string())
        .collect::<Vec<_>>()
        .join(", ")
}

/// Reports the files with the picture.
pub fn report_written(written: &[&Path]) {
    let files = names_of_files(written);
    if !files.is_empty() {
        report::line(format_args!("the picture is in {files}"));
    }
}

/// Reports the outputs whose format has no layers.
pub fn report_without_layers(outputs: &[PathBuf]) {
    let without: Vec<String> = outputs
        .iter()
        .filter(|path| !is_exr(path))
        .map(|path| path.display().to_string())
        .collect();
    if !without.is_empty() {
        let (names, have) = (without.join(", "), if without.len() == 1 { "has" } else { "have" });
        report::line(format_args!("warning: {names} {have} no layers: only EXR files have"));
    }
}

/// Writes a picture to a file, or as PNG to standard output.
pub fn write_picture(path: &Path, image: &LayeredImage, options: &FileOptions) -> Result<(), ImageIoError> {
    if !is_stdout(path) {
        return write_layered(path, image, options);
    }
    let bytes = encode_layered(image, FileFormat::Png, options)?;
    // If the reader of a pipe is gone, it does not get the picture.
    let mut output = io::stdout().lock();
    let written = output.write_all(&bytes).and_then(|()| output.flush());
    written.map_err(|source| ImageIoError::Write {
        path: "standard output".into(),
        source,
    })
}

/// Prints a text to standard output. A closed pipe is no error.
pub fn print(text: &[u8]) -> io::Result<()> {
    let mut output = io::stdout().lock();
    match output.write_all(text).and_then(|()| output.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        result => result,
    }
}
