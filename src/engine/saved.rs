//! Pictures that are not finished: what is saved of them, and how they are taken up again.

use bevy::prelude::*;

use super::control::RenderControl;
use super::film::RenderFilm;
use super::packed_scene::PackedScene;
use super::renderer::Renderer;
use crate::render::film::Film;
use crate::render::scene::RenderScene;
use crate::render::view::View;

/// The picture that the next job resumes; None if it begins anew.
#[derive(Resource, Default)]
pub(super) struct Resumed(pub Option<Saved>);

/// The samples of a picture, and what they were made of.
pub(super) struct Saved {
    pub film: Film,
    pub job: Vec<u8>,
    scene: Option<RenderScene>,
    view: Option<View>,
}

impl Saved {
    /// Whether it is a picture of this scene and view.
    pub fn is_of(&self, scene: &RenderScene, view: Option<&View>) -> bool {
        self.view.as_ref() == view && self.scene.as_ref().is_some_and(|own| own.is_same(scene))
    }
}

/// The state of the present job as bytes, for [`resume`]; None if there is no job.
pub fn job_state(world: &World) -> Option<Vec<u8>> {
    world.get_resource::<Renderer>()?.job().map(super::job::Job::write)
}

/// Reserves the memory of the picture that is packed and asked for, before a film for [`resume`] is made. An error says
/// how much is missing.
pub fn reserve_film(world: &mut World) -> Result<(), String> {
    let Some(view) = world.resource::<PackedScene>().view.clone() else {
        return Ok(());
    };
    let control = world.resource::<RenderControl>().clone();
    let samples = control.target_samples.unwrap_or(0);
    let reserved = world.resource_mut::<RenderFilm>().reserve(&view, &control, samples);
    reserved.map_err(|shortage| shortage.to_string())
}

/// Has the next picture go on with a film and the state of its job. The scene and the view that are packed have to be
/// those of that time; if they change before the picture begins, it begins anew. A state that is damaged makes
/// rendering fail.
pub fn resume(world: &mut World, film: Film, job: Vec<u8>) {
    let PackedScene { scene, view, .. } = world.resource::<PackedScene>();
    let (scene, view) = (scene.clone(), view.clone());
    world.insert_resource(Resumed(Some(Saved { film, job, scene, view })));
}
