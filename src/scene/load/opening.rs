//! Opens scenes over several frames if frames must be short: the entities of very many things are made in steps.

use std::time::{Duration, Instant};

use bevy::prelude::*;

use super::scene_file::Asked;
use super::spawn::Spawning;
use crate::scene::assets::SceneAsset;

/// The longest time that a frame spends on the entities of a scene being opened; None: no limit. The window sets it.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct OpeningPace(pub Option<Duration>);

/// A scene file that has been read, and the request for it.
pub(in crate::scene) type Arrived = (AssetId<SceneAsset>, SceneAsset, Option<Asked>);

/// A scene whose entities are being made.
#[derive(Resource)]
pub(in crate::scene) struct Opening {
    spawning: Spawning,
    arrived: Arrived,
}

/// The most steps in a frame: systems that list the things of the scene run after each frame.
const MOST_STEPS: usize = 32;

impl Opening {
    pub fn new(spawning: Spawning, arrived: Arrived) -> Self {
        Self { spawning, arrived }
    }

    /// Makes more entities, for as long as a frame may take. True once all exist.
    pub fn go_on(&mut self, world: &mut World) -> bool {
        let pace = world.get_resource::<OpeningPace>().copied().unwrap_or_default();
        let begun = Instant::now();
        let mut steps = 0;
        while !self.spawning.step(world) {
            steps += 1;
            if pace
                .0
                .is_some_and(|longest| begun.elapsed() >= longest || steps >= MOST_STEPS)
            {
                return false;
            }
        }
        true
    }

    pub fn into_parts(self) -> (Spawning, Arrived) {
        (self.spawning, self.arrived)
    }
}
