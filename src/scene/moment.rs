//! Shows another moment of an animated scene.
//!
//! A scene file with key frames is read as it is at one time ([`Document::at`]). Another time is another reading of the same file: the entities are
//! brought up to date as if the file had changed, so that whatever can stand in a file can move, and only what moves is written.

use std::sync::Arc;

use bevy::prelude::*;

use super::read::read;
use super::{AuthoredScene, spawn};
use crate::document::Document;

/// The times of the first and the last key of the open scene in seconds; None if nothing moves.
pub fn animated_span(world: &World) -> Option<(f64, f64)> {
    origin(world)?.animated_span()
}

/// Brings the entities to the moment at `time`, in seconds. Edits stay as in a reload of the file. Returns whether anything can have changed.
///
/// The text of the file must have been kept ([`super::KeepSource`]).
pub fn show_moment(world: &mut World, time: f64) -> bool {
    let Some(origin) = origin(world) else {
        return false;
    };
    let differs = origin.time != time && origin.animated_span().is_some();
    if differs {
        let scene = read(&mut origin.at(time));
        spawn::update(world, &Arc::new(scene));
    }
    differs
}

/// The time in seconds that the entities show.
pub fn shown_time(world: &World) -> f64 {
    origin(world).map_or(0.0, |origin| origin.time)
}

fn origin(world: &World) -> Option<Arc<Document>> {
    world.get_resource::<AuthoredScene>()?.origin.clone()
}
