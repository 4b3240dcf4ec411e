//! The limits that end the gathering of light.

use std::time::Duration;

use super::lightmap::Lightmaps;

/// The samples of each texel where no limit is given.
pub const USUAL_SAMPLES: u32 = 64;
/// Noise is not judged by fewer samples.
const LEAST_SAMPLES: u32 = 16;

/// The limits that end the gathering of light; the one reached first counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BakeLimits {
    /// Samples of each texel. None means [`USUAL_SAMPLES`], or no limit if there is another one. Probes use this limit
    /// only.
    pub samples: Option<u32>,
    /// The time spent on lightmaps.
    pub time: Option<Duration>,
    /// The noise of lightmaps.
    pub noise: Option<f32>,
}

impl BakeLimits {
    /// The largest number of samples that a texel of a lightmap gets.
    pub fn target(&self) -> u32 {
        let is_open = self.time.is_some() || self.noise.is_some();
        self.samples.unwrap_or(if is_open { u32::MAX } else { USUAL_SAMPLES })
    }

    pub(super) fn are_reached(&self, samples: u32, spent: Duration, noise: Option<f32>) -> bool {
        let is_quiet = self.noise.zip(noise).is_some_and(|(limit, noise)| noise <= limit);
        let is_late = self.time.is_some_and(|limit| spent >= limit);
        samples >= LEAST_SAMPLES && is_quiet || samples > 0 && is_late
    }

    /// The finished share, from 0 to 1, by the limit that will be reached first.
    pub(super) fn done(&self, light: &Lightmaps, target: u32, spent: Duration, noise: Option<f32>) -> f64 {
        let by_samples = light.mean_samples() / f64::from(target.saturating_sub(light.first).max(1));
        let by_time = self
            .time
            .map_or(0.0, |limit| spent.as_secs_f64() / limit.as_secs_f64().max(1e-9));
        // The error of random samples falls with the square root of their number.
        let by_noise = self
            .noise
            .zip(noise)
            .map_or(0.0, |(limit, noise)| f64::from(limit / noise).powi(2));
        by_samples.max(by_time).max(by_noise).min(1.0)
    }
}
