//! Pictures that are not finished: what is saved of them, and how they are taken up again.

use bevy::prelude::*;

use super::control::RenderControl;
use super::film::RenderFilm;
use super::packed_scene::PackedScene;
use super::renderer::Renderer;
use crate::render::film::Film;

/// The picture that the next job goes on with; None if it begins anew.
#[derive(Resource, Default)]
pub(super) struct Resumed(pub Option<(Film, Vec<u8>)>);

/// The state of the present job as bytes, for [`resume`]; None if there is no job.
pub fn job_state(world: &World) -> Option<Vec<u8>> {
    world.get_resource::<Renderer>()?.job().map(super::job::Job::write)
}

/// Reserves the memory of the picture that is packed and asked for, before a film for [`resume`] is made. An error says how much is missing.
pub fn reserve_film(world: &mut World) -> Result<(), String> {
    let Some(view) = world.resource::<PackedScene>().view.clone() else {
        return Ok(());
    };
    let control = world.resource::<RenderControl>().clone();
    let samples = control.target_samples.unwrap_or(0);
    let reserved = world.resource_mut::<RenderFilm>().reserve(&view, &control, samples);
    reserved.map_err(|shortage| shortage.to_string())
}

/// Has the next picture go on with a film and the state of its job. Scene and view have to be those of that time. A state that is damaged makes rendering
/// fail.
pub fn resume(world: &mut World, film: Film, job: Vec<u8>) {
    world.insert_resource(Resumed(Some((film, job))));
}
