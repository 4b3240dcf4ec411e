//! The moment of an animated scene that is shown.

use bevy::prelude::*;

/// The time in seconds whose values the entities have.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::scene) struct ShownTime(pub f64);

/// The time in seconds that the entities show.
pub fn shown_time(world: &World) -> f64 {
    world.get_resource().copied().unwrap_or(ShownTime(0.0)).0
}
