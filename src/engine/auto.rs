//! The choice of the integrator `auto`.
//!
//! Jobs do not know `auto`: a view always has a concrete integrator, which is path tracing until a choice is made by
//! [`choosing`](super::choosing).

use bevy::prelude::*;

use super::control::RenderControl;
use crate::render::auto::{Budget, Choice, has_choice, pilot_view};
use crate::render::scene::RenderScene;
use crate::render::view::{Integrator, View};
use crate::scene::{IntegratorSettings, PathPlugin};

/// The last choice and its circumstances.
#[derive(Resource, Default)]
pub(super) struct AutoIntegrator(pub Option<(Seen, Choice)>);

/// The circumstances for which a choice was made.
#[derive(Clone)]
pub(super) struct Seen {
    pub scene: RenderScene,
    /// The view of the pilot.
    pub pilot: View,
    /// The budget of the pilot for a number of samples; None if the choice is for any number, as for a picture without
    /// an end.
    pub budget: Option<Budget>,
}

impl Seen {
    /// The circumstances of a choice for any number of samples.
    pub fn of(scene: &RenderScene, view: &View) -> Self {
        Self {
            scene: scene.clone(),
            pilot: pilot_view(view),
            budget: None,
        }
    }

    /// The circumstances of a choice for this number of samples per pixel.
    pub fn with_samples(scene: &RenderScene, view: &View, per_pixel: u32) -> Self {
        Self {
            budget: Some(Budget::of(samples_of(view, per_pixel))),
            ..Self::of(scene, view)
        }
    }

    /// Whether the scene and the view of the pilot are equal.
    fn is_same_sight(&self, other: &Self) -> bool {
        self.pilot == other.pilot && self.scene.is_same(&other.scene)
    }

    pub fn is_same(&self, other: &Self) -> bool {
        self.budget == other.budget && self.is_same_sight(other)
    }
}

/// Whether the integrator is chosen for the picture.
pub(super) fn is_auto(settings: &IntegratorSettings, control: &RenderControl) -> bool {
    settings.plugin == PathPlugin::Auto || settings.plugin == PathPlugin::Path && control.path_is_auto
}

/// The integrator before a choice is made: path tracing, through media if there are any.
pub(super) fn before_choice(scene: &RenderScene, view: &View) -> Integrator {
    let mut settings = view.integrator.settings();
    settings.media &= !scene.media.is_empty();
    Integrator::Path(settings)
}

/// The samples of a picture, summed over all pixels.
pub(super) fn samples_of(view: &View, per_pixel: u32) -> u64 {
    u64::from(view.width) * u64::from(view.height) * u64::from(per_pixel)
}

impl AutoIntegrator {
    fn known(&self, seen: &Seen) -> Option<&(Seen, Choice)> {
        self.0.as_ref().filter(|(known, _)| known.is_same_sight(seen))
    }

    /// The choice for a scene and a view; None before it is made. It may be for another number of samples.
    pub fn choice(&self, scene: &RenderScene, view: &View) -> Option<Choice> {
        self.known(&Seen::of(scene, view)).map(|(_, choice)| *choice)
    }

    /// Whether a picture with this number of samples per pixel waits for a choice: for the first one, or for another
    /// one because the pilot's budget has changed. So the choice does not depend on earlier numbers of samples.
    pub fn is_awaited(&self, scene: &RenderScene, view: &View, samples: u32) -> bool {
        let seen = Seen::with_samples(scene, view, samples);
        match self.known(&seen) {
            Some((known, _)) => known.budget.is_some() && known.budget != seen.budget,
            None => has_choice(scene, view, samples_of(view, samples)),
        }
    }
}
