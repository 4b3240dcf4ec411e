//! The app without a window: the scene and the engine, updated by the caller that renders.

use bevy::prelude::*;

use super::allocator::{give_back, keep_memory_low};
use super::threads::{run_systems_in_turn, worker_count};
use crate::engine::{EnginePlugin, RenderControl};
use crate::scene::assets::SceneAsset;
use crate::scene::{FileSourcePlugin, KeepSource, OpenScene, ScenePlugin, SceneSystems, asset_plugin};

/// An app that will load `scene` and render it; see [`crate::engine::render_to_completion`]. `threads` as in
/// [`worker_count`].
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

/// An app like that of [`headless`], for a scene that is rendered and neither edited nor written. It does not keep the
/// file's data for editing and writing, and it does not follow changes of the file.
pub fn render_only(scene: OpenScene, threads: Option<i32>) -> App {
    keep_memory_low();
    let mut app = headless(scene, threads);
    app.world().resource::<KeepSource>().set(false);
    // It runs after the tree of the file and its description have been dropped.
    app.add_systems(
        PreUpdate,
        (
            give_back_after_reading.before(SceneSystems::Apply),
            give_back_after_reading.after(SceneSystems::Apply),
        ),
    );
    app
}

fn give_back_after_reading(mut read: MessageReader<AssetEvent<SceneAsset>>) {
    let is_added = |event: &AssetEvent<SceneAsset>| matches!(event, AssetEvent::Added { .. });
    if read.read().any(is_added) {
        give_back();
    }
}
