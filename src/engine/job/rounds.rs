//! The rounds of a job: where they end, and the noise that is judged at their ends with the help of replicas.

use super::Job;
use crate::engine::film::RenderFilm;
use crate::engine::schedule::WorkQueue;
use crate::engine::stop_condition::{FEWEST_FOR_NOISE, JudgedNoise, Rounds, StopCondition};
use crate::render::noise::PictureNoise;
use crate::render::noise::replicas::{Missing, Replicas, has_replicas};
use crate::render::tile::Tile;

/// The least samples at the end of a round in which blocks differ.
const LEAST_ROUND: u32 = 32;

impl Job {
    /// The noise that was judged when all pixels of the region had this number of samples.
    pub(super) fn judged_at(&self, samples: u32) -> Option<JudgedNoise> {
        self.judged.filter(|judged| judged.samples == samples)
    }

    /// Whether all pixels of the region have this number of samples.
    pub(super) fn are_equal(&self, samples: u32) -> bool {
        self.active.iter().all(|&index| self.done[index] == samples)
    }

    /// The work until the end of the current round, or of the next one.
    pub(super) fn next_queue(
        &mut self,
        stop: &StopCondition,
        asked: Rounds,
        film: &mut RenderFilm,
        previews: &[usize],
        step: u32,
    ) -> WorkQueue {
        let done = self.least_samples();
        // An interrupted round continues to its own end. Any other end would depend on the time of the interruption,
        // and so would the picture.
        let (asked_then, end) = self.round;
        let goes_on = asked_then == asked && end != u32::MAX && done < end;
        if !goes_on && previews.is_empty() && asked.0.is_some() {
            let missing = self.missing_replicas(done, film);
            if !missing.is_empty() {
                return WorkQueue::of_replicas(&missing);
            }
            self.judge(film);
        }
        if !goes_on {
            self.begin_round(done, stop, asked, film);
        }
        let tiles: Vec<(usize, u32)> = self.active.iter().map(|&index| (index, self.done[index])).collect();
        let queue = WorkQueue::new(&tiles, stop.samples.min(self.round.1), previews, step);
        let rounds = self.adaptation.rounds();
        let with_rounds = |&index: &usize| Some((index, rounds[index].clone()?));
        queue.set_rounds(self.active.iter().filter_map(with_rounds));
        queue
    }

    /// Plans the round after `done` samples.
    fn begin_round(&mut self, done: u32, stop: &StopCondition, asked: Rounds, film: &RenderFilm) {
        let under_way = self
            .active
            .iter()
            .map(|&index| self.adaptation.on_the_way_to(index, self.done[index]));
        let most = under_way.max().unwrap_or(0);
        // The moments of a shutter are shared out evenly, so that sampling is uniform with one.
        let is_adaptive = stop.is_adaptive && self.shutter.is_none() && done == most;
        let noise = self.judged_at(done).and_then(|judged| judged.noise);
        let has_differences = self.adaptation.has_differences(&self.active);
        let end = match done < most {
            // If pixels differ in their samples, the first round makes them equal.
            true => stop.samples.min(most),
            false => stop.round_end(done, noise, is_adaptive),
        };
        // Tiles with differences continue by rounds, even if no setting asks for them.
        let end = if has_differences {
            end.min(most.max(LEAST_ROUND).saturating_mul(2))
        } else {
            end
        };
        let is_divided = asked.0.is_some() || is_adaptive || has_differences;
        self.round = (asked, if is_divided { end } else { u32::MAX });
        if is_divided {
            self.adaptation
                .plan(&self.active, &self.done, end, is_adaptive, &film.film);
        }
    }

    /// Whether replicas measure the noise at this number of samples, if there is a limit of noise. A share has no such
    /// limit.
    pub(super) fn has_replicas_at(&self, samples: u32) -> bool {
        samples >= FEWEST_FOR_NOISE && self.share.is_none() && has_replicas(self.view.integrator)
    }

    /// The samples that replicas lack to measure the noise once all pixels of the region have `done` samples.
    fn missing_replicas(&mut self, done: u32, film: &RenderFilm) -> Vec<Missing> {
        if !self.has_replicas_at(done) || !self.are_equal(done) {
            return Vec::new();
        }
        let replicas = self.replicas.take();
        let replicas = replicas.unwrap_or_else(|| Replicas::choose(&film.film, &self.active_tiles(), self.view.seed));
        self.replicas.insert(replicas).missing(&film.film)
    }

    fn active_tiles(&self) -> Vec<Tile> {
        self.active.iter().map(|&index| self.tiles[index]).collect()
    }

    /// Judges the noise once all pixels of the region have the same number of samples, and the replicas, if any, as
    /// many. The tiles are read in a fixed order, so that the result does not depend on the threads.
    pub(super) fn judge(&mut self, film: &mut RenderFilm) {
        let samples = self.least_samples();
        if !self.are_equal(samples) || samples == 0 {
            return;
        }
        let replicas = self.replicas.as_ref();
        let replicas = replicas.filter(|replicas| self.has_replicas_at(samples) && replicas.are_whole(&film.film));
        if self
            .judged_at(samples)
            .is_some_and(|judged| judged.is_corrected || replicas.is_none())
        {
            return;
        }
        // Within a round it depends on the threads when tiles are equal, and a limit of noise must not.
        let ((noise_asked, _), end) = self.round;
        if noise_asked.is_some() && replicas.is_none() && samples != end {
            return;
        }
        let mut noise = PictureNoise::of(&film.film, &self.active_tiles());
        noise.correct(self.noise_of_tiles.correction());
        if let Some(replicas) = replicas {
            noise.correct(replicas.correction(&film.film, &noise));
        }
        self.judged = Some(JudgedNoise {
            samples,
            noise: noise.relative(0..self.active.len()),
            is_corrected: replicas.is_some(),
        });
        self.correct_noise(noise.correction(), film);
    }

    /// Multiplies all later estimates of noise from samples by `correction`.
    pub(super) fn correct_noise(&mut self, correction: f32, film: &mut RenderFilm) {
        self.noise_of_tiles.correct(correction);
        if self.replicas.is_some() && film.film.correct_errors(correction) {
            self.active.iter().for_each(|&index| film.mark(self.tiles[index]));
        }
    }

    /// Updates the noise: the judged one, or an estimate between rounds.
    pub(super) fn note_noise(&mut self) {
        let samples = self.least_samples();
        let judged = self.judged_at(samples).filter(|_| self.are_equal(samples));
        let known = || self.noise_of_tiles.relative(self.active.iter().copied());
        self.noise = judged.map_or_else(known, |judged| judged.noise);
    }
}
