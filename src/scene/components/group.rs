//! Groups of shapes, and the transforms of their instances.

use std::sync::Arc;

use bevy::prelude::*;
use glam::Affine3;

use crate::scene::DocumentOrder;

/// A group of shapes ([`MemberOf`]) that are visible only in its instances.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[require(DocumentOrder)]
pub(crate) struct ShapeGroup;

/// The group that a shape belongs to; its `ToWorld` leads into the group's space.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = Members)]
pub(crate) struct MemberOf(pub Entity);

#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = MemberOf)]
pub(crate) struct Members(Vec<Entity>);

/// The group that a [`crate::scene::ShapeKind::Instance`] shows.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = Instances)]
pub(crate) struct InstanceOf(pub Entity);

/// The instances of a group, maintained by Bevy as the inverse of [`InstanceOf`].
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = InstanceOf)]
pub(crate) struct Instances(Vec<Entity>);

/// Very many instances as one entity, in place of `ToWorld`. They are saved with the text that they were read from, if
/// the file still has it.
#[derive(Component, Clone, Debug)]
pub struct Placements {
    /// World from group; shared with the document.
    pub places: Arc<Vec<Affine3>>,
}

impl PartialEq for Placements {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.places, &other.places) || self.places == other.places
    }
}
