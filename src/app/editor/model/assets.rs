//! The data of the browser of assets: folders, the files in one of them, and their pictures.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use bevy::math::Vec3;
use bevy_egui::egui;

use crate::app::editor::command::asset_kind::{AssetKind, FileUse};

/// A root folder of the browser.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AssetPlace {
    /// The name in the list.
    pub name: String,
    /// The absolute path.
    pub folder: PathBuf,
    /// Whether the user has added it, and may remove it again.
    pub is_own: bool,
}

/// A folder or a file that the program can read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AssetEntry {
    /// The absolute path.
    pub path: PathBuf,
    /// The name without the folder.
    pub name: String,
    /// The kind of a file; None for a folder.
    pub kind: Option<AssetKind>,
    /// The length of the file; 0 for a folder.
    pub bytes: u64,
    /// The time of the last change, if the system knows it.
    pub modified: Option<SystemTime>,
}

/// The content of a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Listing {
    /// The folder.
    pub folder: PathBuf,
    /// Its folders and files, in alphabetical order.
    pub entries: Vec<AssetEntry>,
    /// The reason why the folder cannot be read or is not listed in full.
    pub problem: Option<String>,
}

/// The picture of a file, and facts about its content.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AssetPicture {
    /// The texture; None for files without a picture.
    pub texture: Option<egui::TextureId>,
    /// Width and height of the texture in pixels.
    pub size: [usize; 2],
    /// The size of a picture, the triangle count of a mesh, or the materials of a file.
    pub note: String,
    /// The least and the greatest coordinates of a mesh.
    pub bounds: Option<[Vec3; 2]>,
    /// Whether the file holds nothing but materials.
    pub is_material: bool,
    /// The reason why the file cannot be used.
    pub problem: Option<String>,
}

/// The data of the panel.
#[derive(Clone, Debug, Default)]
pub struct AssetsModel {
    /// The root folders of the browser.
    pub places: Arc<Vec<AssetPlace>>,
    /// The content of the folder that the panel asks for; None until it has been read.
    pub listing: Option<Arc<Listing>>,
    /// Pictures by absolute path, of files that have been visible.
    pub pictures: Arc<HashMap<PathBuf, AssetPicture>>,
    /// The environments that come with the program.
    pub environments: Arc<Vec<PathBuf>>,
}

impl AssetsModel {
    /// The use of a file without a place in the picture.
    pub(crate) fn use_of(&self, path: &Path) -> FileUse {
        FileUse {
            path: path.to_owned(),
            at: None,
            bounds: self.pictures.get(path).and_then(|picture| picture.bounds),
        }
    }
}
