//! Gathers light in rounds until a limit is reached, and shows how far it is.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use rayon::ThreadPool;
use sunroom::bake::gathering::{Gathering, Site};
use sunroom::bake::lightmap::Lightmaps;
use sunroom::bake::texels::Texels;
use sunroom::engine::RenderStatus;

use crate::cli::progress::Progress;

/// The first round; each one doubles the samples up to the largest round.
const FIRST_ROUND: u32 = 4;
const LARGEST_ROUND: u32 = 32;

/// What ends it.
pub struct Until {
    /// No progress is shown.
    pub quiet: bool,
    /// Samples of each texel.
    pub target: u32,
    pub time: Option<Duration>,
    pub noise: Option<f32>,
}

/// Gathers light until a limit is reached, or an interrupt ends it after some samples.
pub fn gathered<S: Site>(
    until: &Until,
    gathering: &Gathering,
    texels: &Texels<S>,
    cancel: &AtomicBool,
    pool: &ThreadPool,
) -> Lightmaps {
    let target = until.target;
    let mut light = Lightmaps::new(texels.texels.len());
    let mut progress = Progress::new(until.quiet, until.time);
    let begin = Instant::now();
    let is_late = |begin: Instant| until.time.is_some_and(|time: Duration| begin.elapsed() >= time);
    while light.samples < target {
        let round = light
            .samples
            .clamp(FIRST_ROUND, LARGEST_ROUND)
            .min(target - light.samples);
        if !pool.install(|| light.add_round(gathering, texels, round, cancel, |_| {})) {
            break;
        }
        let seconds = begin.elapsed().as_secs_f64();
        let status = RenderStatus {
            samples: light.samples,
            target,
            seconds,
            time_limit: until.time.map(|time| time.as_secs_f32()),
            noise: light.noise(),
            noise_target: until.noise,
            msamples_per_s: 1e-6 * f64::from(light.samples) * texels.texels.len() as f64 / seconds.max(1e-9),
            ..RenderStatus::default()
        };
        let is_quiet_enough = until
            .noise
            .zip(status.noise)
            .is_some_and(|(target, noise)| noise <= target);
        let is_last = is_quiet_enough || is_late(begin) || light.samples >= target;
        match is_last {
            true => progress.finish(&status),
            false => progress.update(&status),
        }
        if is_last {
            break;
        }
    }
    light
}
