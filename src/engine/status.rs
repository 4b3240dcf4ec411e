//! The state of the engine in numbers. The application turns them into words.

use std::collections::VecDeque;
use std::time::Instant;

use bevy::prelude::*;
use serde::Serialize;

use super::stop_condition::StopReason;
use crate::render::auto::Choice;
use crate::render::clamp::BrightnessLimit;

/// The state of rendering, brought up to date once per frame.
#[derive(Resource, Clone, Debug)]
pub struct RenderStatus {
    /// The state of the engine.
    pub state: RenderState,
    /// Whether all files that the scene names are loaded, built and packed, so that the picture shows the current
    /// scene.
    pub is_up_to_date: bool,
    /// The change since a paused picture was begun; None if it is current, or if it is not paused.
    pub outdated: Option<Outdated>,
    /// The samples per pixel that the whole picture, or the rendered region, has.
    pub samples: u32,
    /// The number of the first sample: 0, unless the picture is a share.
    pub first: u32,
    /// The samples per pixel to reach.
    pub target: u32,
    /// The seconds of rendering to stop at; None is no limit.
    pub time_limit: Option<f32>,
    /// The relative noise to stop at; None is no limit.
    pub noise_target: Option<f32>,
    /// The limit that is reached.
    pub stopped_by: Option<StopReason>,
    /// The estimate of the picture's [relative noise](crate::render::noise::PictureNoise::relative); None before there
    /// is one.
    pub noise: Option<f32>,
    /// The choice of the integrator `auto`; None where another integrator is set.
    pub auto: Option<AutoStatus>,
    /// The size of the picture in pixels.
    pub size: UVec2,
    /// The size of the picture at full resolution in pixels, after [`RenderControl`](super::RenderControl::view_size).
    pub full_size: UVec2,
    /// Whether the picture shows the surroundings of the film as well.
    pub is_beyond_film: bool,
    /// Time spent on the samples of this picture; pauses do not count.
    pub seconds: f64,
    /// Rays traced for this picture, camera and shadow rays included.
    pub rays: u64,
    /// The guide of its paths; None if they have none.
    pub guide: Option<GuideStatus>,
    /// The rays per second, in millions.
    pub mrays_per_s: f64,
    /// The rays per second, in millions, that all threads would trace if the processors had no other load; 0 while that
    /// is unknown.
    pub undisturbed_mrays_per_s: f64,
    /// The camera samples per second, in millions.
    pub msamples_per_s: f64,
    /// The number of samples that were not finite and therefore dropped.
    pub invalid_samples: u64,
    /// The brightness limit of samples; None without a clamp, and until the limit is known.
    pub clamped: Option<BrightnessLimit>,
    /// The number of triangles of all instances.
    pub triangles: u64,
    /// The statistics of the hierarchies in use.
    pub bvh: BvhStatus,
    /// The number of meshes that shapes name and that are not loaded yet.
    pub meshes_loading: u32,
    /// The number of acceleration structures that are being built.
    pub builds_running: u32,
    /// Errors of the scene or the render, in words; the picture is made without the parts named here.
    pub errors: Vec<String>,
    /// The errors about parts that do not fit into the memory budget: the scene is valid, but the picture is not the
    /// one requested.
    pub shortages: Vec<String>,
    /// The time at which the picture last started again.
    pub last_restart: Instant,
    /// The time from a change to the first tile of the new picture in the film.
    pub latency: LatencyStats,
    /// The time from a change until a worker has finished that tile. The rest of `latency` is spent waiting for the
    /// window's next frame.
    pub response: LatencyStats,
}

impl Default for RenderStatus {
    fn default() -> Self {
        Self {
            state: RenderState::Idle,
            is_up_to_date: false,
            outdated: None,
            samples: 0,
            first: 0,
            target: 0,
            time_limit: None,
            noise_target: None,
            stopped_by: None,
            noise: None,
            auto: None,
            size: UVec2::ZERO,
            full_size: UVec2::ZERO,
            is_beyond_film: false,
            seconds: 0.0,
            rays: 0,
            guide: None,
            mrays_per_s: 0.0,
            undisturbed_mrays_per_s: 0.0,
            msamples_per_s: 0.0,
            invalid_samples: 0,
            clamped: None,
            triangles: 0,
            bvh: BvhStatus::default(),
            meshes_loading: 0,
            builds_running: 0,
            errors: Vec::new(),
            shortages: Vec::new(),
            last_restart: Instant::now(),
            latency: LatencyStats::default(),
            response: LatencyStats::default(),
        }
    }
}

/// The change that made a paused picture outdated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outdated {
    /// The scene was edited since, or is another one.
    Scene,
    /// The view has moved since.
    View,
}

/// The guide of a picture's paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct GuideStatus {
    /// The rays by which it was learnt, as part of [`RenderStatus::rays`]: 0 if it comes from an earlier picture or
    /// from a pilot.
    pub rays: u64,
    /// Its memory in bytes; 0 until it is learnt, and for scenes without paths to guide.
    pub bytes: u64,
}

/// The power of the number of samples with which noise falls: 0.5 for independent samples, and about this for well
/// distributed ones.
const FALL_OF_NOISE: f64 = 0.6;

impl RenderStatus {
    /// The finished fraction of the picture, from 0 to 1, by the limit that will be reached first.
    pub fn done(&self) -> f64 {
        let of_share = |samples: u32| f64::from(samples.saturating_sub(self.first));
        let by_samples = of_share(self.samples) / of_share(self.target).max(1.0);
        let by_time = self.time_limit.map_or(0.0, |limit| self.seconds / f64::from(limit));
        let by_noise = |(noise, target): (f32, f32)| f64::from(target / noise).powf(1.0 / FALL_OF_NOISE);
        let by_noise = self.noise.zip(self.noise_target).map_or(0.0, by_noise);
        by_samples.max(by_time).max(by_noise).clamp(0.0, 1.0)
    }

    /// Whether no samples are added because the picture is finished or paused.
    pub fn rests(&self) -> bool {
        matches!(self.state, RenderState::Done | RenderState::Paused)
    }

    /// The limit of noise, if the picture has one and has not reached it, even while it is rendering.
    pub fn missed_noise(&self) -> Option<f32> {
        let is_missed = |limit: &f32| self.noise.is_none_or(|noise| noise > *limit);
        // A black picture reaches it without an estimate of noise.
        let target = self.noise_target.filter(|_| self.stopped_by != Some(StopReason::Noise));
        target.filter(is_missed)
    }

    /// The estimated seconds until the picture is done, at the same speed; None while that is unknown.
    pub fn seconds_left(&self) -> Option<f64> {
        let done = self.done();
        let is_known = self.state == RenderState::Rendering && done > 0.0 && self.samples > 0;
        is_known.then(|| self.seconds * (1.0 / done - 1.0))
    }
}

/// What the integrator `auto` stands for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AutoStatus {
    /// The name of the integrator, as in files.
    pub integrator: &'static str,
    /// Whether its pilot is under way.
    #[serde(skip)]
    pub is_searching: bool,
    /// The choice. Before there is one it is path tracing, without a gain.
    #[serde(flatten)]
    pub choice: Choice,
    /// The rays that pilots have learnt the guide of the scene with. They are no part of [`RenderStatus::rays`].
    pub guide_rays: u64,
}

/// The state of the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RenderState {
    /// There is no camera to render from.
    #[default]
    Idle,
    /// The engine waits for meshes.
    Loading,
    /// The engine waits for acceleration structures.
    Building,
    /// The engine adds samples.
    Rendering,
    /// The user has paused; samples stay.
    Paused,
    /// The picture has the requested samples, or has reached another limit.
    Done,
    /// The last job failed; `errors` says why. The next change tries again.
    Failed,
}

/// The acceleration structures of the scene together (each mesh counted once).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BvhStatus {
    /// Time spent building what is now in use, milliseconds.
    pub build_ms: f64,
    /// The number of inner nodes.
    pub nodes: u64,
    /// The number of leaves with primitives.
    pub leaves: u64,
    /// The depth of the deepest mesh hierarchy plus that of the scene's.
    pub max_depth: u32,
    /// Surface area heuristic cost of the largest hierarchy.
    #[serde(rename = "sah")]
    pub sah_cost: f64,
    /// The memory in bytes.
    pub bytes: u64,
}

/// The last latencies, in milliseconds.
#[derive(Clone, Debug, Default)]
pub struct LatencyStats {
    recent: VecDeque<f32>,
}

impl LatencyStats {
    /// The number of latencies for the median and the percentile.
    pub(crate) const WINDOW: usize = 128;

    /// Adds a latency, and drops the oldest one beyond [`Self::WINDOW`].
    pub(crate) fn record(&mut self, milliseconds: f32) {
        if self.recent.len() == Self::WINDOW {
            self.recent.pop_front();
        }
        self.recent.push_back(milliseconds);
    }

    /// The number of recorded latencies, at most the window.
    pub fn len(&self) -> usize {
        self.recent.len()
    }

    /// Whether none was recorded.
    pub fn is_empty(&self) -> bool {
        self.recent.is_empty()
    }

    /// The median of the recorded latencies; None before the first.
    pub fn median_ms(&self) -> Option<f32> {
        self.quantile_ms(0.5)
    }

    /// The 95th percentile of the recorded latencies; None before the first.
    pub fn p95_ms(&self) -> Option<f32> {
        self.quantile_ms(0.95)
    }

    /// Nearest-rank quantile, `q` in [0, 1]; None before the first latency.
    fn quantile_ms(&self, q: f32) -> Option<f32> {
        let mut sorted: Vec<f32> = self.recent.iter().copied().collect();
        sorted.sort_by(f32::total_cmp);
        let rank = (q * sorted.len() as f32).ceil() as usize;
        sorted.get(rank.saturating_sub(1)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_of_the_last_window_only() {
        let mut stats = LatencyStats::default();
        assert_eq!(stats.median_ms(), None);
        (0..50).for_each(|_| stats.record(1000.0));
        (1..=LatencyStats::WINDOW).for_each(|i| stats.record(i as f32));
        assert_eq!(stats.len(), LatencyStats::WINDOW);
        assert_eq!(stats.median_ms(), Some(64.0));
        assert_eq!(stats.p95_ms(), Some(122.0));
        assert_eq!(stats.recent.back(), Some(&128.0));
    }
}
