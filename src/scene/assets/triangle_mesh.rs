//! A triangle mesh loaded from an OBJ or PLY file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;

use crate::geometry::mesh::MeshData;
use crate::geometry::mesh_file::MeshError;
use crate::geometry::{obj, ply};

/// A mesh in its own space. `data` is a new `Arc` after each reload.
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

/// Reads OBJ and PLY; which it is, the content says.
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
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let path = context.path().path().to_owned();
        read_mesh(&bytes, &path)
    }

    fn extensions(&self) -> &[&str] {
        &["obj", "ply"]
    }
}

/// `path`: of the file the bytes are from; material libraries are looked for beside it.
pub fn read_mesh(bytes: &[u8], path: &Path) -> Result<TriangleMesh, MeshLoadError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut dependencies = Vec::new();
    let loaded = if bytes.starts_with(b"ply") {
        ply::load_ply(bytes)?
    } else {
        obj::load_obj(bytes, &mut |name| {
            let library = folder.join(name);
            dependencies.push(library.clone());
            std::fs::read(&library)
        })?
    };
    Ok(TriangleMesh {
        data: Arc::new(loaded.mesh),
        warnings: loaded.warnings,
        dependencies,
    })
}
