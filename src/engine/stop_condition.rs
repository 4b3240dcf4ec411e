//! The condition under which a picture is finished: one of its limits is reached.

use bevy::math::Rect;

use super::control::RenderControl;

/// The limits of a job. They may change while it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StopCondition {
    /// Samples per pixel, at least 1.
    pub samples: u32,
    /// Whether neither more nor fewer samples are wanted, see [`RenderControl::exact_samples`].
    pub is_exact: bool,
    seconds: Option<f32>,
    noise: Option<f32>,
    /// The region as in [`RenderControl`].
    pub region: Option<Rect>,
}

/// The limit that a picture has reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The samples asked for.
    Samples,
    /// The time allowed.
    Time,
    /// The noise asked for.
    Noise,
}

/// Below this number of samples the spread says little: few samples of a rare bright thing have missed it, and agree.
const FEWEST_FOR_NOISE: u32 = 16;

impl StopCondition {
    /// `sample_count` is the film's, which counts where `control` does not say.
    pub fn new(control: &RenderControl, sample_count: u32) -> Self {
        let exact = control.exact_samples;
        Self {
            samples: exact.or(control.target_samples).unwrap_or(sample_count).max(1),
            is_exact: exact.is_some(),
            seconds: control.time_limit.filter(|_| exact.is_none()),
            noise: control.noise_target.filter(|_| exact.is_none()),
            region: control.region,
        }
    }

    /// The limit that is reached after `samples` per pixel, `seconds` of rendering and with an estimated relative `noise`.
    pub fn reached(&self, samples: u32, seconds: f64, noise: Option<f32>) -> Option<StopReason> {
        let in_time = self.seconds.is_none_or(|limit| seconds < f64::from(limit));
        let is_quiet = |limit| samples >= FEWEST_FOR_NOISE && noise.is_some_and(|noise| noise <= limit);
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whichever_comes_first() {
        let control = RenderControl {
            target_samples: Some(64),
            time_limit: Some(2.0),
            noise_target: Some(0.1),
            ..RenderControl::default()
        };
        let stop = StopCondition::new(&control, 8);
        assert_eq!(stop.reached(63, 1.9, Some(0.2)), None);
        assert_eq!(stop.reached(63, 1.9, None), None);
        assert_eq!(stop.reached(64, 1.0, None), Some(StopReason::Samples));
        assert_eq!(stop.reached(1, 2.0, None), Some(StopReason::Time));
        assert_eq!(stop.reached(16, 1.0, Some(0.1)), Some(StopReason::Noise));
        // These are too few samples to know.
        assert_eq!(stop.reached(15, 1.0, Some(0.0)), None);
        // A demand for an exact number takes the place of all limits.
        let exact = RenderControl {
            exact_samples: Some(100),
            ..control
        };
        let exact = StopCondition::new(&exact, 8);
        assert_eq!(exact.reached(99, 1e9, Some(0.0)), None);
        assert_eq!(exact.reached(100, 0.0, None), Some(StopReason::Samples));
        let film = StopCondition::new(&RenderControl::default(), 8);
        assert_eq!(film.reached(7, 1e9, Some(0.0)), None);
        assert_eq!(film.reached(8, 0.0, None), Some(StopReason::Samples));
    }
}
