//! Checks the volume files of a scene that is converted without being opened.

use std::path::PathBuf;

use crate::document::{Diagnostics, Severity, Span};
use crate::files::Access;
use crate::scene::assets::volume_map::{VolumeMapError, load_volume};
use crate::scene::components::missing::{NOT_THERE, sentence};
use crate::scene::{FileKind, MissingFile, SceneDescription, VolumeFormat};

/// Reads each volume of the scene; reports unreadable and repaired ones where the scene names them first. All are
/// warnings: the new file names the volume as well, whatever its state.
pub fn check_volumes(scene: &SceneDescription, access: &Access, diagnostics: &mut Diagnostics) {
    let mut places: Vec<(&PathBuf, &Span)> = scene.volume_places.iter().collect();
    places.sort_by_key(|(_, span)| (span.source.0, span.start));
    for (asset, span) in places {
        let (path, _) = VolumeFormat::of_asset(asset);
        let what = match load_volume(asset, access) {
            Err(VolumeMapError::File(error)) if error.is_not_found() => {
                let noted = scene.missing.get(path);
                Some(noted.map_or_else(|| NOT_THERE.to_owned(), MissingFile::what))
            }
            Err(error) => Some(error.to_string()),
            Ok(volume) => volume.warning(),
        };
        if let Some(what) = what {
            let message = sentence(FileKind::Volume, path, &what);
            diagnostics.push(Severity::Warning, Some(*span), message, None);
        }
    }
}
