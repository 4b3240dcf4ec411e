//! Arguments of `sunroom bench`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::args::{MemoryArgs, ThreadArgs};
use crate::cli::parse;

#[derive(Args)]
pub struct RenderBenchArgs {
    /// Scene files [default: all of the folder `scenes`]
    pub scenes: Vec<PathBuf>,
    /// Samples per pixel
    #[arg(short, long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// Size of the pictures
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = parse::size)]
    pub size: (u32, u32),
    #[command(flatten)]
    pub common: CommonArgs,
}

#[derive(Args)]
pub struct RayBenchArgs {
    /// OBJ or PLY file
    #[arg(long, value_name = "FILE")]
    pub mesh: PathBuf,
    /// Rays with their answers; may be given several times
    #[arg(long, value_name = "FILE", required = true)]
    pub rays: Vec<PathBuf>,
    #[command(flatten)]
    pub common: CommonArgs,
}

#[derive(Args)]
pub struct CommonArgs {
    /// How often everything is measured
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    pub rounds: u32,
    #[command(flatten)]
    pub threads: ThreadArgs,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Write the results to this file; - is standard output, in place of the table
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Compare with the results that an earlier run wrote
    #[arg(long, value_name = "FILE")]
    pub against: Option<PathBuf>,
}
