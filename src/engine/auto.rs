//! What the integrator `auto` stands for.
//!
//! Jobs know nothing of it: a view has an integrator at any time, and that is path tracing until there is a choice. [`choosing`](super::choosing) makes the choice.

use bevy::prelude::*;

use super::control::RenderControl;
use crate::render::auto::{Choice, has_choice, pilot_view};
use crate::render::scene::RenderScene;
use crate::render::view::{Integrator, View};
use crate::scene::{IntegratorSettings, PathPlugin};

/// The last choice.
#[derive(Resource, Default)]
pub(super) struct AutoIntegrator(pub Option<(Seen, Choice)>);

/// What a choice is for.
#[derive(Clone)]
pub(super) struct Seen {
    pub scene: RenderScene,
    /// The view of the pilot.
    pub pilot: View,
}

impl Seen {
    pub fn of(scene: &RenderScene, view: &View) -> Self {
        Self {
            scene: scene.clone(),
            pilot: pilot_view(view),
        }
    }

    pub fn is_same(&self, other: &Self) -> bool {
        self.pilot == other.pilot && self.scene.is_same(&other.scene)
    }
}

/// Whether the integrator is chosen for the picture.
pub(super) fn is_auto(settings: &IntegratorSettings, control: &RenderControl) -> bool {
    settings.plugin == PathPlugin::Auto || settings.plugin == PathPlugin::Path && control.path_is_auto
}

/// The integrator before there is a choice: path tracing, through media where there are any.
pub(super) fn before_choice(scene: &RenderScene, view: &View) -> Integrator {
    let mut settings = view.integrator.settings();
    settings.media &= !scene.media.is_empty();
    Integrator::Path(settings)
}

/// The samples of a picture over all pixels.
pub(super) fn samples_of(view: &View, per_pixel: u32) -> u64 {
    u64::from(view.width) * u64::from(view.height) * u64::from(per_pixel)
}

impl AutoIntegrator {
    /// The choice for a scene and a view; None while there is none.
    pub fn choice(&self, scene: &RenderScene, view: &View) -> Option<Choice> {
        let seen = Seen::of(scene, view);
        let known = self.0.as_ref().filter(|(known, _)| known.is_same(&seen));
        known.map(|(_, choice)| *choice)
    }

    /// Whether a picture with so many samples per pixel waits for a choice.
    pub fn is_awaited(&self, scene: &RenderScene, view: &View, samples: u32) -> bool {
        has_choice(scene, view, samples_of(view, samples)) && self.choice(scene, view).is_none()
    }
}
