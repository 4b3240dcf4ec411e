//! The progress that a bake reports, and the pace of the reports.

use std::ops::Range;
use std::panic::resume_unwind;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use rayon::ThreadPool;

use super::unwrap::Told;

/// The step that is being done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// Probes are placed, and the probes of the scene are checked.
    #[default]
    PlacingProbes,
    /// The level is unwrapped.
    Unwrapping,
    /// Light of the lightmaps is gathered.
    Lightmaps,
    /// The lightmaps are finished.
    FinishingLightmaps,
    /// Light of this probe, an index into [`super::blueprint::Blueprint::probes`], is gathered.
    Probe(usize),
    /// This probe is finished: denoised, and filtered for each roughness.
    FinishingProbe(usize),
}

/// A sentence, without a full stop, about the number of samples that are not finite; None if there are none.
pub fn about_invalid(samples: u64) -> Option<String> {
    match samples {
        0 => None,
        1 => Some("1 sample is not finite, which counts as black".to_owned()),
        samples => Some(format!("{samples} samples are not finite, which count as black")),
    }
}

/// The progress of a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// The step that is being done.
    pub stage: Stage,
    /// The finished share of the stage, from 0 to 1.
    pub done: f64,
    /// The time that the stage has taken, in all runs of the job.
    pub spent: Duration,
    /// The state of the light, while light is gathered.
    pub gathered: Option<Gathered>,
}

/// The progress of gathering light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gathered {
    /// The number of samples that every texel has.
    pub samples: u32,
    /// The mean number of samples of a texel: in the middle of a round some have more than others.
    pub mean_samples: f64,
    /// The number of samples asked for; [`u32::MAX`] is no limit.
    pub target: u32,
    /// The noise; None if unknown.
    pub noise: Option<f32>,
    /// Samples of all texels per second.
    pub samples_per_second: f64,
}

/// The threads, the cancel flag and the progress callback of some work.
pub struct Work<'a> {
    /// The threads that do the work.
    pub pool: &'a ThreadPool,
    /// Ends it when set.
    pub cancel: &'a AtomicBool,
    /// Gets the finished share, from 0 to 1, on the thread that asks for the work.
    pub watch: &'a mut dyn FnMut(f64),
}

impl Work<'_> {
    /// Does `act` as this range of the progress of the work.
    pub(super) fn part<T>(&mut self, part: Range<f64>, act: impl FnOnce(&mut Work) -> T) -> T {
        let watch = &mut *self.watch;
        act(&mut Work {
            pool: self.pool,
            cancel: self.cancel,
            watch: &mut |done| watch(part.start + done * (part.end - part.start)),
        })
    }
}

/// Does work on another thread, and passes its latest report to `watch` on this thread, at least every fifth of a
/// second after the first report.
pub(super) fn watched<T: Send>(work: impl FnOnce(Told) -> T + Send, watch: &mut dyn FnMut(f64, &str)) -> T {
    std::thread::scope(|scope| {
        let (teller, told) = mpsc::channel();
        let tell = move |done: f64, words: &str| drop(teller.send((done, words.to_owned())));
        let thread = scope.spawn(move || work(&tell));
        let mut last = None;
        loop {
            match told.recv_timeout(TICK) {
                Ok(news) => last = told.try_iter().last().or(Some(news)),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if let Some((done, words)) = &last {
                watch(*done, words);
            }
        }
        thread.join().unwrap_or_else(|panic| resume_unwind(panic))
    })
}

/// The interval at which this thread checks the work on another thread.
const TICK: Duration = Duration::from_millis(200);

/// The number of texel blocks in a batch, adapted so that a batch takes about half a second.
pub(crate) struct Pace {
    blocks: usize,
    threads: usize,
}

/// The range of times that a batch should take.
const SHORTEST: Duration = Duration::from_millis(250);
const LONGEST: Duration = Duration::from_secs(1);

impl Pace {
    /// The initial pace for this number of threads.
    pub fn new(threads: usize) -> Self {
        Self { blocks: 1, threads }
    }

    /// The number of blocks in a batch, at least one for each thread.
    pub fn blocks(&self) -> usize {
        self.blocks * self.threads
    }

    /// Does a batch, and adapts the pace to its time.
    pub fn measure<T>(&mut self, work: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let result = work();
        let time = begin.elapsed();
        if time < SHORTEST {
            self.blocks = self.blocks.saturating_mul(2).min(1 << 20);
        } else if time > LONGEST {
            self.blocks = (self.blocks / 2).max(1);
        }
        result
    }
}

impl Progress {
    /// The progress of a stage that gathers no light.
    pub(super) fn new(stage: Stage, done: f64, spent: Duration) -> Self {
        Self {
            stage,
            done,
            spent,
            gathered: None,
        }
    }

    /// The time left at the present speed; None before there is a speed.
    pub fn left(&self) -> Option<Duration> {
        let left = self.spent.as_secs_f64() * (1.0 / self.done - 1.0).max(0.0);
        Duration::try_from_secs_f64(left).ok().filter(|_| self.done > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_may_be_longer_than_times_can_be() {
        let left = |done: f64, seconds: u64| Progress::new(Stage::Lightmaps, done, Duration::from_secs(seconds)).left();
        assert_eq!(left(0.25, 4), Some(Duration::from_secs(12)));
        assert_eq!(left(0.0, 4), None);
        assert_eq!(left(1e-20, 1_000_000_000), None);
    }
}
