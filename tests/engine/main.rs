//! The engine without a window: what it rebuilds, when it stops, and what it makes of the lights.

#[path = "../support/split_mix.rs"]
mod split_mix;
#[path = "../support/mod.rs"]
mod support;

mod large;
mod light_mixing;
mod rebuilding;
mod stopping;
mod view_size;

use bevy::prelude::*;
use sunroom::scene::{ActiveSensor, DocumentOrder, Film, Sensor, ToWorld};

/// Looks along +z from the origin, with a film of so many pixels and four samples of each.
fn look_along(world: &mut World, width: u32, height: u32) {
    let film = Film {
        width,
        height,
        sample_count: 4,
        ..default()
    };
    let sensor = world
        .spawn((DocumentOrder(3), Sensor::default(), ToWorld::default(), film))
        .id();
    world.insert_resource(ActiveSensor(Some(sensor)));
}
