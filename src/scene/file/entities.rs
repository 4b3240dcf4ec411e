//! The entities of the things in a description.

use bevy::prelude::*;

use crate::scene::components::description::DeclarationPlace;

/// The entities of a description, in its order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Entities {
    pub sensors: Vec<Entity>,
    pub media: Vec<Entity>,
    pub materials: Vec<Entity>,
    pub groups: Vec<Entity>,
    pub shapes: Vec<Entity>,
    pub emitters: Vec<Entity>,
}

impl Entities {
    /// The entity of the owner at a place of declaration; None for the top level.
    pub fn at(&self, place: DeclarationPlace) -> Option<Entity> {
        let entity = match place {
            DeclarationPlace::TopLevel => None,
            DeclarationPlace::Shape(index) => self.shapes.get(index),
            DeclarationPlace::Material(index) => self.materials.get(index),
            DeclarationPlace::Sensor(index) => self.sensors.get(index),
            DeclarationPlace::Emitter(index) => self.emitters.get(index),
        };
        entity.copied()
    }

    /// The entities of all lists in turn.
    pub fn all(&self) -> impl Iterator<Item = Entity> {
        let lists = [
            &self.media,
            &self.materials,
            &self.groups,
            &self.shapes,
            &self.emitters,
            &self.sensors,
        ];
        lists.into_iter().flatten().copied()
    }
}
