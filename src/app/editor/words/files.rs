//! How files are called: the endings of their names, and what is said of those that are gone.

use std::path::Path;

use bevy::prelude::*;

/// How names of scenes end.
pub const SCENE_FILES: [&str; 3] = ["xml", "glb", "gltf"];

/// Pictures that can be the light from everywhere.
pub const ENVIRONMENTS: [&str; 6] = ["hdr", "exr", "png", "jpg", "jpeg", "pfm"];

/// In small letters; empty without one.
pub fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// What to say of a file that was deleted or moved away.
pub fn gone(path: &Path) -> String {
    format!("{} is gone from the disk", path.display())
}
