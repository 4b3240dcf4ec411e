//! The payloads of drags from one panel to another, or onto the picture.

use bevy::prelude::Entity;

use super::asset_kind::FileUse;
use super::presets::Preset;

/// Things dragged from the outliner: into a folder, to another position, onto a shape in the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Dragged(pub Vec<Entity>);

/// A material of the library that is dragged to a shape in the picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DraggedPreset(pub Preset);

/// A file of the browser that is dragged into the picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DraggedFile {
    pub file: FileUse,
    /// Whether it is known to be a whole scene.
    pub is_scene: bool,
}
