//! The entities behind the things of a description.

use bevy::prelude::*;

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
