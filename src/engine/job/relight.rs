//! Lamps that change while a picture is made of their light: they become stronger or weaker, go out, and shine again.

use bevy::prelude::*;

use super::Job;
use crate::color::Rgb;
use crate::engine::extract::Extracted;
use crate::engine::film::RenderFilm;
use crate::engine::light_groups::LayerLamps;
use crate::engine::stop_condition::{Rounds, StopCondition};
use crate::light::{WeightedSource, gain};
use crate::memory::{self, Reservation};
use crate::render::film::{LightFrom, NewLayer, SetAside};
use crate::render::noise::PictureNoise;
use crate::render::scene::RenderScene;
use crate::render::view::{Integrator, View};

/// The light of a layer may be so many times as strong as it was for some of its samples, and may have so many times fewer samples than there are: a weak
/// lamp gets few samples, whose noise grows with it.
const MOST_RISE: f32 = 4.0;

/// The most layers of light that are set aside.
const MOST_ASIDE: usize = 4;

/// How many times as strong the light of a layer is as at the beginning, and the least that it was.
#[derive(Clone, Copy, Debug)]
struct Strength {
    now: Rgb,
    least: Rgb,
}

impl Strength {
    const UNCHANGED: Self = Self {
        now: Rgb::ONE,
        least: Rgb::ONE,
    };

    fn changed(self, factor: Rgb) -> Self {
        let now = self.now * factor;
        let least = self.least.min(now);
        Self { now, least }
    }

    fn is_near_enough(self) -> bool {
        self.now.cmple(MOST_RISE * self.least).all()
    }
}

/// The light of lamps that do not shine.
struct Aside {
    sources: Vec<WeightedSource>,
    strength: Strength,
    light: SetAside,
    _memory: Reservation,
}

/// What has become of the lamps of a job since it began.
#[derive(Default)]
pub(super) struct Relighting {
    /// By layer of light; empty while all is as it was.
    strengths: Vec<Strength>,
    /// The latest is the last.
    aside: Vec<Aside>,
}

/// Where light is that a film had or has.
#[derive(Clone, Copy)]
enum Place {
    /// The layer of the film.
    Layer(usize),
    /// The place among what is set aside.
    Aside(usize),
}

/// The layers of light that a film is to have.
struct Plan {
    /// For each layer where its light is now, and the factor on it.
    layers: Vec<(Place, Rgb)>,
    /// The layers of the film that are set aside, with their lamps.
    gone: Vec<(usize, Vec<WeightedSource>)>,
}

impl Job {
    /// Goes on with the samples that it has if nothing has changed in the scene but how strong lights are and which emitters there are, and gives the film the
    /// light of these. False if that is not possible.
    pub fn relight(&mut self, extracted: &Extracted, view: &View, stop: &StopCondition, film: &mut RenderFilm) -> bool {
        // Exact pictures are what they would be without any change, and noise that decides where samples go is of the old light.
        if stop.is_exact
            || stop.is_adaptive
            || extracted.has_glowing_media()
            || !self.can_be_relit(&extracted.scene, view, film)
        {
            return false;
        }
        let Some(plan) = self.plan(extracted, view) else {
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
        });
        let layers: Vec<NewLayer> = layers.collect();
        film.relight(&layers, view, &extracted.light_groups);
        self.relighting.strengths = strengths;
        let mut is_back = (0..).map(|own| {
            plan.layers
                .iter()
                .any(|(from, _)| matches!(from, Place::Aside(place) if *place == own))
        });
        self.relighting.aside.retain(|_| !is_back.next().unwrap_or_default());
        let too_many = self.relighting.aside.len().saturating_sub(MOST_ASIDE);
        self.relighting.aside.drain(..too_many);
        (self.scene, self.view) = (extracted.scene.clone(), view.clone());
        (self.lamps, self.light_groups) = (extracted.lamps.clone(), extracted.light_groups.clone());
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
    fn plan(&self, extracted: &Extracted, view: &View) -> Option<Plan> {
        let old = self.lamps.by_layer(&self.view.light_groups);
        let new = extracted.lamps.by_layer(&view.light_groups);
        let mut is_gone = vec![true; old.len()];
        let mut layers = Vec::new();
        for lamps in &new {
            layers.push(match lamps.sources.is_empty() {
                true => (Place::Layer(0), Rgb::ZERO),
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
        let has_enough =
            |aside: &(usize, &Aside)| aside.1.light.samples as f32 * MOST_RISE >= self.least_samples() as f32;
        let mut aside = self.relighting.aside.iter().enumerate().filter(has_enough);
        aside.find_map(|(place, aside)| {
            let sources: Vec<&WeightedSource> = aside.sources.iter().collect();
            Some((Place::Aside(place), gain::common(&sources, &lamps.sources)?))
        })
    }

    fn strength(&self, from: Place) -> Strength {
        match from {
            Place::Layer(layer) => self
                .relighting
                .strengths
                .get(layer)
                .copied()
                .unwrap_or(Strength::UNCHANGED),
            Place::Aside(place) => self.relighting.aside[place].strength,
        }
    }

    /// Keeps the light of layers that the film will not have any more, as far as there is memory.
    fn set_aside(&mut self, gone: Vec<(usize, Vec<WeightedSource>)>, film: &RenderFilm) {
        let pixels = u64::from(film.film.width()) * u64::from(film.film.height());
        for (layer, sources) in gone {
            let strength = self.strength(Place::Layer(layer));
            // It was out before.
            if strength.now == Rgb::ZERO {
                continue;
            }
            let Ok(memory) = memory::reserve(pixels * SetAside::BYTES_OF_PIXEL) else {
                return;
            };
            self.relighting.aside.push(Aside {
                sources,
                strength,
                light: film.film.set_aside(layer),
                _memory: memory,
            });
        }
    }
}
