//! A grid of values loaded from a file, for participating media.

use std::path::Path;
use std::sync::Arc;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::math::Affine3A;
use bevy::prelude::*;

use crate::color::BRIGHTEST;
use crate::files::{Access, FileError};
use crate::math::Aabb;
use crate::medium::vdb::{VdbError, VdbFile};
use crate::medium::{Mended, VolError, VolumeGrid, read_vol, write_vol};
use crate::memory;
use crate::scene::{SceneAccess, VolumeFormat};

/// A grid as an asset. `grid` is a new `Arc` after each reload.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct VolumeMap {
    /// The voxels, none of them negative.
    pub grid: Arc<VolumeGrid>,
    /// The bounding box declared by the file; None if there is none.
    pub bounds: Option<Aabb>,
    /// The transform to the space of the file from that in which the grid fills the unit cube, [0, 1]^3. Invertible.
    pub world_from_local: Affine3A,
}

impl VolumeMap {
    /// The content of a `.vol` file with these voxels in the unit cube.
    pub fn to_vol(&self) -> Vec<u8> {
        let unit = Aabb {
            min: Vec3::ZERO,
            max: Vec3::ONE,
        };
        write_vol(&self.grid, &unit)
    }
}

/// Loads `.vol` files, and grids of `.vdb` files, whose paths are made by [`VolumeFormat::asset_path`].
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
    #[error(transparent)]
    Vdb(#[from] VdbError),
    #[error("this is a .{0} file: a `{1}` reads it")]
    OtherKind(&'static str, &'static str),
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

/// The grid at the path of an asset, read from the disk if `access` permits.
pub(crate) fn load_volume(asset: &Path, access: &Access) -> Result<VolumeMap, VolumeMapError> {
    let (path, format) = VolumeFormat::of_asset(asset);
    let bytes = memory::read_data(path, access)?;
    let vdb = VdbFile::open(&bytes);
    match format {
        VolumeFormat::Vol => match (read_vol(&bytes), vdb) {
            (Err(VolError::Magic), Ok(_)) => Err(VolumeMapError::OtherKind("vdb", "vdbvolume")),
            (file, _) => {
                let file = file?;
                Ok(VolumeMap {
                    grid: Arc::new(file.grid),
                    bounds: file.bounds,
                    world_from_local: Affine3A::IDENTITY,
                })
            }
        },
        VolumeFormat::Vdb { grid } => {
            if vdb.as_ref().is_err_and(|error| *error == VdbError::NotVdb) && bytes.starts_with(b"VOL") {
                return Err(VolumeMapError::OtherKind("vol", "gridvolume"));
            }
            // The reader asks the memory budget before it allocates the grid.
            let volume = vdb?.read(grid.as_deref(), u64::MAX)?;
            Ok(VolumeMap {
                grid: Arc::new(volume.grid),
                bounds: None,
                world_from_local: volume.world_from_local,
            })
        }
    }
}

impl VolumeMap {
    /// A sentence about repaired values; None if there are none.
    pub(crate) fn warning(&self) -> Option<String> {
        let Mended { zeros, limited } = self.grid.mended();
        let zeros = match zeros {
            0 => None,
            1 => Some("1 value is negative or no number: it counts as zero".to_owned()),
            _ => Some(format!("{zeros} values are negative or no numbers: they count as zero")),
        };
        let limited = match limited {
            0 => None,
            1 => Some(format!("1 value is above {BRIGHTEST:e}: it counts as that")),
            _ => Some(format!("{limited} values are above {BRIGHTEST:e}: they count as that")),
        };
        let found: Vec<String> = zeros.into_iter().chain(limited).collect();
        (!found.is_empty()).then(|| found.join("; "))
    }
}
