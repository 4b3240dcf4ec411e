//! Files that become data: meshes and scenes, each asset beside its loader.

pub mod scene_asset;
pub mod triangle_mesh;

use bevy::asset::AssetLoadError;

pub use scene_asset::{SceneAsset, SceneDefines, SceneLoader};
pub use triangle_mesh::{MeshHandle, MeshLoader, TriangleMesh};

/// The cause of a failed load, without what the asset server wraps around it.
pub fn cause(error: &AssetLoadError) -> String {
    match error {
        AssetLoadError::AssetLoaderError(error) => error.error().to_string().trim().to_owned(),
        AssetLoadError::AssetReaderError(bevy::asset::io::AssetReaderError::NotFound(_)) => "no such file".to_owned(),
        AssetLoadError::AssetReaderError(bevy::asset::io::AssetReaderError::Io(error)) => error.to_string(),
        other => other.to_string(),
    }
}
