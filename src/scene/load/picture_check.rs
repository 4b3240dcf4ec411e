//! Checks the picture files of a scene that is converted without being opened.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::pictures::pictures_of_lights;
use crate::document::{Diagnostics, Severity, Span};
use crate::files::Access;
use crate::scene::assets::texture_map::{TextureMapError, load_picture};
use crate::scene::components::missing::{NOT_THERE, sentence};
use crate::scene::{FileKind, MissingFile, SceneDescription};

/// Reads each picture of the scene and of its meshes' materials; reports unreadable ones, and pixels whose values were
/// changed, where the scene names the picture first. All are warnings: the new file names the picture as well, whatever
/// its state.
pub fn check_pictures(
    scene: &SceneDescription,
    of_meshes: &BTreeSet<PathBuf>,
    access: &Access,
    diagnostics: &mut Diagnostics,
) {
    let lights = scene.shapes.iter().filter_map(|shape| shape.area_light.as_ref());
    let shining = pictures_of_lights(lights, scene.emitters.iter().map(|emitter| &emitter.emitter));
    let mut places: BTreeMap<&Path, Option<Span>> = of_meshes.iter().map(|path| (path.as_path(), None)).collect();
    places.extend(
        scene
            .picture_places
            .iter()
            .map(|(path, span)| (path.as_path(), Some(*span))),
    );
    let mut places: Vec<_> = places.into_iter().collect();
    places.sort_by_key(|(_, span)| span.map(|span| (span.source.0, span.start)));
    for (path, span) in places {
        let what = match load_picture(path, access) {
            Err(TextureMapError::File(error)) if error.is_not_found() => {
                let noted = scene.missing.get(path);
                noted.map_or_else(|| NOT_THERE.to_owned(), MissingFile::what)
            }
            Err(error) => error.to_string(),
            Ok(picture) => match picture.warning(shining.contains(path)) {
                Some(warning) => warning,
                None => continue,
            },
        };
        let message = sentence(FileKind::Picture, path, &what);
        diagnostics.push(Severity::Warning, span, message, None);
    }
}
