//! Shows how far a bake is: a progress for each stage.

use std::time::Duration;

use sunroom::bake::job::{BakeJob, BakeLimits};
use sunroom::bake::probes::{Probe, ProbeKind};
use sunroom::bake::progress::{Gathered, Progress as Now, Stage};

use crate::cli::progress::{Progress, Shown};
use crate::cli::report;

pub struct BakeProgress {
    quiet: bool,
    time: Option<Duration>,
    noise: Option<f32>,
    /// The stage that is shown, and what of it was told last.
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

    /// Shows how far the job is now.
    pub fn show(&mut self, job: &BakeJob, now: &Now) {
        if self.stage.as_ref().is_none_or(|(stage, ..)| *stage != now.stage) {
            self.end();
            if let Stage::Probe(number) = now.stage
                && !self.quiet
            {
                report::line(title(&job.blueprint().probes[number]));
            }
        }
        let Some(gathered) = &now.gathered else {
            return;
        };
        let shown = Shown {
            done: now.done,
            samples: gathered.samples,
            seconds: now.spent.as_secs_f64(),
            message: self.message(now.stage, gathered),
        };
        let (_, _, last) = self.stage.get_or_insert_with(|| {
            let progress = Progress::new(self.quiet, None);
            (now.stage, progress, Shown::default())
        });
        *last = shown;
        if let Some((_, progress, shown)) = &mut self.stage {
            progress.show(shown);
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
        let samples = match gathered.target == u32::MAX || is_of_lightmaps && self.time.is_some() {
            true => format!("{} spp", gathered.samples),
            false => format!("{}/{} spp", gathered.samples, gathered.target),
        };
        let noise = match (gathered.noise, self.noise) {
            (Some(noise), Some(target)) if is_of_lightmaps => format!("  noise {noise:.4}/{target}"),
            _ => String::new(),
        };
        format!("{samples}{noise}  {:.2} Msamples/s", 1e-6 * gathered.samples_per_second)
    }
}

fn title(probe: &Probe) -> String {
    let name = &probe.name;
    match probe.kind {
        ProbeKind::Reflection { size, .. } => format!("reflection probe `{name}`, {size} x {size}"),
        ProbeKind::Volume { points } => {
            format!(
                "irradiance volume `{name}`, {} x {} x {} points",
                points.x, points.y, points.z
            )
        }
    }
}
