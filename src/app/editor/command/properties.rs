//! Edits of the properties that things and the scene have for the code of a game.

use bevy::prelude::Entity;

use super::traits::Traits;
use crate::scene::PropertyValue;

/// The owner of properties.
#[derive(Clone, Debug, PartialEq)]
pub enum PropertyOwner {
    /// The scene itself.
    Scene,
    /// These things; all get the same edit.
    Things(Vec<Entity>),
}

/// The edit of one property.
#[derive(Clone, Debug, PartialEq)]
pub enum PropertyChange {
    /// Sets it, and adds it where it is missing.
    Set(PropertyValue),
    /// Removes it.
    Remove,
    /// Gives it another name.
    Rename(String),
}

/// An edit of the property of one name.
#[derive(Clone, Debug, PartialEq)]
pub struct PropertyEdit {
    /// The things with the property.
    pub owner: PropertyOwner,
    /// The name of the property.
    pub name: String,
    /// The change.
    pub change: PropertyChange,
}

impl PropertyEdit {
    pub(super) fn traits(&self) -> Traits {
        let traits = match self.change {
            // Values are dragged.
            PropertyChange::Set(_) => Traits {
                moves_picture: false,
                ..Traits::drag("Set property")
            },
            PropertyChange::Remove => Traits::edit("Remove property"),
            PropertyChange::Rename(_) => Traits::edit("Rename property"),
        };
        let traits = match &self.owner {
            PropertyOwner::Scene => traits,
            PropertyOwner::Things(things) => traits.of(things),
        };
        traits.giving_name(&self.name).keeping_picture()
    }
}
