//! Commands about files.

use std::path::PathBuf;

use super::file_dialog::FileDialogKind;
use super::traits::Traits;
use crate::scene::write::OnChange;

/// A command about the files of the scene and of the picture, which leaves the history alone.
#[derive(Clone, Debug, PartialEq)]
pub enum FileCommand {
    /// Begins a new scene: a camera and a grey sky, without a file.
    NewScene,
    /// Replaces the scene by that of a file: XML or glTF.
    OpenScene(PathBuf),
    /// Reads the file of the scene again; edits stay.
    ReloadScene,
    /// Restores the state in the file.
    RevertScene,
    /// Saves to the file of the open scene; asks for one if there is none.
    Save,
    /// Saves to this file, which is the scene's file from then on.
    SaveScene(PathBuf),
    /// Saves to this file even if others changed it since it was read.
    SaveChanged(PathBuf, OnChange),
    /// Writes the scene to this file as glTF, for other programs. The scene's own file stays the same.
    ExportScene(PathBuf),
    /// Saves the picture: as shown for PNG, the linear radiance for EXR and HDR.
    SaveImage(PathBuf),
    /// Opens a dialog that asks for a file.
    ShowDialog(FileDialogKind),
    /// Closes the window; asks first if edits would be lost.
    Quit,
}

impl FileCommand {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::NewScene | Self::OpenScene(_) | Self::RevertScene | Self::Quit => Traits::NONE.losing_edits(),
            Self::SaveImage(_) => Traits::NONE.of_pixels(),
            Self::Save | Self::SaveScene(_) | Self::SaveChanged(..) => Traits::NONE.saving(),
            Self::ReloadScene | Self::ExportScene(_) | Self::ShowDialog(_) => Traits::NONE,
        }
    }
}
