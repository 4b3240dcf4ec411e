//! The picture that is saved once the full film is there, and denoised if that is on.

use std::path::PathBuf;

use bevy::prelude::Resource;

/// The picture that is waited for.
#[derive(Resource, Clone, Debug, PartialEq, Eq)]
pub struct AwaitedImage {
    /// The file.
    pub path: PathBuf,
    /// The samples per pixel that it gets.
    pub samples: u32,
    /// Whether it is denoised, as pictures were when it was to be saved.
    pub is_denoised: bool,
    /// The demands on rendering before, which count again afterwards.
    pub before: Before,
}

/// The demands on rendering that waiting for a picture replaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Before {
    /// The full film was to be traced: the exact number of samples that was asked for before.
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

/// Says why a picture that was waited for was not saved.
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
    /// The full film was given up.
    #[error("{file} was not saved: the scene, the view or the resolution was changed before the full film was there.")]
    Changed {
        /// The name of the file.
        file: String,
    },
    /// The file could not be written, as the message says.
    #[error("{0}")]
    NotWritten(String),
}
