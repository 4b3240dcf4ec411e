//! Files that become data: meshes, pictures and scenes, each asset beside its loader.

pub mod gltf_scene;
pub mod scene_asset;
pub mod texture_map;
pub mod triangle_mesh;

use bevy::asset::AssetLoadError;

pub use scene_asset::{SceneAsset, SceneDefines, SceneLoader};
pub use texture_map::{TextureMap, TextureMapLoader};
pub use triangle_mesh::{MeshHandle, MeshLoader, TriangleMesh};

/// The cause of a failed load, without what the asset server wraps around it.
pub fn cause(error: &AssetLoadError) -> String {
    match error {
        AssetLoadError::AssetLoaderError(error) => error.error().to_string().trim().to_owned(),
        AssetLoadError::AssetReaderError(bevy::asset::io::AssetReaderError::NotFound(_)) => "no such file".to_owned(),
        AssetLoadError::AssetReaderError(bevy::asset::io::AssetReaderError::Io(error)) => error.to_string(),
        AssetLoadError::MissingLabel { label, all_labels, .. } => {
            // The first shape of a file has no label.
            format!("there is no shape {label}: the file has {}", all_labels.len() + 1)
        }
        other => other.to_string(),
    }
}
