//! A triangle mesh loaded from an OBJ, PLY or serialized file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;

use crate::document::paths::settle;
use crate::geometry::mesh::MeshData;
use crate::geometry::mesh_file::{LoadedMesh, MeshError};
use crate::geometry::serialized::{self, SerializedFile};
use crate::geometry::{obj, ply};

/// A mesh in its own space; its texture coordinates are upside down already where the format's default is to flip them. `data` is a new `Arc` after each reload.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct TriangleMesh {
    pub data: Arc<MeshData>,
    /// What of the file was left out or mended, one sentence each.
    pub warnings: Vec<String>,
    /// The other files it was read from (material libraries), absolute, whether they exist or not.
    pub dependencies: Vec<PathBuf>,
}

/// The loaded file of a shape whose kind is `Mesh`. Follows the shape's path: set when the path is, removed when the shape is no mesh.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
pub struct MeshHandle(pub Handle<TriangleMesh>);

/// Reads OBJ, PLY and serialized files; which it is, the content says. The second and later shapes of a file are assets labelled with
/// their numbers, from 1.
#[derive(Default, TypePath)]
pub struct MeshLoader;

#[derive(Debug, thiserror::Error)]
pub enum MeshLoadError {
    #[error(transparent)]
    Io(#[from] std::io::Error),
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl AssetLoader for MeshLoader {
    type Asset = TriangleMesh;
    type Settings = ();
    type Error = MeshLoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<TriangleMesh, MeshLoadError> {
        let path = context.path().path().to_owned();
        let mut bytes = Vec::new();
        if path.is_absolute() {
            // The reader passes a file's bytes from thread to thread in small pieces, which takes longer than to understand them.
            bytes = std::fs::read(&path)?;
        } else {
            reader.read_to_end(&mut bytes).await?;
        }
        if serialized::is_serialized(&bytes) {
            let file = SerializedFile::open(&bytes)?;
            for shape in 1..file.count() {
                context.add_labeled_asset(shape.to_string(), TriangleMesh::from(file.load(shape)?));
            }
            return Ok(file.load(0)?.into());
        }
        read_mesh(&bytes, &path)
    }

    fn extensions(&self) -> &[&str] {
        &["obj", "ply", "serialized"]
    }
}

impl From<LoadedMesh> for TriangleMesh {
    fn from(loaded: LoadedMesh) -> Self {
        Self {
            data: Arc::new(loaded.mesh),
            warnings: loaded.warnings,
            dependencies: Vec::new(),
        }
    }
}

/// Of an OBJ or PLY file. `path`: of the file the bytes are from; material libraries are looked for beside it, and the names of their
/// pictures become absolute.
pub fn read_mesh(bytes: &[u8], path: &Path) -> Result<TriangleMesh, MeshLoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut dependencies = Vec::new();
    let mut loaded = if bytes.starts_with(b"ply") {
        ply::load_ply(bytes)?
    } else {
        let mut loaded = obj::load_obj(bytes, &mut |name| {
            let library = folder.join(name);
            dependencies.push(library.clone());
            std::fs::read(&library)
        })?;
        loaded.mesh.flip_tex_coords();
        loaded
    };
    for map in loaded
        .mesh
        .materials
        .iter_mut()
        .flat_map(|material| material.maps.iter_mut())
    {
        map.file = settle(&folder.join(&map.file));
    }
    Ok(TriangleMesh {
        dependencies,
        ..loaded.into()
    })
}
