//! Writes checkpoints and shares of a bake, and resumes from checkpoints.

use std::path::Path;

use sunroom::bake::job::BakeJob;
use sunroom::bake::layers::Division;
use sunroom::bake::part::{PartHeader, read_part};
use sunroom::bake::progress::{Progress, Stage};
use sunroom::render::part::Origin;

use super::args::BakeArgs;
use crate::cli::report::Failure;
use crate::cli::share::{Checkpoints, accept_origin, is_begun, warn_of_more};

/// Writes the light of a job to files.
pub struct Keeper<'a> {
    /// The header of the files.
    header: PartHeader,
    checkpoints: Checkpoints<'a>,
}

impl<'a> Keeper<'a> {
    pub fn new(args: &'a BakeArgs, origin: Origin, samples: [u32; 2]) -> Self {
        Self {
            header: PartHeader {
                origin,
                samples,
                samples_of_whole: args.spp,
                is_finished: false,
                is_share: args.samples.is_some(),
                division: Division::default(),
            },
            checkpoints: Checkpoints::new(&args.checkpoints),
        }
    }

    /// Resumes the job from the checkpoint given by `--resume`, if there is one.
    pub fn take_up(&self, job: &mut BakeJob, args: &BakeArgs) -> Result<(), Failure> {
        let Some(path) = &args.checkpoints.resume else {
            return Ok(());
        };
        if is_begun(&args.checkpoints, path, "bake") {
            return Ok(());
        }
        let name = path.display();
        let (header, _, light) = read_part(path).map_err(|error| format!("{name}: {error}"))?;
        accept_origin(
            path,
            "bake",
            &self.header.origin,
            &header.origin,
            args.checkpoints.force,
        )?;
        let [first, end] = header.samples;
        let own = &self.header;
        if first != own.samples[0] || own.is_share && end != own.samples[1] {
            return Err(format!("{name} is of another share of the bake: --samples {first}..{end}").into());
        }
        job.take_up(light).map_err(|error| format!("{name}: {error}"))?;
        let asked = own.samples[1] - own.samples[0];
        warn_of_more(path, ["texel", "bake"], job.light().samples(), asked);
        Ok(())
    }

    /// Writes a checkpoint if one is due, between two pieces of work.
    pub fn look(&mut self, job: &BakeJob, now: &Progress) {
        let gathers = matches!(now.stage, Stage::Lightmaps | Stage::Probe(_));
        // Finishing pictures takes time, but adds no light that could be lost.
        if self.checkpoints.are_due() || !gathers && !self.checkpoints.were_tried(job.rays()) {
            self.save(job);
        }
    }

    /// Writes a checkpoint, if there is new light. Returns whether a checkpoint exists.
    pub fn save(&mut self, job: &BakeJob) -> bool {
        let Self { header, checkpoints } = self;
        job.rays() > 0 && checkpoints.save(job.rays(), |path| write(job, path, header))
    }

    /// Writes the share.
    pub fn write(&self, job: &BakeJob, path: &Path) -> Result<(), String> {
        write(job, path, &self.header)
    }
}

fn write(job: &BakeJob, path: &Path, header: &PartHeader) -> Result<(), String> {
    let written = job.save(path, header);
    written.map_err(|error| format!("cannot write {}: {error}", path.display()))
}
