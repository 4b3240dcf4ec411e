//! The arguments of `sunroom why`, and the question that they ask about a loaded scene.

use std::sync::atomic::AtomicBool;

use bevy::prelude::*;
use clap::Args;
use sunroom::engine::reasons::Things;
use sunroom::render::breakdown::LEAST_SAMPLES;
use sunroom::render::part::Crop;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::View;

use crate::cli::args::{MemoryArgs, MissingArgs, SceneArgs, ThreadArgs, TrustArgs};
use crate::cli::parse;
use crate::cli::picture_args::SizeArgs;

#[derive(Args)]
pub struct WhyArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub subject: Subject,
    /// Samples per pixel; with --lamp paths from the lamp [default: 65536 in all, at least 64 per pixel; 262144 paths]
    #[arg(short, long, value_parser = clap::value_parser!(u32).range(i64::from(LEAST_SAMPLES)..))]
    pub spp: Option<u32>,
    /// Camera of the picture, by its id or its index from 0 on [default: the first]
    #[arg(long, value_name = "NAME|INDEX")]
    pub camera: Option<String>,
    #[command(flatten)]
    pub size: SizeArgs,
    /// Seed of the random numbers; the same seed gives the same figures on any number of threads
    #[arg(long)]
    pub seed: Option<u32>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub threads: ThreadArgs,
    #[command(flatten)]
    pub memory: MemoryArgs,
    #[command(flatten)]
    pub trust: TrustArgs,
    #[command(flatten)]
    pub missing: MissingArgs,
    /// Treat warnings about the scene as errors
    #[arg(long)]
    pub strict: bool,
}

/// The subject of the question: a pixel, a rectangle of pixels, or a lamp.
#[derive(Args)]
#[group(required = true, multiple = false)]
pub struct Subject {
    /// Pixel of the picture, (0, 0) at the upper left
    #[arg(long, value_name = "X,Y", value_parser = parse::pixel)]
    pub at: Option<UVec2>,
    /// Rectangle of pixels
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse::crop)]
    pub region: Option<Crop>,
    /// Lamp whose light is followed, by its id or name
    #[arg(long, value_name = "NAME")]
    pub lamp: Option<String>,
}

/// A loaded scene and what is asked about it.
pub struct Question<'a> {
    pub args: &'a WhyArgs,
    pub world: &'a World,
    pub things: Things,
    pub scene: RenderScene,
    pub view: View,
    pub cancel: &'a AtomicBool,
}
