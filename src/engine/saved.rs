//! Pictures that are not finished: what is saved of them, and how they are taken up again.

use bevy::prelude::*;

use super::renderer::Renderer;
use crate::render::film::Film;

/// The picture that the next job goes on with; None if it begins anew.
#[derive(Resource, Default)]
pub(super) struct Resumed(pub Option<(Film, Vec<u8>)>);

/// The state of the present job as bytes, for [`resume`]; None if there is no job.
pub fn job_state(world: &World) -> Option<Vec<u8>> {
    world.get_resource::<Renderer>()?.job().map(super::job::Job::write)
}

/// Has the next picture go on with a film and the state of its job. Scene and view have to be those of that time. A state that is damaged makes rendering
/// fail.
pub fn resume(world: &mut World, film: Film, job: Vec<u8>) {
    world.insert_resource(Resumed(Some((film, job))));
}
