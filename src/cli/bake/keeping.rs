//! Checkpoints and shares of a bake, and taking up what a checkpoint has.

use std::path::Path;
use std::time::{Duration, Instant};

use sunroom::bake::job::BakeJob;
use sunroom::bake::part::read_part;
use sunroom::bake::progress::{Progress, Stage};
use sunroom::render::part::Origin;

use super::args::BakeArgs;
use crate::cli::report::{self, Failure};
use crate::cli::share::{accept_origin, earlier_stays, is_begun, warn_of_more};

/// Keeps the light of a job in files.
pub struct Keeper<'a> {
    origin: Origin,
    /// The samples of each texel of a lightmap that are asked for.
    samples: [u32; 2],
    /// The samples of each texel of the whole bake, where they are known.
    samples_of_whole: Option<u32>,
    is_share: bool,
    checkpoint: Option<(&'a Path, Duration)>,
    last: Instant,
    /// The rays of the last checkpoint.
    saved: Option<u64>,
    /// The rays of the last attempt at a checkpoint.
    tried: Option<u64>,
}

impl<'a> Keeper<'a> {
    pub fn new(args: &'a BakeArgs, origin: Origin, samples: [u32; 2]) -> Self {
        let checkpoint = args.checkpoints.checkpoint.as_deref();
        Self {
            origin,
            samples,
            samples_of_whole: args.spp,
            is_share: args.samples.is_some(),
            checkpoint: checkpoint.map(|path| (path, args.checkpoints.every)),
            last: Instant::now(),
            saved: None,
            tried: None,
        }
    }

    /// Lets the job go on with what the checkpoint has that is to be resumed.
    pub fn take_up(&self, job: &mut BakeJob, args: &BakeArgs) -> Result<(), Failure> {
        let Some(path) = &args.checkpoints.resume else {
            return Ok(());
        };
        if is_begun(&args.checkpoints, path, "bake") {
            return Ok(());
        }
        let name = path.display();
        let (header, _, light) = read_part(path).map_err(|error| format!("{name}: {error}"))?;
        accept_origin(path, "bake", &self.origin, &header.origin, args.checkpoints.force)?;
        let [first, end] = header.samples;
        if first != self.samples[0] || self.is_share && end != self.samples[1] {
            return Err(format!("{name} is of another share of the bake: --samples {first}..{end}").into());
        }
        job.take_up(light).map_err(|error| format!("{name}: {error}"))?;
        let asked = self.samples[1] - self.samples[0];
        warn_of_more(path, ["texel", "bake"], job.light().samples(), asked);
        Ok(())
    }

    /// Looks at the job between two pieces of work.
    pub fn look(&mut self, job: &BakeJob, now: &Progress) {
        let Some((_, every)) = self.checkpoint else {
            return;
        };
        let gathers = matches!(now.stage, Stage::Lightmaps | Stage::Probe(_));
        // What finishes light takes its time, and adds nothing that could be lost.
        if self.last.elapsed() >= every || !gathers && self.tried != Some(job.rays()) {
            self.save(job);
        }
    }

    /// Writes a checkpoint, if there is anything new. One that fails is reported, and an earlier one stays. Returns
    /// whether there is one.
    pub fn save(&mut self, job: &BakeJob) -> bool {
        let Some((path, _)) = self.checkpoint else {
            return false;
        };
        if job.rays() == 0 || self.saved == Some(job.rays()) {
            return self.saved.is_some();
        }
        let result = job.save(path, &self.origin, self.samples, self.samples_of_whole, self.is_share);
        (self.last, self.tried) = (Instant::now(), Some(job.rays()));
        match result {
            Ok(()) => self.saved = Some(job.rays()),
            Err(error) => report::line(format_args!(
                "warning: cannot write {}: {error}{}",
                path.display(),
                earlier_stays(path)
            )),
        }
        self.saved == Some(job.rays())
    }

    /// Writes the share.
    pub fn write_share(&self, job: &BakeJob, path: &Path) -> Result<(), Failure> {
        let written = job.save(path, &self.origin, self.samples, self.samples_of_whole, true);
        Ok(written.map_err(|error| format!("cannot write {}: {error}", path.display()))?)
    }
}
