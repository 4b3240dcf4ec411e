//! The editor's steps within a frame.

use bevy::prelude::*;

/// The editor's sets of systems in `PostUpdate`, around those of egui and the engine.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum EditorSystems {
    /// World to model, before the panels are shown.
    Gather,
    /// Commands are applied to the world, before the engine looks for changes.
    Apply,
    /// The film is copied to the texture, after the engine has collected results and given its workers new tiles.
    Show,
}
