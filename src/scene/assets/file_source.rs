//! The asset server's source of files: refuses at once what [`crate::files`] refuses.
//!
//! The server's own reader would wait for ever for a pipe. This one returns no bytes: the loaders read the whole file
//! themselves, because the server passes bytes between threads in small pieces.

use std::path::Path;
use std::sync::Arc;

use bevy::asset::AssetApp;
use bevy::asset::io::{
    AssetReader, AssetReaderError, AssetSourceBuilder, AssetSourceId, PathStream, Reader, VecReader,
};
use bevy::prelude::*;

use crate::files::{FileError, finish_set_within};
use crate::memory;
use crate::scene::{SceneAccess, VolumeFormat};

/// Makes files the asset server's default source. It must be added before [`AssetPlugin`].
pub struct FileSourcePlugin;

impl Plugin for FileSourcePlugin {
    fn build(&self, app: &mut App) {
        let access = app.world_mut().get_resource_or_init::<SceneAccess>().clone();
        let source = AssetSourceBuilder::new(move || Box::new(FileSource { access: access.clone() }));
        app.register_asset_source(AssetSourceId::Default, source);
    }
}

struct FileSource {
    access: SceneAccess,
}

impl AssetReader for FileSource {
    async fn read<'a>(&'a self, path: &'a Path) -> Result<impl Reader + 'a, AssetReaderError> {
        let (path, _) = VolumeFormat::of_asset(path);
        // Loaders refuse files that the scene may not read, whether these exist or not.
        if !self.access.get().covers(path) {
            return Ok(VecReader::new(Vec::new()));
        }
        let check = || memory::check_data(path, &self.access.get());
        let checked = check().or_else(|error| match error.is_not_found() {
            // A killed program may have left the new file under a temporary name.
            true => finish_set_within(path, &self.access.get()).and_then(|()| check()),
            false => Err(error),
        });
        match checked {
            Ok(()) => Ok(VecReader::new(Vec::new())),
            Err(FileError::Io(error)) if error.kind() == std::io::ErrorKind::NotFound => Err(not_found(path)),
            Err(error) => Err(AssetReaderError::Io(Arc::new(error.into()))),
        }
    }

    async fn read_meta<'a>(&'a self, path: &'a Path) -> Result<impl Reader + 'a, AssetReaderError> {
        Err::<VecReader, _>(not_found(path))
    }

    async fn read_directory<'a>(&'a self, path: &'a Path) -> Result<Box<PathStream>, AssetReaderError> {
        Err(not_found(path))
    }

    async fn is_directory<'a>(&'a self, _path: &'a Path) -> Result<bool, AssetReaderError> {
        Ok(false)
    }
}

fn not_found(path: &Path) -> AssetReaderError {
    AssetReaderError::NotFound(path.to_owned())
}
