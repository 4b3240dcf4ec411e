//! What the integrator `auto` stands for.
//!
//! Jobs know nothing of it: a view has an integrator at any time, and that is path tracing until there is a choice.
//! [`choosing`](super::choosing) makes the choice.

use bevy::prelude::*;

use super::control::RenderControl;
use crate::render::auto::{Budget, Choice, has_choice, pilot_view};
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
    /// What the pilot could do for the number of samples; None where the choice is for any number, as that of a
    /// picture that goes on.
    pub budget: Option<Budget>,
}

impl Seen {
    /// What a choice is for that holds for any number of samples.
    pub fn of(scene: &RenderScene, view: &View) -> Self {
        Self {
            scene: scene.clone(),
            pilot: pilot_view(view),
            budget: None,
        }
    }

    /// What the choice for so many samples per pixel is for.
    pub fn with_samples(scene: &RenderScene, view: &View, per_pixel: u32) -> Self {
        Self {
            budget: Some(Budget::of(samples_of(view, per_pixel))),
            ..Self::of(scene, view)
        }
    }

    /// Whether the scene and the view of the pilot are the same.
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
    fn known(&self, seen: &Seen) -> Option<&(Seen, Choice)> {
        self.0.as_ref().filter(|(known, _)| known.is_same_sight(seen))
    }

    /// The choice for a scene and a view; None while there is none. It may have been made for another number of
    /// samples.
    pub fn choice(&self, scene: &RenderScene, view: &View) -> Option<Choice> {
        self.known(&Seen::of(scene, view)).map(|(_, choice)| *choice)
    }

    /// Whether a picture with so many samples per pixel waits for a choice: for the first one, or for another one where
    /// the pilot can do more or less than it could. So what is chosen does not depend on how many samples were
    /// asked for before.
    pub fn is_awaited(&self, scene: &RenderScene, view: &View, samples: u32) -> bool {
        let seen = Seen::with_samples(scene, view, samples);
        match self.known(&seen) {
            Some((known, _)) => known.budget.is_some() && known.budget != seen.budget,
            None => has_choice(scene, view, samples_of(view, samples)),
        }
    }
}
