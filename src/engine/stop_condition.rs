//! The condition under which a picture is finished: one of its limits is reached.

use bevy::math::Rect;

use super::control::RenderControl;
use crate::render::noise::adaptive::FIRST;
use crate::render::view::View;

/// The limits of a job. They may change while it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StopCondition {
    /// Samples per pixel, at least 1.
    pub samples: u32,
    /// Whether the number of samples must be exact, see [`RenderControl::exact_samples`].
    pub is_exact: bool,
    /// Seconds of rendering.
    pub seconds: Option<f32>,
    /// The relative noise.
    pub noise: Option<f32>,
    /// Whether sampling is adaptive.
    pub is_adaptive: bool,
    /// The region as in [`RenderControl`], or that of [the picture](Self::in_picture_of).
    pub region: Option<Rect>,
    /// The film in the picture, if its surroundings get no more samples than [`SAMPLES_AROUND_FILM`]; it is the region
    /// then.
    pub film: Option<Rect>,
}

/// The limit that a picture has reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The number of samples.
    Samples,
    /// The rendering time.
    Time,
    /// The noise.
    Noise,
}

/// Below this number of samples estimates of noise are unreliable: samples that all miss a rare bright light agree.
pub const FEWEST_FOR_NOISE: u32 = 16;

/// From this number of samples on, a picture without light counts as black.
const FEWEST_FOR_BLACK: u32 = 1024;
/// The samples per pixel that the surroundings of the film get where the whole film is shown.
pub const SAMPLES_AROUND_FILM: u32 = 16;
/// The shortest round is the samples so far divided by this.
const SHORTEST_ROUND: u32 = 8;

/// The settings that divide a picture into rounds: the limit of noise, and whether sampling is adaptive.
pub type Rounds = (Option<f32>, bool);

/// The relative noise at this number of samples; None if the picture is black.
#[derive(Clone, Copy, Debug)]
pub struct JudgedNoise {
    pub samples: u32,
    pub noise: Option<f32>,
    /// Whether it is corrected by replicas.
    pub is_corrected: bool,
}

/// The limits set by the sensor's film.
#[derive(Clone, Copy, Debug)]
pub struct FilmLimits {
    /// Samples per pixel.
    pub samples: u32,
    /// The noise to stop at.
    pub noise: Option<f32>,
    /// Whether sampling is adaptive.
    pub is_adaptive: bool,
}

impl StopCondition {
    /// The limits of the film apply where `control` has none.
    pub fn new(control: &RenderControl, film: FilmLimits) -> Self {
        let exact = control.exact_samples;
        Self {
            samples: exact.or(control.target_samples).unwrap_or(film.samples).max(1),
            is_exact: exact.is_some(),
            seconds: control.time_limit.filter(|_| exact.is_none()),
            noise: control
                .noise_target
                .or(film.noise)
                .filter(|noise| exact.is_none() && *noise > 0.0),
            is_adaptive: exact.is_none() && control.adaptive.unwrap_or(film.is_adaptive),
            region: control.region,
            film: None,
        }
    }

    /// The same condition with the region in the coordinates of this view's picture in place of the film's. With
    /// `is_dimmed` the surroundings of the film get few samples, unless all pixels must have an exact number.
    pub fn in_picture_of(self, view: &View, is_dimmed: bool) -> Self {
        let in_picture = |region: Rect| Rect {
            min: view.picture_of_film(region.min),
            max: view.picture_of_film(region.max),
        };
        let is_dimmed = is_dimmed && view.film_camera.is_some() && !self.is_exact;
        Self {
            region: self.region.map(in_picture),
            film: is_dimmed.then(|| in_picture(Rect::new(0.0, 0.0, 1.0, 1.0))),
            ..self
        }
    }

    /// The limit that is reached after `samples` per pixel, `seconds` of rendering and with a relative `noise` judged
    /// at that many samples; its inner None is a black picture.
    pub fn reached(&self, samples: u32, seconds: f64, noise: Option<Option<f32>>) -> Option<StopReason> {
        let in_time = self.seconds.is_none_or(|limit| seconds < f64::from(limit));
        let is_quiet = |limit| match noise {
            Some(Some(noise)) => samples >= FEWEST_FOR_NOISE && noise <= limit,
            Some(None) => samples >= FEWEST_FOR_BLACK,
            None => false,
        };
        if samples >= self.samples {
            Some(StopReason::Samples)
        } else if !in_time && samples > 0 {
            Some(StopReason::Time)
        } else if self.noise.is_some_and(is_quiet) {
            Some(StopReason::Noise)
        } else {
            None
        }
    }

    /// The end of the round of samples that begins after `done` per pixel. With a limit of noise all pixels have
    /// equally many samples at the end of a round, which depends on the picture alone, and there the noise is judged:
    /// so the same picture has the same samples on any number of threads. `noise` is the noise at `done`. Rounds become
    /// shorter towards the limit, as far as it can be predicted.
    pub fn round_end(&self, done: u32, noise: Option<f32>, is_adaptive: bool) -> u32 {
        let limit = match self.noise {
            Some(limit) => limit,
            None if is_adaptive => return done.saturating_mul(2).max(FIRST).min(self.samples),
            None => return self.samples,
        };
        if done < FEWEST_FOR_NOISE {
            return FEWEST_FOR_NOISE.min(self.samples);
        }
        // Noise falls at least with the root of the number of samples, and hardly faster than with that number.
        let growth = noise
            .filter(|noise| noise.is_finite())
            .map_or(2.0, |noise| f64::from(noise / limit).clamp(1.0, 2.0));
        let step = 1 << (done / SHORTEST_ROUND).ilog2();
        let end = (f64::from(done) * growth).ceil().min(f64::from(u32::MAX - step)) as u32;
        let end = end.max(done.saturating_add(1)).checked_next_multiple_of(step);
        end.unwrap_or(u32::MAX).min(self.samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits(samples: u32, noise: Option<f32>) -> FilmLimits {
        FilmLimits {
            samples,
            noise,
            is_adaptive: false,
        }
    }

    #[test]
    fn whichever_comes_first() {
        let control = RenderControl {
            target_samples: Some(64),
            time_limit: Some(2.0),
            noise_target: Some(0.1),
            ..RenderControl::default()
        };
        let stop = StopCondition::new(&control, limits(8, None));
        assert_eq!(stop.reached(63, 1.9, Some(Some(0.2))), None);
        assert_eq!(stop.reached(63, 1.9, None), None);
        assert_eq!(stop.reached(64, 1.0, None), Some(StopReason::Samples));
        assert_eq!(stop.reached(1, 2.0, None), Some(StopReason::Time));
        assert_eq!(stop.reached(16, 1.0, Some(Some(0.1))), Some(StopReason::Noise));
        // These are too few samples for an estimate.
        assert_eq!(stop.reached(15, 1.0, Some(Some(0.0))), None);
        // A demand for an exact number replaces all limits.
        let exact = RenderControl {
            exact_samples: Some(100),
            ..control
        };
        let exact = StopCondition::new(&exact, limits(8, None));
        assert_eq!(exact.reached(99, 1e9, Some(Some(0.0))), None);
        assert_eq!(exact.reached(100, 0.0, None), Some(StopReason::Samples));
        let film = StopCondition::new(&RenderControl::default(), limits(8, None));
        assert_eq!(film.reached(7, 1e9, Some(Some(0.0))), None);
        assert_eq!(film.reached(8, 0.0, None), Some(StopReason::Samples));
    }

    fn quiet(control: &RenderControl) -> StopCondition {
        StopCondition::new(control, limits(u32::MAX, Some(0.01)))
    }

    #[test]
    fn the_noise_of_the_file_counts_where_nothing_else_is_asked_for() {
        let control = |noise_target| RenderControl {
            noise_target,
            ..RenderControl::default()
        };
        let reached = |noise_target, noise| quiet(&control(noise_target)).reached(100, 0.0, Some(Some(noise)));
        assert_eq!(reached(None, 0.01), Some(StopReason::Noise));
        assert_eq!(reached(None, 0.011), None);
        assert_eq!(reached(Some(0.1), 0.05), Some(StopReason::Noise));
        assert_eq!(reached(Some(0.0), 0.0), None);
        // A black picture may not have found its light yet.
        assert_eq!(quiet(&control(None)).reached(1000, 0.0, Some(None)), None);
        assert_eq!(
            quiet(&control(None)).reached(1024, 0.0, Some(None)),
            Some(StopReason::Noise)
        );
    }

    #[test]
    fn rounds_end_where_the_noise_may_be_reached() {
        let stop = quiet(&RenderControl::default());
        assert_eq!([0, 3].map(|done| stop.round_end(done, Some(0.0), false)), [16; 2]);
        // Far from the limit the samples double, near it they grow by an eighth or sixteenth.
        assert_eq!(stop.round_end(16, Some(1.0), false), 32);
        assert_eq!(stop.round_end(64, None, false), 128);
        assert_eq!(stop.round_end(64, Some(0.0101), false), 72);
        assert_eq!(stop.round_end(4096, Some(0.0125), false), 5120);
        assert_eq!(stop.round_end(u32::MAX - 5, Some(0.02), false), u32::MAX);
        let short = StopCondition { samples: 20, ..stop };
        assert_eq!([0, 16].map(|done| short.round_end(done, Some(1.0), false)), [16, 20]);
        let plain = StopCondition { noise: None, ..short };
        assert_eq!(plain.round_end(0, None, false), 20);
        // Adaptive rounds double.
        let ends = [0, 64, 200].map(|done| StopCondition { samples: 300, ..plain }.round_end(done, None, true));
        assert_eq!(ends, [16, 128, 300]);
    }
}
