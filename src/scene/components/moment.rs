//! The shown time of an animated scene.

use bevy::prelude::*;

/// The time in seconds at which animated values are evaluated.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::scene) struct ShownTime(pub f64);

/// The shown time in seconds.
pub fn shown_time(world: &World) -> f64 {
    world.get_resource().copied().unwrap_or(ShownTime(0.0)).0
}
