//! The things that can be dragged from one panel to another, or onto the picture.

use bevy::prelude::Entity;

use super::asset_kind::FileUse;
use super::presets::Preset;

/// Things that are dragged from the list to somewhere else: into a folder, to another place, onto a shape in the
/// picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Dragged(pub Vec<Entity>);

/// A material of the library on its way to a shape in the picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DraggedPreset(pub Preset);

/// A file of the browser on its way into the picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DraggedFile {
    pub file: FileUse,
    /// It is known to be a whole scene.
    pub is_scene: bool,
}
