//! Lamps that change while a picture is made of their light: they become stronger or weaker, go out, and shine again.

use bevy::prelude::*;

use super::Job;
use super::lamps::{Aside, MOST_ASIDE, MOST_RISE, Strength, Wanted};
use crate::color::Rgb;
use crate::engine::film::RenderFilm;
use crate::engine::light_groups::LayerLamps;
use crate::engine::stop_condition::{Rounds, StopCondition};
use crate::light::{WeightedSource, gain};
use crate::memory;
use crate::render::film::{LightFrom, NewLayer, SetAside};
use crate::render::noise::PictureNoise;
use crate::render::scene::RenderScene;
use crate::render::view::{Integrator, View};

/// Where light is that a film had or has.
#[derive(Clone, Copy)]
enum Place {
    /// The layer of the film.
    Layer(usize),
    /// The place among what is set aside.
    Aside(usize),
    /// There is none.
    Nowhere,
}

/// The layers of light that a film is to have.
struct Plan {
    /// For each layer where its light is now, and the factor on it.
    layers: Vec<(Place, Rgb)>,
    /// The layers of the film that are set aside, with their lamps.
    gone: Vec<(usize, Vec<WeightedSource>)>,
}

impl Job {
    /// Goes on with the samples that it has if nothing has changed in the scene but how strong lights are and which
    /// emitters there are, and gives the film the light of these. False if that is not possible.
    pub fn relight(&mut self, wanted: &Wanted, stop: &StopCondition, film: &mut RenderFilm) -> bool {
        let view = wanted.view;
        // Exact pictures are what they would be without any change, and noise that decides where samples go is of the
        // old light.
        if stop.is_exact || stop.is_adaptive || !self.can_be_relit(wanted.scene, view, film) {
            return false;
        }
        let Some(plan) = self.plan(wanted) else {
            return false;
        };
        let strengths = plan
            .layers
            .iter()
            .map(|&(from, factor)| self.strength(from).changed(factor))
            .collect::<Vec<_>>();
        if !strengths.iter().all(|strength| strength.is_near_enough()) || !film.has_room_for(view) {
            return false;
        }
        self.pause();
        self.correct_noise(1.0, film);
        self.set_aside(plan.gone, film);
        let aside = &self.relighting.aside;
        let layers = plan.layers.iter().map(|&(from, factor)| match from {
            Place::Layer(layer) => (LightFrom::Layer(layer), factor),
            Place::Aside(place) => (LightFrom::Aside(&aside[place].light), factor),
            Place::Nowhere => (LightFrom::Nowhere, factor),
        });
        let layers: Vec<NewLayer> = layers.collect();
        film.relight(&layers, view, wanted.light_groups);
        self.relighting.strengths = strengths;
        let mut is_back = (0..).map(|own| {
            plan.layers
                .iter()
                .any(|(from, _)| matches!(from, Place::Aside(place) if *place == own))
        });
        self.relighting.aside.retain(|_| !is_back.next().unwrap_or_default());
        let too_many = self.relighting.aside.len().saturating_sub(MOST_ASIDE);
        self.relighting.aside.drain(..too_many);
        (self.scene, self.view) = (wanted.scene.clone(), view.clone());
        (self.lamps, self.light_groups) = (wanted.lamps.clone(), wanted.light_groups.clone());
        // What was known of the noise is of the other light.
        (self.replicas, self.judged, self.round) = (None, None, (Rounds::default(), 0));
        self.noise_of_tiles = PictureNoise::of(&film.film, &self.tiles);
        self.note_noise();
        // The same samples would not have been chosen for this light: an exact picture begins anew.
        self.cuts.insert(0);
        true
    }

    /// Whether its film can be given the light of other lamps, and nothing else differs.
    fn can_be_relit(&self, scene: &RenderScene, view: &View, film: &RenderFilm) -> bool {
        let with_other_lights = RenderScene {
            lights: self.scene.lights.clone(),
            ..scene.clone()
        };
        let with_other_groups = View {
            light_groups: self.view.light_groups.clone(),
            ..view.clone()
        };
        with_other_groups == self.view
            && with_other_lights.is_same(&self.scene)
            && matches!(view.integrator, Integrator::Path(_))
            && view.clamp.is_none()
            && self.shutter.is_none()
            && self.share.is_none()
            && self.failure.is_none()
            && film.is_of(self.begun)
            && self.done.iter().all(|&samples| samples > 0)
            && !self.adaptation.has_differences(&self.active)
            && film.film.can_be_relit()
    }

    /// How the film becomes that of the lamps that there are now; None if it does not know the light of one of them.
    fn plan(&self, wanted: &Wanted) -> Option<Plan> {
        let old = self.lamps.by_layer(&self.view.light_groups);
        let new = wanted.lamps.by_layer(&wanted.view.light_groups);
        let mut is_gone = vec![true; old.len()];
        let mut layers = Vec::new();
        for lamps in &new {
            layers.push(match lamps.sources.is_empty() {
                true => (Place::Nowhere, Rgb::ZERO),
                false => self.known_light(lamps, &old, &mut is_gone)?,
            });
        }
        // Lamps that are out may shine again.
        for &(from, factor) in &layers {
            if let Place::Layer(layer) = from
                && factor == Rgb::ZERO
            {
                is_gone[layer] = true;
            }
        }
        let gone = (0..).zip(&old).filter(|&(layer, _)| is_gone[layer]);
        let gone = gone.map(|(layer, lamps)| (layer, lamps.sources.iter().copied().cloned().collect()));
        Some(Plan {
            layers,
            gone: gone.collect(),
        })
    }

    /// Where the light of lamps is, and the factor on it. Layers that stay are no longer `is_gone`.
    fn known_light(&self, lamps: &LayerLamps, old: &[LayerLamps], is_gone: &mut [bool]) -> Option<(Place, Rgb)> {
        if let Some(layer) = old.iter().position(|old| old.owners == lamps.owners)
            && let Some(factor) = gain::common(&old[layer].sources, &lamps.sources)
        {
            is_gone[layer] = false;
            return Some((Place::Layer(layer), factor));
        }
        let mut aside = self.relighting.aside.iter().enumerate();
        aside.find_map(|(place, aside)| {
            let sources: Vec<&WeightedSource> = aside.sources.iter().collect();
            match gain::common(&sources, &lamps.sources)? {
                // It stays where it is.
                Rgb::ZERO => Some((Place::Nowhere, Rgb::ZERO)),
                factor => Some((Place::Aside(place), factor)),
            }
        })
    }

    /// The number of samples that every pixel has, around a region as well.
    fn least_of_all(&self) -> u32 {
        self.done.iter().copied().min().unwrap_or(0)
    }

    /// Lets go of light that is of too few samples to be taken up again.
    pub(super) fn forget_lamps(&mut self) {
        let samples = self.least_of_all() as f32;
        let has_enough = |aside: &Aside| aside.light.samples as f32 * MOST_RISE >= samples;
        self.relighting.aside.retain(has_enough);
    }

    /// Lets go of all light of lamps that do not shine.
    pub fn forget_all_lamps(&mut self) {
        self.relighting.aside.clear();
    }

    fn strength(&self, from: Place) -> Strength {
        match from {
            Place::Layer(layer) => self
                .relighting
                .strengths
                .get(layer)
                .copied()
                .unwrap_or(Strength::UNCHANGED),
            Place::Aside(place) => Strength {
                missed: self
                    .least_of_all()
                    .saturating_sub(self.relighting.aside[place].light.samples),
                ..self.relighting.aside[place].strength
            },
            Place::Nowhere => Strength {
                now: Rgb::ZERO,
                least: Rgb::ZERO,
                missed: 0,
            },
        }
    }

    /// Keeps the light of layers that the film will not have any more, as far as there is memory.
    fn set_aside(&mut self, mut gone: Vec<(usize, Vec<WeightedSource>)>, film: &RenderFilm) {
        let pixels = u64::from(film.film.width()) * u64::from(film.film.height());
        // Those that were out before are kept already.
        gone.retain(|(layer, lamps)| !lamps.is_empty() && self.strength(Place::Layer(*layer)).now != Rgb::ZERO);
        let too_many = gone.len().saturating_sub(MOST_ASIDE);
        for (layer, sources) in gone.drain(too_many..) {
            let Ok(memory) = memory::reserve(pixels * SetAside::BYTES_OF_PIXEL) else {
                return;
            };
            let strength = self.strength(Place::Layer(layer));
            let samples = self.least_of_all().saturating_sub(strength.missed);
            self.relighting.aside.push(Aside {
                sources,
                strength,
                light: film.film.set_aside(layer, samples),
                _memory: memory,
            });
        }
    }
}
