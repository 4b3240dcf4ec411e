//! The resources of the model.

use bevy::prelude::*;

use super::EditorModel;
use super::gather::load_presets;
use super::leaks::Leaks;
use super::thumbnails::Thumbnails;

/// Adds the resources of the model.
pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<EditorModel>()
        .init_resource::<Leaks>()
        .init_resource::<Thumbnails>()
        .add_systems(Startup, load_presets);
}
