//! Describes the present entities.

use bevy::prelude::*;

use super::snapshot::Snapshot;
use crate::scene::SceneDescription;
use crate::scene::file::entities::Entities;

/// Describes all shapes, materials, emitters and sensors, each kind in the order of the file.
pub fn describe(world: &mut World) -> SceneDescription {
    describe_entities(world).0
}

/// [`describe`] that also returns the described entities.
pub(crate) fn describe_entities(world: &mut World) -> (SceneDescription, Entities) {
    Snapshot::of(world).describe()
}
