//! Lamps that become stronger or weaker while a picture is made of their light.

use std::sync::Arc;

use super::Job;
use crate::color::Rgb;
use crate::engine::extract::Extracted;
use crate::engine::film::RenderFilm;
use crate::engine::stop_condition::{Rounds, StopCondition};
use crate::light::LightId;
use crate::light::gain::is_about;
use crate::render::noise::PictureNoise;
use crate::render::scene::RenderScene;
use crate::render::view::{Integrator, View};

/// The light of a group may be so many times as strong as it was for some of its samples: a weak lamp gets few samples, whose noise grows with it.
const MOST_RISE: f32 = 4.0;

impl Job {
    /// Goes on with the samples that it has if nothing has changed in the scene but the strength of lights, and multiplies their light in the film. False if
    /// that is not possible.
    pub fn relight(
        &mut self,
        extracted: &mut Extracted,
        view: &View,
        stop: &StopCondition,
        film: &mut RenderFilm,
    ) -> bool {
        // Exact pictures are what they would be without any change, and noise that decides where samples go is of the old light.
        if stop.is_exact || stop.is_adaptive || extracted.has_glowing_media() {
            return false;
        }
        let gains = extracted.gains.as_deref();
        let factors = gains.and_then(|gains| self.factors(gains, &extracted.scene, view, film));
        let Some(factors) = factors.filter(|factors| self.note_strengths(factors)) else {
            return false;
        };
        self.pause();
        self.correct_noise(1.0, film);
        self.scene = extracted.scene.clone();
        extracted.gains = Some(Vec::new());
        film.relight(factors);
        // What was known of the noise is of the other light.
        (self.replicas, self.judged, self.round) = (None, None, (Rounds::default(), 0));
        self.noise_of_tiles = PictureNoise::new(self.tiles.len());
        for (index, &tile) in self.tiles.iter().enumerate() {
            self.noise_of_tiles.update(index, &film.film, tile);
        }
        self.note_noise();
        // The same samples would not have been chosen for this light: an exact picture begins anew.
        self.cuts.insert(0);
        true
    }

    /// Follows how strong the light of each group is, beside when its samples were made. False if it has become too strong for some of them.
    fn note_strengths(&mut self, factors: &[Rgb]) -> bool {
        self.strengths.resize(factors.len(), [Rgb::ONE; 2]);
        for ([now, least], &factor) in self.strengths.iter_mut().zip(factors) {
            *now *= factor;
            *least = least.min(*now);
        }
        let is_near = |[now, least]: &[Rgb; 2]| now.cmple(MOST_RISE * *least).all();
        self.strengths.iter().all(is_near)
    }

    /// The factors on the layers of the film, with which it is the picture of this scene and view.
    fn factors(&self, gains: &[Rgb], scene: &RenderScene, view: &View, film: &RenderFilm) -> Option<Arc<[Rgb]>> {
        let is_only_stronger = RenderScene {
            lights: self.scene.lights.clone(),
            ..scene.clone()
        };
        let is_possible = *view == self.view
            && is_only_stronger.is_same(&self.scene)
            && matches!(view.integrator, Integrator::Path(_))
            && view.clamp.is_none()
            && self.shutter.is_none()
            && self.share.is_none()
            && self.failure.is_none()
            && !gains.is_empty()
            && film.is_of(self.begun)
            && self.done.iter().all(|&samples| samples > 0)
            && !self.adaptation.has_differences(&self.active)
            && film.film.can_be_relit();
        if !is_possible {
            return None;
        }
        let groups = &view.light_groups;
        let mut factors = vec![None; groups.count().max(1)];
        for (light, &gain) in gains.iter().enumerate() {
            let group = match groups.count() {
                0 => 0,
                _ => groups.group(LightId(light as u32))?,
            };
            let factor = factors.get_mut(group)?;
            // Lights that share a layer cannot be told apart.
            if !is_about(*factor.get_or_insert(gain), gain) {
                return None;
            }
        }
        Some(factors.into_iter().map(|factor| factor.unwrap_or(Rgb::ONE)).collect())
    }
}
