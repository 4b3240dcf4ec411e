//! The arguments of `sunroom submit`.

use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};

use crate::cli::args::{MemoryArgs, MissingArgs, SceneArgs};
use crate::cli::parse;
use crate::cli::sequence::frames;

#[derive(Args)]
pub struct SubmitArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The system that runs the job
    #[arg(long, value_name = "SYSTEM")]
    pub to: System,
    /// The folder of the job, which is made; parts and pictures go there too
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Share out a bake, as of `sunroom bake`, instead of rendering
    #[arg(long, conflicts_with_all = ["frames", "crops"])]
    pub bake: bool,
    /// Samples per pixel [default: those of the scene], or per texel of a bake [default: 64]
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// The frames of an animation, such as 1..120
    #[arg(long, value_name = "FIRST..LAST", value_parser = frames)]
    pub frames: Option<RangeInclusive<u32>>,
    /// The time that a task should take on a machine like this one, on which a few seconds are rendered or baked to
    /// measure it
    #[arg(long, value_name = "TIME", default_value = "10m", value_parser = parse::duration)]
    pub task_time: Duration,
    /// Divide the samples of each frame, or of the bake, into this number of ranges, and measure nothing
    #[arg(long, value_name = "COUNT", conflicts_with = "task_time", value_parser = clap::value_parser!(u32).range(1..))]
    pub shares: Option<u32>,
    /// Cut each frame into columns and rows of crops as well, such as 4x2 [default: where ranges of samples alone
    /// would be longer than --task-time]
    #[arg(long, value_name = "COLUMNSxROWS", value_parser = parse::grid)]
    pub crops: Option<[u32; 2]>,
    /// Remove the noise of the merged pictures
    #[arg(long)]
    pub denoise: bool,
    /// Keep the noise of the merged bake, which is removed otherwise
    #[arg(long, requires = "bake", conflicts_with = "denoise")]
    pub no_denoise: bool,
    /// Show what would be written, and write nothing
    #[arg(long)]
    pub dry_run: bool,
    #[command(flatten)]
    pub memory: MemoryArgs,
    #[command(flatten)]
    pub missing: MissingArgs,
    /// Further options of `sunroom render` or `sunroom bake` for each task, such as -- --width 1920 --aov all
    #[arg(last = true, value_name = "OPTIONS")]
    pub options: Vec<String>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum System {
    /// Open Job Description, which AWS Deadline Cloud takes as well
    Openjd,
    /// Slurm
    Slurm,
    /// GNU parallel over ssh
    Parallel,
}
