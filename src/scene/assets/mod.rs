//! Assets read from files: meshes, pictures, volumes and scenes, each beside its loader.

pub(crate) mod box_lying;
pub(crate) mod cache_folder;
pub mod file_source;
pub mod gltf_scene;
mod group_copies;
pub(crate) mod lamp_file;
pub(crate) mod mtl_picture;
pub(crate) mod packed_pattern;
pub mod parts_cache;
pub(crate) mod pattern_tile;
pub mod scene_asset;
pub(crate) mod shape_mesh;
pub mod solid_mesh;
pub mod texture_map;
pub mod triangle_mesh;
pub mod volume_map;
pub(crate) mod without_patterns;

use std::error::Error;

use bevy::asset::AssetLoadError;
use bevy::ecs::error::BevyError;

pub use file_source::FileSourcePlugin;
pub(crate) use scene_asset::SceneLoader;
pub use scene_asset::{SceneAsset, SceneDefines};
pub use texture_map::TextureMap;
pub(crate) use texture_map::TextureMapLoader;
pub(crate) use triangle_mesh::MeshLoader;
pub use triangle_mesh::{MeshHandle, MeshShape, TriangleMesh};
pub use volume_map::VolumeMap;
pub(crate) use volume_map::VolumeMapLoader;

use texture_map::TextureMapError;
use triangle_mesh::MeshLoadError;
use volume_map::VolumeMapError;

use crate::files::FileError;
use crate::scene::components::missing::NOT_THERE;

/// The cause of a failed load, without the wrappers of the asset server.
pub(crate) fn cause(error: &AssetLoadError) -> String {
    match error {
        AssetLoadError::AssetLoaderError(error) => message(error.error()),
        error if is_missing(error) => NOT_THERE.to_owned(),
        AssetLoadError::AssetReaderError(bevy::asset::io::AssetReaderError::Io(error)) => error.to_string(),
        other => other.to_string(),
    }
}

/// Whether the error is a missing file.
pub(crate) fn is_missing(error: &AssetLoadError) -> bool {
    matches!(
        error,
        AssetLoadError::AssetReaderError(bevy::asset::io::AssetReaderError::NotFound(_))
    )
}

/// Whether the error is that the scene may not read the picture, whether or not the file exists.
pub(crate) fn is_refused_picture(error: &AssetLoadError) -> bool {
    let AssetLoadError::AssetLoaderError(error) = error else {
        return false;
    };
    let error = error.error().downcast_ref();
    matches!(error, Some(TextureMapError::File(FileError::Outside)))
}

/// The message of a loader. Bevy's own text would include a backtrace if the environment asks for one.
fn message(error: &BevyError) -> String {
    said::<MeshLoadError>(error)
        .or_else(|| said::<TextureMapError>(error))
        .or_else(|| said::<VolumeMapError>(error))
        .or_else(|| said::<std::io::Error>(error))
        .unwrap_or_else(|| error.to_string())
        .trim()
        .to_owned()
}

fn said<E: Error + 'static>(error: &BevyError) -> Option<String> {
    error.downcast_ref::<E>().map(E::to_string)
}
