//! Saving unfinished pictures, and resuming them.

use bevy::prelude::*;

use super::control::RenderControl;
use super::film::RenderFilm;
use super::packed_scene::PackedScene;
use super::renderer::Renderer;
use crate::render::film::Film;
use crate::render::scene::RenderScene;
use crate::render::view::View;

/// The picture that the next job resumes; None if it starts new.
#[derive(Resource, Default)]
pub(super) struct Resumed(pub Option<Saved>);

/// The film of a picture, with its scene and view.
pub(super) struct Saved {
    pub film: Film,
    pub job: Vec<u8>,
    scene: Option<RenderScene>,
    view: Option<View>,
}

impl Saved {
    /// Whether the picture shows this scene and view.
    pub fn is_of(&self, scene: &RenderScene, view: Option<&View>) -> bool {
        self.view.as_ref() == view && self.scene.as_ref().is_some_and(|own| own.is_same(scene))
    }
}

/// The state of the current job as bytes, for [`resume`]; None if there is no job.
pub fn job_state(world: &World) -> Option<Vec<u8>> {
    world.get_resource::<Renderer>()?.job().map(super::job::Job::write)
}

/// Reserves the memory of the packed picture, before a film for [`resume`] is made. An error says how much is missing.
pub fn reserve_film(world: &mut World) -> Result<(), String> {
    let Some(view) = world.resource::<PackedScene>().view.clone() else {
        return Ok(());
    };
    let control = world.resource::<RenderControl>().clone();
    let samples = control.target_samples.unwrap_or(0);
    let reserved = world.resource_mut::<RenderFilm>().reserve(&view, &control, samples);
    reserved.map_err(|shortage| shortage.to_string())
}

/// Lets the next picture resume a film and the state of its job. The packed scene and view must be those of the saved
/// picture; if they change before the picture begins, it starts new. A damaged state makes rendering fail.
pub fn resume(world: &mut World, film: Film, job: Vec<u8>) {
    let PackedScene { scene, view, .. } = world.resource::<PackedScene>();
    let (scene, view) = (scene.clone(), view.clone());
    world.insert_resource(Resumed(Some(Saved { film, job, scene, view })));
}
