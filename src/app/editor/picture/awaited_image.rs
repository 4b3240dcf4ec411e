//! The image that is saved once the full film is rendered, and denoised if that is on.

use std::path::PathBuf;

use bevy::prelude::Resource;

/// The awaited image.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct AwaitedImage {
    /// The file.
    pub path: PathBuf,
    /// The samples per pixel of the image.
    pub samples: u32,
    /// Whether it is denoised, as the picture was when the save was requested.
    pub is_denoised: bool,
    /// The settings of the renderer from before, which are restored afterwards.
    pub before: Before,
}

/// The settings of the renderer that waiting for an image replaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Before {
    /// The window had fewer pixels than the full film: the exact number of samples that was requested before.
    Smaller {
        /// See [`RenderControl::exact_samples`](crate::engine::RenderControl::exact_samples).
        exact_samples: Option<u32>,
    },
    /// All pixels were there, and rendering pauses until they are denoised: whether it was paused before.
    Whole {
        /// See [`RenderControl::paused`](crate::engine::RenderControl::paused).
        paused: bool,
    },
}

impl AwaitedImage {
    /// The name of the file without its folder.
    pub fn file_name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }
}

/// The end of the wait.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct EndedImage(pub Result<(), ImageNotSaved>);

/// The reason why an awaited image was not saved.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImageNotSaved {
    /// Rendering has failed.
    #[error("{file} was not saved: {reason}")]
    Failed {
        /// The name of the file.
        file: String,
        /// The message of the renderer.
        reason: String,
    },
    /// The user has cancelled it.
    #[error("{file} was not saved: it was cancelled.")]
    Cancelled {
        /// The name of the file.
        file: String,
    },
    /// The scene or the view changed, which ended the full film.
    #[error("{file} was not saved: the scene, the view or the resolution was changed before the full film was there.")]
    Changed {
        /// The name of the file.
        file: String,
    },
    /// The file could not be written, as the message says.
    #[error("{0}")]
    NotWritten(String),
}
