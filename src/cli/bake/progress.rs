//! Shows the progress of each stage of a bake.

use std::time::Duration;

use sunroom::bake::job::BakeJob;
use sunroom::bake::limits::BakeLimits;
use sunroom::bake::probes::{Probe, ProbeKind};
use sunroom::bake::progress::{Gathered, Progress as Now, Stage};

use crate::cli::progress::{Progress, Shown};
use crate::cli::report;

/// The time after which a stage that gathers no light is shown.
const WORTH_SAYING: Duration = Duration::from_secs(1);

pub struct BakeProgress {
    quiet: bool,
    time: Option<Duration>,
    noise: Option<f32>,
    /// The present stage, with the progress shown last.
    stage: Option<(Stage, Progress, Shown)>,
}

impl BakeProgress {
    pub fn new(quiet: bool, limits: &BakeLimits) -> Self {
        Self {
            quiet,
            time: limits.time,
            noise: limits.noise,
            stage: None,
        }
    }

    /// Shows the progress of a job's preparation.
    pub fn prepare(&mut self, now: &Now, words: &str) {
        self.step(now, words.to_owned());
    }

    /// Shows the progress of the job.
    pub fn show(&mut self, job: &BakeJob, now: &Now) {
        if let Stage::Probe(number) = now.stage
            && self.is_new(now.stage)
            && !self.quiet
        {
            self.end();
            let words = now.stage.words(Some(job.blueprint()));
            report::line(title(&words, &job.blueprint().probes[number]));
        }
        let message = match &now.gathered {
            Some(gathered) => self.message(now.stage, gathered),
            None => now.stage.words(Some(job.blueprint())),
        };
        self.step(now, message);
    }

    fn is_new(&self, stage: Stage) -> bool {
        self.stage.as_ref().is_none_or(|(known, ..)| *known != stage)
    }

    fn step(&mut self, now: &Now, message: String) {
        if self.is_new(now.stage) {
            self.end();
            self.stage = Some((now.stage, Progress::new(self.quiet, None), Shown::default()));
        }
        let Some((_, progress, last)) = &mut self.stage else {
            return;
        };
        *last = Shown {
            done: now.done,
            samples: now.gathered.map_or(0, |gathered| gathered.samples),
            seconds: now.spent.as_secs_f64(),
            message,
        };
        // Short stages are not shown.
        if now.gathered.is_some() || now.spent >= WORTH_SAYING {
            progress.show(last);
        }
    }

    /// Shows the end of the stage.
    pub fn end(&mut self) {
        if let Some((_, mut progress, shown)) = self.stage.take() {
            progress.end(&shown);
        }
    }

    fn message(&self, stage: Stage, gathered: &Gathered) -> String {
        let is_of_lightmaps = stage == Stage::Lightmaps;
        // In a share of a single round, no texel has all samples until near its end.
        let samples = gathered.mean_samples as u32;
        let samples = match gathered.target == u32::MAX || is_of_lightmaps && self.time.is_some() {
            true => format!("{samples} spp"),
            false => format!("{samples}/{} spp", gathered.target),
        };
        let noise = match (gathered.noise, self.noise) {
            (Some(noise), Some(target)) if is_of_lightmaps => format!("  noise {noise:.4}/{target}"),
            _ => String::new(),
        };
        format!("{samples}{noise}  {:.2} Msamples/s", 1e-6 * gathered.samples_per_second)
    }
}

fn title(words: &str, probe: &Probe) -> String {
    match probe.kind {
        ProbeKind::Reflection { size, .. } => format!("{words}, {size} x {size}"),
        ProbeKind::Volume { points } => {
            format!("{words}, {} x {} x {} points", points.x, points.y, points.z)
        }
    }
}
