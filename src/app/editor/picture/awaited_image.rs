//! The picture that is saved once the full film is there.

use std::path::PathBuf;

use bevy::prelude::Resource;

/// The picture that is waited for.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct AwaitedImage {
    /// The file.
    pub path: PathBuf,
    /// The samples per pixel that it gets.
    pub samples: u32,
    /// Whether it is denoised, as the picture was when it was to be saved.
    pub is_denoised: bool,
    /// The exact number of samples that was asked for before, which counts again afterwards.
    pub exact_before: Option<u32>,
}

impl AwaitedImage {
    /// The name of the file without its folder.
    pub fn file_name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }
}

/// The end of the wait: the reason why the picture was not saved, if it was not.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct EndedImage(pub Result<(), String>);
