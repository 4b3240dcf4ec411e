//! Changes of lamps during a picture: they become stronger or weaker, are switched off, and on again.

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

/// The location of light that the film has or had.
#[derive(Clone, Copy)]
enum Place {
    /// A layer of the film.
    Layer(usize),
    /// An index into the kept layers.
    Aside(usize),
    /// Nowhere: no light.
    Nowhere,
}

/// The new layers of light of a film.
struct Plan {
    /// For each new layer the location of its light now, and the factor on it.
    layers: Vec<(Place, Rgb)>,
    /// The layers of the film to be kept aside, with their lamps.
    gone: Vec<(usize, Vec<WeightedSource>)>,
}

impl Job {
    /// Continues with the existing samples if nothing in the scene has changed but the strengths of lights and the set
    /// of emitters, and gives the film the light of the new ones. False if that is not possible.
    pub fn relight(&mut self, wanted: &Wanted, stop: &StopCondition, film: &mut RenderFilm) -> bool {
        let view = wanted.view;
        // An exact picture must not depend on earlier changes, and adaptive sampling follows the noise of the old
        // light.
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
        // The estimated noise is that of the old light.
        (self.replicas, self.judged, self.round) = (None, None, (Rounds::default(), 0));
        self.noise_of_tiles = PictureNoise::of(&film.film, &self.tiles);
        self.note_noise();
        // Sampling would have been different for the new light, so an exact picture starts again.
        self.cuts.insert(0);
        true
    }

    /// Whether only the lamps differ, and the film can be given the light of others.
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

    /// The plan by which the film gets the light of the current lamps; None if the light of one of them is unknown.
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
        // Lamps that are switched off may be switched on again.
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

    /// The location of the lamps' light, and the factor on it. Layers that are used further are unmarked in `is_gone`.
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
                // A kept layer stays where it is.
                Rgb::ZERO => Some((Place::Nowhere, Rgb::ZERO)),
                factor => Some((Place::Aside(place), factor)),
            }
        })
    }

    /// The number of samples that every pixel has, also around a region.
    fn least_of_all(&self) -> u32 {
        self.done.iter().copied().min().unwrap_or(0)
    }

    /// Drops kept light with too few samples to be used again.
    pub(super) fn forget_lamps(&mut self) {
        let samples = self.least_of_all() as f32;
        let has_enough = |aside: &Aside| aside.light.samples as f32 * MOST_RISE >= samples;
        self.relighting.aside.retain(has_enough);
    }

    /// Drops all kept light of lamps that are off.
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

    /// Keeps the light of layers that the film loses, as far as memory allows.
    fn set_aside(&mut self, mut gone: Vec<(usize, Vec<WeightedSource>)>, film: &RenderFilm) {
        let pixels = u64::from(film.film.width()) * u64::from(film.film.height());
        // Layers of lamps that were off before are kept already.
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
