//! Participating media, and the components that refer to them.

mod coefficients;
mod models;
mod phase;
mod volume;

use bevy::prelude::*;

pub use coefficients::Coefficients;
pub(crate) use coefficients::{ALBEDO, SIGMA_A, SIGMA_S, SIGMA_T};
pub use models::Medium;
pub use phase::{PhaseBlend, PhaseFunction};
pub(crate) use volume::{GRID, USE_GRID_BBOX};
pub use volume::{GridFile, VolumeFilter, VolumeFormat, VolumeParameter, VolumeWrap};

/// The parameter name of the medium inside a shape, and of the one outside.
pub(crate) const INTERIOR: &str = "interior";
pub(crate) const EXTERIOR: &str = "exterior";

/// The medium on the side of a shape's surface that its normal points away from.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = InteriorOf)]
pub struct InteriorMedium(pub Entity);

/// The shapes that contain this medium.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = InteriorMedium)]
pub struct InteriorOf(Vec<Entity>);

/// The medium on the side of a shape's surface that its normal points to.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = ExteriorOf)]
pub struct ExteriorMedium(pub Entity);

/// The shapes that this medium surrounds.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = ExteriorMedium)]
pub struct ExteriorOf(Vec<Entity>);

/// The medium around a sensor or an emitter.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq, Eq)]
#[reflect(Component, PartialEq)]
#[relationship(relationship_target = Surrounds)]
pub struct InMedium(pub Entity);

/// The sensors and emitters in a medium.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq, Eq)]
#[relationship_target(relationship = InMedium)]
pub struct Surrounds(Vec<Entity>);

/// The things of the scene that refer to a medium.
pub(crate) fn users_of_medium(world: &World, medium: Entity) -> impl Iterator<Item = Entity> {
    fn all<'w, R: RelationshipTarget>(world: &'w World, medium: Entity) -> impl Iterator<Item = Entity> + use<'w, R> {
        world.get::<R>(medium).into_iter().flat_map(|users| users.iter())
    }
    let sides = all::<InteriorOf>(world, medium).chain(all::<ExteriorOf>(world, medium));
    sides.chain(all::<Surrounds>(world, medium))
}
