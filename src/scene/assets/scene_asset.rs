//! A scene file as an asset: its description and its diagnostics.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;
use bevy::tasks::IoTaskPool;

use super::gltf_scene::{import, is_gltf, largest};
use super::parts_cache::allow_parts;
use crate::document::source::unreadable;
use crate::document::{self, Diagnostics, Document, Severity, SourceError};
use crate::files::{self, Access};
use crate::scene::SceneDescription;
use crate::scene::read;
use crate::scene::{KeepSource, SceneAccess};

/// A scene file as an asset. A broken file loads as well: the diagnostics have its errors, and the rest is unreliable.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct SceneAsset {
    /// The description of the file, as far as it could be read.
    pub description: Arc<SceneDescription>,
    /// The problems with the file. If there are errors, the description must not be shown.
    pub diagnostics: Arc<Diagnostics>,
}

/// The description of a large scene takes long to drop: the last owner drops it on another thread.
impl Drop for SceneAsset {
    fn drop(&mut self) {
        if Arc::strong_count(&self.description) == 1
            && let Some(pool) = IoTaskPool::try_get()
        {
            let description = std::mem::take(&mut self.description);
            pool.spawn(async move { drop(description) }).detach();
        }
    }
}

/// The values for the `$name`s of scene files, by path. They are shared with the loader, because reloads need them as
/// well.
#[derive(Resource, Clone, Default)]
pub struct SceneDefines(Arc<RwLock<HashMap<PathBuf, Vec<(String, String)>>>>);

impl SceneDefines {
    /// Replaces the values for the scene at `path`, as passed to the loader.
    pub fn set(&self, path: PathBuf, defines: Vec<(String, String)>) {
        self.0
            .write()
            .unwrap_or_else(PoisonError::into_inner)
            .insert(path, defines);
    }

    /// Returns the values for the scene at `path`, none if none were set.
    pub fn get(&self, path: &Path) -> Vec<(String, String)> {
        let all = self.0.read().unwrap_or_else(PoisonError::into_inner);
        all.get(path).cloned().unwrap_or_default()
    }
}

/// Reads scene files with their includes, and glTF files.
#[derive(TypePath)]
pub(crate) struct SceneLoader {
    pub defines: SceneDefines,
    pub access: SceneAccess,
    pub keep_source: KeepSource,
}

impl AssetLoader for SceneLoader {
    type Asset = SceneAsset;
    type Settings = ();
    type Error = std::io::Error;

    async fn load(
        &self,
        _reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<SceneAsset, std::io::Error> {
        let path = context.path().path().to_owned();
        let access = self.access.of_scene(&path);
        files::finish_set_within(&path, &access)?;
        let bytes = access.read(&path, largest(&path))?;
        if is_gltf(&bytes, &path) {
            allow_parts(|folder| self.access.allow(folder));
        }
        Ok(read_scene_within(
            bytes,
            &path,
            &self.defines.get(&path),
            self.access.of_scene(&path),
            self.keep_source.get(),
        ))
    }

    fn extensions(&self) -> &[&str] {
        &["xml", "gltf", "glb"]
    }
}

/// Reads a scene. `path` is the file of the bytes.
pub fn read_scene(bytes: Vec<u8>, path: &Path, defines: &[(String, String)]) -> SceneAsset {
    read_scene_within(bytes, path, defines, Access::everywhere(), true)
}

fn read_scene_within(
    bytes: Vec<u8>,
    path: &Path,
    defines: &[(String, String)],
    access: Access,
    keeps_source: bool,
) -> SceneAsset {
    let mut document = match parse(bytes, path, defines, access) {
        Ok(document) => document,
        Err(error) => return failed(path, &error),
    };
    let description = if keeps_source {
        read::read(&mut document)
    } else {
        read::read_meaning(&mut document)
    };
    if !keeps_source {
        document.diagnostics.shorten_texts(description.places_of_files());
    }
    SceneAsset {
        description: Arc::new(description),
        diagnostics: Arc::new(document.diagnostics),
    }
}

/// Loads a scene file of any format. As for [`document::load`], errors in its content are in the document's
/// diagnostics.
pub fn load_document(path: &Path, defines: &[(String, String)], access: Access) -> Result<Document, SourceError> {
    let read = files::finish_set_within(path, &access).and_then(|()| access.read(path, largest(path)));
    let bytes = read.map_err(|source| unreadable(path, source))?;
    parse(bytes, path, defines, access)
}

fn parse(bytes: Vec<u8>, path: &Path, defines: &[(String, String)], access: Access) -> Result<Document, SourceError> {
    if is_gltf(&bytes, path) {
        return Ok(import(&bytes, path, access));
    }
    let text = document::source::decode(bytes, path)?;
    Ok(document::parse_within(text, path, defines, access))
}

fn failed(path: &Path, error: &SourceError) -> SceneAsset {
    SceneAsset {
        description: Arc::new(SceneDescription {
            path: path.to_owned(),
            ..Default::default()
        }),
        diagnostics: Arc::new(one_error(error.to_string())),
    }
}

/// The diagnostics of a file with a single error.
pub(crate) fn one_error(message: String) -> Diagnostics {
    let mut diagnostics = Diagnostics::default();
    diagnostics.push(Severity::Error, None, message, None);
    diagnostics
}
