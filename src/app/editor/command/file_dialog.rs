//! The purposes of file dialogs.

use bevy::prelude::Entity;

use crate::scene::{FileKind, SquarePath};

/// The purpose of a file dialog.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileDialogKind {
    /// A scene to open.
    OpenScene,
    /// The file to save the scene to.
    SaveScene,
    /// The file to export the scene to.
    ExportScene,
    /// The file to save the picture to.
    SaveImage,
    /// A file whose content is added to the scene.
    Import,
    /// The mesh that the selected shapes get.
    Replace,
    /// The file in place of a missing one, which the request names.
    FindFile(FileKind),
    /// A picture of all directions, for an environment light.
    OpenEnvironment,
    /// The picture of the light you want.
    WantedPicture,
    /// The folder for a level with its lightmaps.
    BakeFolder,
    /// A folder for the list of the browser of assets.
    AssetFolder,
    /// The picture of the texture of this parameter, or of a texture nested in it.
    OpenPicture {
        /// A material or a light.
        owner: Entity,
        /// The name of the parameter in the file.
        parameter: &'static str,
        /// The place of the texture within the parameter, if it is inside a checkerboard.
        place: SquarePath,
    },
}
