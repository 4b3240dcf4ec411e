//! Gathers the moments of a picture with motion blur.

use std::sync::Arc;

use bevy::prelude::*;

use super::blocking::{Limits, RenderError, load_to_completion};
use super::detect::Dirty;
use super::extract::Extracted;
use super::packed_scene::PackedScene;
use crate::layer::Layer;
use crate::render::light_layers::LightGroups;
use crate::render::motion::FrameBefore;
use crate::render::shutter::Shutter;
use crate::scene::IntegratorSettings;

/// The moments of the next picture. They do not follow changes of the scene: [`open_shutter`] sets them again for each
/// picture.
#[derive(Resource, Clone, Debug, Default)]
pub struct OpenShutter {
    /// The moments; None where all samples see the scene as it is.
    pub shutter: Option<Shutter>,
    /// The previous frame, for the motion layer of a picture without moments.
    pub before: Option<FrameBefore>,
}

/// Spreads the samples of the next picture over the moments `times`, in frames. `show` brings the scene to each of
/// them, and, if the motion layer is wanted, to the times one frame earlier. The picture has the same bits as if no
/// other had been rendered before. Returns false if it was cancelled.
pub fn open_shutter(
    app: &mut App,
    times: impl IntoIterator<Item = f64>,
    limits: &Limits,
    mut show: impl FnMut(&mut World, f64),
) -> Result<bool, RenderError> {
    app.world_mut().insert_resource(OpenShutter::default());
    let times: Vec<f64> = times.into_iter().collect();
    let has_motion = app
        .world()
        .resource::<IntegratorSettings>()
        .layers
        .contains(Layer::Motion);
    let mut before = Vec::new();
    for time in times.iter().filter(|_| has_motion) {
        show(app.world_mut(), time - 1.0);
        if !load_to_completion(app, limits)? {
            return Ok(false);
        }
        let packed = app.world().resource::<PackedScene>();
        let frame = packed
            .scene
            .as_ref()
            .zip(packed.view.as_ref())
            .map(|(scene, view)| FrameBefore {
                geometry: scene.geometry.clone(),
                camera: view.camera,
            });
        before.push((packed.entity_of_instance.clone(), frame));
    }
    let mut before = before.into_iter();
    let mut moments = Vec::new();
    let mut first: Option<(Arc<[Entity]>, LightGroups)> = None;
    for time in times {
        show(app.world_mut(), time);
        if moments.is_empty() {
            // An edited hierarchy may give a picture other last bits.
            app.world_mut().resource_mut::<Dirty>().all_shapes();
        }
        if !load_to_completion(app, limits)? {
            return Ok(false);
        }
        let packed = app.world().resource::<PackedScene>();
        let shapes = packed.entity_of_instance.clone();
        // If shapes come or go between frames, they cannot be matched: nothing moves then.
        let frame_before = before.next().filter(|(known, _)| **known == *shapes);
        let Some(mut moment) = packed.scene.clone().zip(packed.view.clone()) else {
            continue;
        };
        moment.1.before = frame_before.and_then(|(_, frame)| frame);
        let first = first.get_or_insert_with(|| (shapes.clone(), moment.1.light_groups.clone()));
        let has_layers = moment.1.light_groups.count() > 0 || !moment.1.layers.is_empty();
        if has_layers && (*first.0 != *shapes || first.1 != moment.1.light_groups) {
            let message =
                "shapes or lights come or go while the shutter is open, so that their layers cannot be told apart";
            return Err(RenderError::Failed(message.to_owned()));
        }
        moments.push(moment);
    }
    // The guide of the last moment, for which `auto` chooses, so that a pilot may have learnt it or is about to.
    let extracted = app.world().resource::<Extracted>();
    let guide = (&extracted.scene, &extracted.guide);
    let open = OpenShutter {
        shutter: Shutter::new(&moments, guide).filter(|_| moments.len() > 1),
        before: moments.into_iter().next().and_then(|(_, view)| view.before),
    };
    app.world_mut().insert_resource(open);
    Ok(true)
}
