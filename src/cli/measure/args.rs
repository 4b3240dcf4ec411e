//! The arguments of `sunroom measure`.

use std::path::PathBuf;
use std::time::Duration;

use bevy::math::Vec3;
use clap::Args;
use sunroom::meter::job::MeterEnd;

use crate::cli::args::{MemoryArgs, MissingArgs, SceneArgs, ThreadArgs, TrustArgs};
use crate::cli::parse;

#[derive(Args)]
pub struct MeasureArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Measure until the standard errors are below this share of the values, such as 0.5% or 0.005
    #[arg(long, value_name = "NOISE", value_parser = parse::noise, default_value = "1%")]
    noise: f32,
    /// The most samples of a point
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), default_value_t = MeterEnd::default().samples)]
    spp: u32,
    /// Stop after this time, such as 500ms, 60s, 5m; a bare number is seconds
    #[arg(long, value_name = "TIME", value_parser = parse::duration)]
    time: Option<Duration>,
    /// Measure daylight factors: illuminance as a share of that on the open ground, under a CIE overcast sky in place
    /// of all lights of the scene
    #[arg(long)]
    pub daylight_factor: bool,
    /// The upward direction of the overcast sky, an axis of the world: x, y, z, -x, -y or -z [default: of the scene's
    /// first sky, or else nearest to the camera's]
    #[arg(long, value_name = "AXIS", value_parser = parse::axis, requires = "daylight_factor", allow_hyphen_values = true)]
    pub up: Option<Vec3>,
    /// Rate the glare of a camera's view by UGR (CIE 117), as well
    #[arg(long)]
    pub ugr: bool,
    /// Camera of --ugr, by its id or its index from 0 on [default: the first]
    #[arg(long, value_name = "NAME|INDEX", requires = "ugr")]
    pub camera: Option<String>,
    /// Print the values as JSON
    #[arg(long)]
    pub json: bool,
    /// Write the illuminance of every point to this file, - for standard output
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Write a page with all values and plans of the grids in false colour to this file
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Seed of the random numbers; the same seed gives the same values on any number of threads [default: the scene's]
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

impl MeasureArgs {
    /// The limits that end measuring.
    pub fn end(&self) -> MeterEnd {
        MeterEnd {
            noise: f64::from(self.noise),
            samples: self.spp,
            time: self.time,
        }
    }
}
