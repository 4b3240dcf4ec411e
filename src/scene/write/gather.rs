//! The description of the entities as they are now.

use bevy::prelude::*;

use super::snapshot::Snapshot;
use crate::scene::SceneDescription;

/// The entities of a description, in its order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Entities {
    pub sensors: Vec<Entity>,
    pub materials: Vec<Entity>,
    pub groups: Vec<Entity>,
    pub shapes: Vec<Entity>,
    pub emitters: Vec<Entity>,
}

impl Entities {
    /// The entities of all lists, one list after the other.
    pub fn all(&self) -> impl Iterator<Item = Entity> {
        let lists = [
            &self.materials,
            &self.groups,
            &self.shapes,
            &self.emitters,
            &self.sensors,
        ];
        lists.into_iter().flatten().copied()
    }
}

/// Describes all shapes, materials, emitters and sensors, each kind in the order of the file.
pub fn describe(world: &mut World) -> SceneDescription {
    describe_entities(world).0
}

/// Describes the scene as [`describe`] does, and returns the entities that the descriptions are of.
pub(crate) fn describe_entities(world: &mut World) -> (SceneDescription, Entities) {
    Snapshot::of(world).describe()
}
