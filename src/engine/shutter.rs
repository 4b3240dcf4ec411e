//! Gathers the moments of a picture with motion blur.

use bevy::prelude::*;

use super::blocking::{Limits, RenderError, load_to_completion};
use super::detect::Dirty;
use super::packed_scene::PackedScene;
use crate::render::shutter::Shutter;

/// The moments of the next picture; None where all its samples see the scene as it is. Whoever sets it takes it away again when the scene changes.
#[derive(Resource, Clone, Debug, Default)]
pub struct OpenShutter(pub Option<Shutter>);

/// Lets the samples of the next picture be spread over as many moments as `times` has. `show` brings the scene to each of them. The picture has the bits
/// that it would have if no other had been rendered before. Returns false if it was cancelled.
pub fn open_shutter(
    app: &mut App,
    times: impl IntoIterator<Item = f64>,
    limits: &Limits,
    mut show: impl FnMut(&mut World, f64),
) -> Result<bool, RenderError> {
    app.world_mut().insert_resource(OpenShutter::default());
    let mut moments = Vec::new();
    for time in times {
        show(app.world_mut(), time);
        if moments.is_empty() {
            // A hierarchy that has followed edits may give a picture other last bits.
            app.world_mut().resource_mut::<Dirty>().all_shapes();
        }
        if !load_to_completion(app, limits)? {
            return Ok(false);
        }
        let packed = app.world().resource::<PackedScene>();
        moments.extend(packed.scene.clone().zip(packed.view.clone()));
    }
    let shutter = Shutter::new(&moments).filter(|_| moments.len() > 1);
    app.world_mut().insert_resource(OpenShutter(shutter));
    Ok(true)
}
