//! A grid of values loaded from a file, for participating media.

use std::path::Path;
use std::sync::Arc;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;

use crate::files::{Access, FileError};
use crate::math::Aabb;
use crate::medium::{VolError, VolumeGrid, read_vol};
use crate::memory;
use crate::scene::SceneAccess;

/// A grid as an asset. `grid` is a new `Arc` after each reload.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct VolumeMap {
    /// The voxels, none of them negative.
    pub grid: Arc<VolumeGrid>,
    /// The box that the file names for them; None if it names none.
    pub bounds: Option<Aabb>,
}

/// Reads `.vol` files.
#[derive(Default, TypePath)]
pub(crate) struct VolumeMapLoader {
    pub access: SceneAccess,
}

#[derive(Debug, thiserror::Error)]
pub(crate) enum VolumeMapError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Vol(#[from] VolError),
}

impl AssetLoader for VolumeMapLoader {
    type Asset = VolumeMap;
    type Settings = ();
    type Error = VolumeMapError;

    async fn load(
        &self,
        _reader: &mut dyn Reader,
        _settings: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<VolumeMap, VolumeMapError> {
        load_volume(context.path().path(), &self.access.get())
    }

    fn extensions(&self) -> &[&str] {
        &["vol"]
    }
}

/// A volume file, read from the disk if `access` permits.
pub(crate) fn load_volume(path: &Path, access: &Access) -> Result<VolumeMap, VolumeMapError> {
    let file = read_vol(&memory::read_data(path, access)?)?;
    Ok(VolumeMap {
        grid: Arc::new(file.grid),
        bounds: file.bounds,
    })
}

impl VolumeMap {
    /// What was mended in it, in words; None if it was good.
    pub(crate) fn warning(&self) -> Option<String> {
        match self.grid.mended() {
            0 => None,
            1 => Some("1 value is negative or no number: it counts as zero".to_owned()),
            mended => Some(format!(
                "{mended} values are negative or no numbers: they count as zero"
            )),
        }
    }
}
