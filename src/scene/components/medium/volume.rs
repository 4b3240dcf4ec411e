//! Values that vary in space.

use std::path::{Path, PathBuf};

use bevy::math::Affine3A;
use bevy::prelude::*;

use crate::color::Rgb;

/// The name in the file of [`GridFile::use_grid_bbox`].
pub(crate) const USE_GRID_BBOX: &str = "use_grid_bbox";

/// The name in the file of the grid of a `.vdb` file.
pub(crate) const GRID: &str = "grid";

/// A parameter of a medium that is the same everywhere, or varies in space.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum VolumeParameter<T> {
    /// The same value everywhere.
    Constant(T),
    /// The same value in a box; as a density it is zero outside.
    Box {
        /// The value in the box.
        value: T,
        /// The transform of the unit cube, [0, 1]^3, to the box in the world. Invertible.
        to_world: Affine3A,
    },
    /// A grid of values in a file.
    Grid(GridFile),
}

impl<T> VolumeParameter<T> {
    /// The grid, if there is one.
    pub fn grid(&self) -> Option<&GridFile> {
        match self {
            Self::Grid(grid) => Some(grid),
            _ => None,
        }
    }
}

impl<T> VolumeParameter<T> {
    /// The transform from the unit cube to the world, and the file of a grid; None for a constant.
    pub(crate) fn placed(&self) -> Option<(&Affine3A, Option<&GridFile>)> {
        match self {
            Self::Constant(_) => None,
            Self::Box { to_world, .. } => Some((to_world, None)),
            Self::Grid(grid) => Some((&grid.to_world, Some(grid))),
        }
    }

    /// The mutable grid, if there is one.
    pub(crate) fn grid_mut(&mut self) -> Option<&mut GridFile> {
        match self {
            Self::Grid(grid) => Some(grid),
            _ => None,
        }
    }

    /// The mutable transform from the unit cube to the world; None for a constant.
    pub(crate) fn place_mut(&mut self) -> Option<&mut Affine3A> {
        match self {
            Self::Constant(_) => None,
            Self::Box { to_world, .. } => Some(to_world),
            Self::Grid(grid) => Some(&mut grid.to_world),
        }
    }
}

impl<T: Copy> VolumeParameter<T> {
    /// The value, if it is constant.
    pub fn constant(&self) -> Option<T> {
        match self {
            Self::Constant(value) => Some(*value),
            _ => None,
        }
    }
}

impl From<Rgb> for VolumeParameter<Rgb> {
    fn from(color: Rgb) -> Self {
        Self::Constant(color)
    }
}

impl From<f32> for VolumeParameter<f32> {
    fn from(number: f32) -> Self {
        Self::Constant(number)
    }
}

/// A file with a grid of values, and how it is sampled.
#[derive(Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq)]
pub struct GridFile {
    /// The absolute path.
    pub path: PathBuf,
    /// The file format.
    pub format: VolumeFormat,
    /// The transform to the world from the grid's own space, in which it fills the unit cube, [0, 1]^3, or the box
    /// given in a `.vdb` file. Invertible.
    pub to_world: Affine3A,
    /// The interpolation between the centres of voxels.
    pub filter: VolumeFilter,
    /// The continuation outside of the grid.
    pub wrap: VolumeWrap,
    /// Whether the grid fills the box declared in its file, instead of the unit cube.
    pub use_grid_bbox: bool,
}

impl GridFile {
    /// The path of the asset with the voxels, see [`VolumeFormat::asset_path`].
    pub fn asset_path(&self) -> PathBuf {
        self.format.asset_path(&self.path)
    }
}

/// The format of a volume file, given by the plugin that names the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum VolumeFormat {
    /// Mitsuba's `.vol`: one grid.
    #[default]
    Vol,
    /// OpenVDB's `.vdb`: grids with names.
    Vdb {
        /// The name of the grid. None: `density`, or else the only one.
        grid: Option<String>,
    },
}

/// The extension of asset paths for grids of `.vdb` files.
const VDB_GRID: &str = ".vdb-grid";

impl VolumeFormat {
    /// The format by the file extension, with the default grid.
    pub fn of_file(file: &Path) -> Self {
        let is_vdb = file.extension().is_some_and(|end| end.eq_ignore_ascii_case("vdb"));
        if is_vdb { Self::Vdb { grid: None } } else { Self::Vol }
    }

    /// The name of the plugin in the file.
    pub fn plugin(&self) -> &'static str {
        match self {
            Self::Vol => "gridvolume",
            Self::Vdb { .. } => "vdbvolume",
        }
    }

    /// The path of the asset for a grid of this file. Each grid of a `.vdb` file is an asset of its own, as if the file
    /// was a folder and the grid a file in it.
    pub fn asset_path(&self, file: &Path) -> PathBuf {
        let Self::Vdb { grid } = self else {
            return file.to_owned();
        };
        // Names of grids may have any characters, including path separators.
        let escaped = grid.iter().flat_map(|name| name.bytes()).map(|byte| match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'_' => char::from(byte).to_string(),
            other => format!("%{other:02x}"),
        });
        file.join(escaped.chain([VDB_GRID.to_owned()]).collect::<String>())
    }

    /// The file, format and grid of an asset: the inverse of [`Self::asset_path`].
    pub fn of_asset(asset: &Path) -> (&Path, Self) {
        let name = asset.file_name().and_then(|name| name.to_str());
        let (Some(file), Some(escaped)) = (asset.parent(), name.and_then(|name| name.strip_suffix(VDB_GRID))) else {
            return (asset, Self::Vol);
        };
        let mut bytes = Vec::new();
        let mut rest = escaped.as_bytes();
        while let [first, after @ ..] = rest {
            let code = after.get(..2).filter(|_| *first == b'%');
            let code = code.and_then(|two| u8::from_str_radix(str::from_utf8(two).ok()?, 16).ok());
            bytes.push(code.unwrap_or(*first));
            rest = &after[if code.is_some() { 2 } else { 0 }..];
        }
        let grid = String::from_utf8(bytes).ok().filter(|name| !name.is_empty());
        (file, Self::Vdb { grid })
    }
}

declare_names! {
    /// The interpolation between the centres of voxels.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum VolumeFilter {
        /// The voxel that the point lies in.
        Nearest = "nearest",
        /// Linear between the eight voxels around the point.
        #[default]
        Trilinear = "trilinear",
    }
}

declare_names! {
    /// The continuation of a grid outside of its box. The density of a medium is zero there all the same.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum VolumeWrap {
        /// The voxels of the border.
        #[default]
        Clamp = "clamp",
        /// Repetition of the grid.
        Repeat = "repeat",
        /// Repetition of the grid, every other time mirrored.
        Mirror = "mirror",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_grid_is_an_asset_of_its_own_that_knows_its_file() {
        let file = Path::new("/a/smoke.vdb");
        let vdb = |grid: Option<&str>| VolumeFormat::Vdb {
            grid: grid.map(str::to_owned),
        };
        let formats = [
            None,
            Some("density"),
            Some("a/../b"),
            Some("density[1]"),
            Some("100%"),
            Some("größe .vdb-grid"),
        ];
        let formats: Vec<VolumeFormat> = [VolumeFormat::Vol].into_iter().chain(formats.map(vdb)).collect();
        let assets: Vec<PathBuf> = formats.iter().map(|format| format.asset_path(file)).collect();
        for (format, asset) in formats.iter().zip(&assets) {
            assert_eq!(
                VolumeFormat::of_asset(asset),
                (file, format.clone()),
                "{}",
                asset.display()
            );
            assert_eq!(assets.iter().filter(|other| *other == asset).count(), 1);
        }
    }
}
