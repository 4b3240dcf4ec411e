//! The arguments of `sunroom bake`.

use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use sunroom::bake::layers::USUAL_MEMORY;
use sunroom::bake::prefilter::{SIZES, is_size};
use sunroom::bake::probes::ProbeSettings;
use sunroom::bake::unwrap::{ATLAS_SIZES, UnwrapSettings};
use sunroom::memory;

use crate::cli::args::{MemoryArgs, MissingArgs, SceneArgs, ThreadArgs, TrustArgs};
use crate::cli::parse;
use crate::cli::share::CheckpointArgs;

#[derive(Args)]
pub struct BakeArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Folder for the level, its lightmaps and lightmaps.json, which is made if it is not there; with --samples the
    /// file of the share
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Texels per unit of length [default: as many as fit in one lightmap, if all shapes do]
    #[arg(long, value_name = "N", value_parser = parse::density)]
    pub texels_per_unit: Option<f32>,
    /// Width of a lightmap in texels, and its largest height
    #[arg(long, value_name = "N", default_value_t = UnwrapSettings::default().atlas_size, value_parser = atlas_size())]
    pub atlas_size: u32,
    /// Samples per texel [default: 64, or as many as --time and --noise allow]
    #[arg(short, long, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Stop after this time, such as 500ms, 60s, 5m, at the end of a round of samples; a bare number is seconds
    #[arg(long, value_name = "TIME", value_parser = parse::duration)]
    pub time: Option<Duration>,
    /// Stop at this noise, such as 0.01 or 1%: the root mean square error of texels relative to their luminance, as
    /// estimated
    #[arg(long, value_name = "NOISE", value_parser = parse::noise)]
    pub noise: Option<f32>,
    /// Gather only these samples of each texel, such as 0..32 (32 is not one of them); `sunroom merge` puts the shares
    /// together
    #[arg(long, value_name = "A..B", value_parser = parse::samples, conflicts_with_all = ["time", "noise", "no_denoise"])]
    pub samples: Option<Range<u32>>,
    #[command(flatten)]
    pub checkpoints: CheckpointArgs,
    /// Leave the direct light of points, spots and directional lights to the game, which has them in the level; that
    /// of shining surfaces and of the sky is baked all the same
    #[arg(long)]
    pub indirect_only: bool,
    /// Keep the light of each lamp, of the sky and of the sun by itself as well, so that a game can dim it
    #[arg(long)]
    pub layers: bool,
    /// The most memory that the layers' textures take in a game, such as 512MiB: where there are more layers, the
    /// weakest lamps of each lightmap and probe share one that cannot be dimmed [default: 256MiB]
    #[arg(long, value_name = "SIZE", value_parser = memory::parse_size, requires = "layers")]
    pub layer_memory: Option<u64>,
    /// Bake lightmaps alone: no reflection probes and no irradiance volumes
    #[arg(long)]
    pub no_probes: bool,
    /// Width of each side of a reflection probe in texels, a power of two
    #[arg(long, value_name = "N", default_value_t = ProbeSettings::default().size, value_parser = probe_size, conflicts_with = "no_probes")]
    pub probe_size: u32,
    /// Distance between neighbouring points of light of the irradiance volume, in the scene's units of length. It is
    /// for the volume around the whole level, which is made where the scene has none of its own [default: such
    /// that there are about 4096 points]
    #[arg(long, value_name = "LENGTH", value_parser = parse::density, conflicts_with = "no_probes")]
    pub probe_spacing: Option<f32>,
    /// Keep the noise instead of removing it with Open Image Denoise
    #[arg(long)]
    pub no_denoise: bool,
    /// Seed of the random numbers; the same seed gives the same lightmaps on any number of threads [default: the
    /// scene's]
    #[arg(long)]
    pub seed: Option<u32>,
    #[command(flatten)]
    pub threads: ThreadArgs,
    #[command(flatten)]
    pub memory: MemoryArgs,
    #[command(flatten)]
    pub trust: TrustArgs,
    #[command(flatten)]
    pub missing: MissingArgs,
    /// Treat warnings as errors
    #[arg(long)]
    pub strict: bool,
    /// No progress
    #[arg(short, long)]
    pub quiet: bool,
}

impl BakeArgs {
    /// The most bytes that the textures of layers may take in a game.
    pub fn memory_of_layers(&self) -> u64 {
        self.layer_memory.unwrap_or(USUAL_MEMORY)
    }
}

fn atlas_size() -> impl clap::builder::TypedValueParser<Value = u32> {
    clap::value_parser!(u32).range(i64::from(*ATLAS_SIZES.start())..=i64::from(*ATLAS_SIZES.end()))
}

fn probe_size(text: &str) -> Result<u32, String> {
    let size = text.parse().ok().filter(|size| is_size(*size));
    size.ok_or_else(|| format!("a power of two from {} to {}", SIZES.start(), SIZES.end()))
}
