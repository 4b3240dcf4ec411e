//! Clears the film when another scene is opened, so that no picture or tile of one scene is taken for another's.

use bevy::prelude::*;

use super::deferred_drop::DeferredDrop;
use super::film::RenderFilm;
use super::renderer::Renderer;
use super::status::RenderStatus;
use crate::scene::SceneStatus;

/// Clears the film as soon as the entities are those of another scene. A reloaded scene keeps its picture until the
/// next one arrives. Runs after scenes have been read and after commands, which create new scenes.
pub(super) fn clear_for_other_scene(
    scene: Res<SceneStatus>,
    mut renderer: ResMut<Renderer>,
    mut film: ResMut<RenderFilm>,
    mut status: ResMut<RenderStatus>,
    deferred: Res<DeferredDrop>,
    mut seen: Local<u64>,
) {
    let is_new = std::mem::replace(&mut *seen, scene.revision) != scene.revision;
    if !(scene.is_opening || is_new && scene.fresh_load) {
        return;
    }
    if let Some(job) = renderer.job.take() {
        job.cancel();
        deferred.drop_later(job);
    }
    if !film.is_empty() {
        film.clear();
        status.outdated = None;
    }
}
