//! The reasons why a scene cannot be exported.

use std::path::PathBuf;

use crate::gltf::write::GltfWriteError;

/// The reason why a scene is not exported.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum ExportError {
    #[error(transparent)]
    Write(#[from] GltfWriteError),
    #[error("shape `{name}`: {source}")]
    Shape { name: String, source: GltfWriteError },
    #[error("{}: {source}", path.display())]
    File { path: PathBuf, source: std::io::Error },
    #[error("{}: a glTF file ends with .glb (one file) or .gltf (with others beside it)", path.display())]
    Ending { path: PathBuf },
    #[error("{}: the scene is made of this file; choose another name", path.display())]
    InUse { path: PathBuf },
}
