//! Turns a [`SceneDescription`] back into a document; [`gather`] makes the description from the entities.
//!
//! Unedited parts are written as they were read, unknown parameters included. Materials stay where they were declared:
//! in place, or at the top level with references. The document still has the span of each part that was read, so that
//! it can be written over the old text ([`save()`]); without that it makes a new file ([`write_anew`]).

mod changed;
mod defaults;
mod error;
pub mod gather;
mod parts;
mod past;
pub(in crate::scene) mod patch;
mod portable;
mod portable_medium;
mod portable_volume;
pub(super) mod rebase;
mod save;
pub(crate) mod snapshot;
mod spectra;
pub(in crate::scene) mod steps;
mod writer;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::prelude::World;

pub use self::changed::OnChange;
pub use self::error::SaveError;
use self::parts::Moves;
pub(crate) use self::past::{GivenId, PastFile, TakenId};
pub use self::portable::Extensions;
use self::portable_volume::VolumeFiles;
pub(crate) use self::save::{Following, MOST_ATTEMPTS, Save, Saved, Written, save_over};
pub use self::save::{save, save_with};
pub(in crate::scene) use self::writer::Writer;
pub(in crate::scene) use self::writer::identities;
use crate::document::animation::stand_still;
use crate::document::revision::{Destination, move_files, revise};
use crate::document::{self, Document, SourceFile};
use crate::files::{self, Access, FileSet, LARGEST_DATA};
use crate::scene::AuthoredScene;
use crate::scene::assets::gltf_scene::is_called_gltf;
use crate::scene::assets::without_patterns::without_patterns;
use crate::scene::components::description::SceneDescription;
pub use crate::scene::file::known::KnownTexts;
use crate::scene::file::known::are_as_read;
use crate::scene::read::mesh_search::MeshSearch;
use crate::scene::read::settle;

/// Writes a scene over the text that it was read from: see [`files()`]. All files are replaced in one step.
pub fn save_description(scene: &SceneDescription, path: &Path) -> Result<(), SaveError> {
    let (files, moves) = plan(scene, path)?;
    let mut set = FileSet::new(&settle(path));
    copy_parts(&moves, &mut set)?;
    for (path, text) in files {
        set.add(&path, text)?;
    }
    Ok(set.replace()?)
}

/// The texts to write when a scene is saved at `path`, which is the last of them. Unedited parts are as they were
/// written; edits in an included file are written there if the scene keeps its path.
pub fn files(scene: &SceneDescription, path: &Path) -> Result<Vec<(PathBuf, String)>, SaveError> {
    Ok(plan(scene, path)?.0)
}

fn plan(scene: &SceneDescription, path: &Path) -> Result<(Vec<(PathBuf, String)>, Moves), SaveError> {
    let target = settle(path);
    keep_foreign(scene, &target)?;
    let origin = scene.remains.origin.as_ref();
    let Some(origin) = origin.filter(|origin| !origin.imported) else {
        let (document, moves) = whole(scene, &target);
        let text = document::to_xml(&document)?;
        return Ok((vec![(target, text)], moves));
    };
    let mut document = in_place(scene, &target);
    // Cached parts of opened glTF files and meshes made here are moved to the scene.
    let moves = parts::take_along(
        Arc::make_mut(&mut document.root),
        folder(&settle(&origin.path)),
        &target,
    );
    let files = with_destination(scene, &target, MeshSearch::new, |destination| {
        revise(origin, &document, destination)
    })?;
    Ok((files, moves))
}

/// Writes a scene as one new file, without the comments, includes and `$name`s of the old one, with Mitsuba's plugins
/// where these exist: single triangles and building parts become meshes in files beside it, and for Mitsuba grids of
/// `.vdb` files become `.vol` files, and patterns pictures.
pub fn write_anew(scene: &SceneDescription, path: &Path, extensions: Extensions) -> Result<(), SaveError> {
    let target = settle(path);
    keep_foreign(scene, &target)?;
    let mut set = FileSet::new(path);
    let pictured = match extensions {
        Extensions::Approximate => {
            let origin = scene.remains.origin.as_ref();
            let access = origin.map_or_else(Access::everywhere, |origin| origin.access.clone());
            without_patterns(scene, &target, &access, &mut set)?
        }
        Extensions::Keep => None,
    };
    let scene = pictured.as_ref().unwrap_or(scene);
    let (mut document, moves) = whole(scene, &target);
    if extensions == Extensions::Approximate {
        // Mitsuba has no keys: the values at the shown time stay.
        stand_still(Arc::make_mut(&mut document.root));
    }
    copy_parts(&moves, &mut set)?;
    if extensions == Extensions::Approximate {
        let origin = scene.remains.origin.as_ref();
        let access = origin.map_or_else(Access::everywhere, |origin| origin.access.clone());
        let search = MeshSearch::of_format(folder(&target), &document.search_folders).within(access.clone());
        let find = |name: &str| search.find_file(name, folder(&target));
        VolumeFiles::new(&target, &find, access, &mut set).translate_all(Arc::make_mut(&mut document.root))?;
    }
    // Mitsuba refuses a scene that names a folder that does not exist.
    document.search_folders.retain(|folder| folder.is_dir());
    spectra::as_colors(Arc::make_mut(&mut document.root));
    for (path, text) in portable::translate(Arc::make_mut(&mut document.root), path, extensions) {
        set.add(&path, text)?;
    }
    set.add(path, document::to_xml(&document)?)?;
    Ok(set.replace()?)
}

/// Extensions of other formats, to which a scene must not be written.
const FOREIGN: [&str; 13] = [
    "png",
    "jpg",
    "jpeg",
    "exr",
    "hdr",
    "pfm",
    "obj",
    "ply",
    "serialized",
    "vol",
    "vdb",
    "ies",
    "ldt",
];

/// An error if this would replace a file of another format.
fn keep_foreign(scene: &SceneDescription, target: &Path) -> Result<(), SaveError> {
    let origin = scene.remains.origin.as_ref();
    let is_imported = origin.is_some_and(|origin| origin.imported && settle(&origin.path) == *target);
    let extension = target.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if !is_imported && !is_called_gltf(target) && !FOREIGN.contains(&extension.as_str()) {
        return Ok(());
    }
    Err(SaveError::Foreign {
        path: target.to_owned(),
        proposal: target.with_extension(match target.extension() {
            Some(extension) if extension == "xml" => "native.xml",
            _ => "xml",
        }),
    })
}

fn copy_parts(moves: &Moves, set: &mut FileSet) -> Result<(), SaveError> {
    for (part, place) in moves {
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |source| SaveError::File { path, source }
        };
        let folder = folder(place);
        std::fs::create_dir_all(folder).map_err(failed(folder))?;
        let content = files::read(part, LARGEST_DATA).map_err(std::io::Error::from);
        set.add(place, content.map_err(failed(part))?)?;
    }
    Ok(())
}

/// The document of a scene for writing to `target` as one file; file names are relative to that.
pub fn to_document(scene: &SceneDescription, target: &Path) -> Document {
    whole(scene, &settle(target)).0
}

/// A document for the clipboard: file names are absolute, and no files are moved.
pub(crate) fn to_fragment(scene: &SceneDescription) -> Document {
    in_place(scene, Path::new("/clipboard.xml"))
}

/// The document as from [`to_document`], with the other files to be written.
fn whole(scene: &SceneDescription, target: &Path) -> (Document, Moves) {
    let mut document = in_place(scene, target);
    if let Some(origin) = &scene.remains.origin {
        // Another reader may search in fewer folders than this program.
        with_destination(scene, target, MeshSearch::of_format, |destination| {
            move_files(Arc::make_mut(&mut document.root), origin, destination);
        });
    }
    let moves = parts::take_along(Arc::make_mut(&mut document.root), folder(target), target);
    (document, moves)
}

/// The document of a scene as if it kept its path: file names are relative to the file that they were read from, and
/// others to the scene's folder. `target`: where it will be written.
fn in_place(scene: &SceneDescription, target: &Path) -> Document {
    let root = Writer::new(scene, folder(&home(scene, target))).root();
    Document {
        search_folders: scene.remains.search_folders.clone(),
        time: scene.time,
        ..Document::new(target, root)
    }
}

/// The file from which the scene was read.
pub(in crate::scene) fn home(scene: &SceneDescription, otherwise: &Path) -> PathBuf {
    home_in(&scene.remains, otherwise)
}

/// The file from which the world's scene was read.
pub(in crate::scene) fn home_of(world: &World) -> PathBuf {
    let remains = world.get_resource::<AuthoredScene>();
    remains.map_or_else(PathBuf::new, |remains| home_in(remains, Path::new("")))
}

fn home_in(remains: &AuthoredScene, otherwise: &Path) -> PathBuf {
    let origin = remains.origin.as_ref();
    origin.map_or_else(|| otherwise.to_owned(), |origin| settle(&origin.path))
}

pub(in crate::scene) fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new("/"))
}

/// Calls a function with the destination. `after` makes the search for files when it is read again, given the folder
/// and the `<path>`s.
fn with_destination<T>(
    scene: &SceneDescription,
    target: &Path,
    after: fn(&Path, &[PathBuf]) -> MeshSearch,
    act: impl FnOnce(&Destination) -> T,
) -> T {
    let search_folders = &scene.remains.search_folders;
    let origin = scene.remains.origin.as_ref();
    // The new text must not reveal whether a file exists that the scene may not read.
    let access = origin.map_or_else(Access::everywhere, |origin| origin.access.apart());
    let before = MeshSearch::new(folder(&home(scene, target)), search_folders).within(access.clone());
    let after = after(folder(target), search_folders).within(access);
    let sources = origin.map_or(&[][..], |origin| &origin.diagnostics.sources);
    let is_changed = |source: &SourceFile| !are_as_read(std::slice::from_ref(source));
    let has_changed = |path: &Path| {
        sources
            .iter()
            .any(|source| settle(&source.path) == path && is_changed(source))
    };
    act(&Destination {
        path: target,
        has_changed: &has_changed,
        find_before: &|name, folder| before.find_file(name, folder),
        find_after: &|name, folder| after.find_file(name, folder),
    })
}
