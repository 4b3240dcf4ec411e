//! A triangle mesh loaded from a file.

use std::path::PathBuf;
use std::sync::Arc;

use bevy::prelude::*;

use crate::geometry::mesh::MeshData;

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
