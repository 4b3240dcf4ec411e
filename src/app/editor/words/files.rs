//! Texts about files: the extensions of their names, and messages about files that are gone.

use std::path::Path;

use bevy::prelude::*;

/// The extensions of scenes.
pub(crate) const SCENE_FILES: [&str; 3] = ["xml", "glb", "gltf"];

/// The extensions of pictures that can be an environment.
pub(crate) const ENVIRONMENTS: [&str; 6] = ["hdr", "exr", "png", "jpg", "jpeg", "pfm"];

/// The extension in small letters; empty without one.
pub fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// The message about a file that was deleted or moved away.
pub fn gone(path: &Path) -> String {
    format!("{} is gone from the disk", path.display())
}
