//! The program without a window: the scene and the engine, updated by whoever renders.

use bevy::prelude::*;

use super::threads::{run_systems_in_turn, worker_count};
use crate::engine::{EnginePlugin, RenderControl};
use crate::scene::{FileSourcePlugin, OpenScene, ScenePlugin, asset_plugin};

/// An app that will load `scene` and render it; see [`crate::engine::render_to_completion`]. `threads` as in [`worker_count`].
pub fn headless(scene: OpenScene, threads: Option<i32>) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, FileSourcePlugin, asset_plugin()))
        .add_plugins((ScenePlugin, EnginePlugin))
        .insert_resource(RenderControl {
            threads: worker_count(threads, false),
            ..default()
        });
    run_systems_in_turn(&mut app);
    app.world_mut().write_message(scene);
    app
}
