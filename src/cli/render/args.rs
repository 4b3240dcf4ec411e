//! The arguments of `sunroom render`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use sunroom::layer::{Layers, layer_names};
use sunroom::scene::{AccelMethod, PathPlugin, Sequence, Strategy};

use crate::cli::args::{MemoryArgs, MissingArgs, SceneArgs, ThreadArgs, TrustArgs};
use crate::cli::parse;
use crate::cli::picture_args::{DisplayArgs, FileArgs, SizeArgs, named};
use crate::cli::sequence::SequenceArgs;
use crate::cli::share::{CheckpointArgs, ShareArgs};
use crate::cli::stats::StatsFormat;

#[derive(Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Image file: .exr, .hdr or .pfm (linear), .png or .jpg (sRGB); `-` is PNG on standard output; may be given
    /// several times [default: a new file beside the scene, of the kind that the film names, or .exr]
    #[arg(short, long, value_name = "OUT")]
    pub output: Vec<PathBuf>,
    /// Camera to render with, by its id or its index from 0 on [default: the first]
    #[arg(long, value_name = "NAME|INDEX")]
    pub camera: Option<String>,
    /// Samples per pixel [default: the scene's, or as many as --time and --noise allow]
    #[arg(short, long, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Stop after this time, such as 500ms, 60s, 5m; a bare number is seconds
    #[arg(long, value_name = "TIME", value_parser = parse::duration)]
    pub time: Option<Duration>,
    /// Stop at this noise, such as 0.01 or 1%: the root mean square error of pixels relative to their luminance, as
    /// estimated
    #[arg(long, value_name = "NOISE", value_parser = parse::noise)]
    pub noise: Option<f32>,
    /// Send more samples where the noise is
    #[arg(long)]
    pub adaptive: bool,
    #[command(flatten)]
    pub size: SizeArgs,
    #[command(flatten)]
    pub shares: ShareArgs,
    #[command(flatten)]
    pub checkpoints: CheckpointArgs,
    /// Write the picture so far to the outputs from time to time
    #[arg(long, value_name = "TIME", value_parser = parse::duration)]
    pub partial: Option<Duration>,
    #[command(flatten)]
    pub sequence: SequenceArgs,
    #[command(flatten)]
    pub threads: ThreadArgs,
    #[command(flatten)]
    pub memory: MemoryArgs,
    #[command(flatten)]
    pub trust: TrustArgs,
    #[command(flatten)]
    pub missing: MissingArgs,
    /// Seed of the random numbers; the same seed gives the same picture on any number of threads
    #[arg(long)]
    pub seed: Option<u32>,
    /// Longest path in segments, -1 for any [default: the scene's]
    #[arg(long, value_parser = clap::value_parser!(i32).range(-1..))]
    pub max_depth: Option<i32>,
    /// Remove the noise with Open Image Denoise
    #[arg(long)]
    pub denoise: bool,
    #[arg(long, value_name = "NAME[,NAME...]", value_parser = parse::layers, help = layers_help())]
    pub aov: Vec<Layers>,
    /// Acceleration structure
    #[arg(long, default_value = AccelMethod::Sah.name(), value_parser = named(&AccelMethod::ALL, AccelMethod::name))]
    pub accel: AccelMethod,
    /// The integrator in place of the file's: path, volpath, bdpt (paths from the lights as well), vcm (photons beside
    /// these), ptracer (paths from the lights alone) or auto (path, guided path or bdpt, whichever pays for the
    /// scene)
    #[arg(long, value_name = "NAME", value_parser = named(&PathPlugin::ALL, PathPlugin::name))]
    pub integrator: Option<PathPlugin>,
    /// Clamp what is brighter than this percentile of the samples, such as 99.9: less noise, and too little light
    #[arg(long, value_name = "PERCENTILE", value_parser = parse::percentile)]
    pub clamp: Option<f32>,
    /// Guide the paths of `path`, and of `auto` in any case where that is `path`, to where light comes from, as
    /// photons show: less noise where light comes around corners, and more time for each sample
    #[arg(long)]
    pub guided: bool,
    /// How light is looked for by path, volpath and volpathmis
    #[arg(long, value_parser = named(&Strategy::ALL, Strategy::name))]
    pub strategy: Option<Strategy>,
    /// Reflect on glass by Schlick's approximation instead of the exact Fresnel equations
    #[arg(long)]
    pub schlick: bool,
    /// Random numbers: well spread points whatever the file's sampler is called, or truly independent ones [default:
    /// sobol]
    #[arg(long, value_parser = named(&Sequence::ALL, Sequence::name))]
    pub sampler: Option<Sequence>,
    #[command(flatten)]
    pub display: DisplayArgs,
    #[command(flatten)]
    pub file: FileArgs,
    /// Show the picture in tev while it is rendered, at this address (tev listens to localhost:14158)
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "frames", value_parser = parse::address)]
    pub display_server: Option<String>,
    /// Print the figures of the render on standard output; json-lines prints events while it renders, one a line
    #[arg(long, value_enum, value_name = "FORMAT", num_args = 0..=1, require_equals = true, default_missing_value = "text")]
    pub stats: Option<StatsFormat>,
    /// Treat warnings about the scene as errors
    #[arg(long)]
    pub strict: bool,
    /// No progress
    #[arg(short, long)]
    pub quiet: bool,
}

/// The text of `--help` about `--aov`.
fn layers_help() -> String {
    let names = layer_names().join(", ");
    format!("Save layers with the picture in EXR files, besides those of the scene: {names}")
}
