//! Arguments that several commands share, and those of the editor.

use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Args, ValueEnum};
use sunroom::app::threads::MOST_WORKERS;
use sunroom::document::Severity;
use sunroom::document::paths::settle;
use sunroom::files::FileError;
use sunroom::memory;
use sunroom::scene::Trust;

use super::monkey::MonkeyArgs;
use super::{parse, report};

/// The scene, and the values of its parameters.
#[derive(Args)]
pub struct SceneArgs {
    /// Scene file (Mitsuba 3 XML, or glTF 2.0)
    pub scene: PathBuf,
    #[command(flatten)]
    pub defines: DefineArgs,
}

#[derive(Args)]
pub struct TrustArgs {
    /// Read nothing outside the scene's own folder, whatever the scene names and wherever its links lead
    #[arg(long)]
    untrusted: bool,
}

impl TrustArgs {
    /// The permission of the scene in this file. An error if the file itself is a link out of its folder: messages
    /// quote the lines of a scene, which would be those of a file that it may not read.
    pub fn trust(&self, scene: &Path) -> Result<Trust, String> {
        if !self.untrusted {
            return Ok(Trust::Everything);
        }
        let trust = Trust::OwnFolder;
        let path = settle(scene);
        match trust.access(&path).covers(&path) {
            true => Ok(trust),
            false => Err(format!("{}: {}", scene.display(), FileError::Outside)),
        }
    }
}

#[derive(Args)]
pub struct MissingArgs {
    /// Go on without meshes and volumes that are not there, with a warning for each
    #[arg(long)]
    pub allow_missing: bool,
}

impl MissingArgs {
    /// The severity of a missing file for a command without an app.
    pub fn severity(&self) -> Severity {
        match self.allow_missing {
            true => Severity::Warning,
            false => Severity::Error,
        }
    }
}

#[derive(Args)]
pub struct DefineArgs {
    /// Give the scene's parameter $NAME a value
    #[arg(short = 'D', long = "define", value_name = "NAME=VALUE", value_parser = parse::define)]
    pub defines: Vec<(String, String)>,
}

#[derive(Args)]
pub struct ThreadArgs {
    /// Threads that trace rays; a negative number leaves that many cores free
    #[arg(short, long)]
    pub threads: Option<i32>,
}

impl ThreadArgs {
    /// Warns if the user asks for more threads than are started.
    pub fn report_limit(&self) {
        if let Some(asked) = self.threads.filter(|&asked| asked > MOST_WORKERS as i32) {
            report::line(format_args!(
                "warning: {asked} threads are more than are started; {MOST_WORKERS} threads trace rays"
            ));
        }
    }
}

#[derive(Args)]
pub struct MemoryArgs {
    /// Memory for pictures, meshes and the film, such as 8GB [default: $SUNROOM_MEMORY, or three quarters of the
    /// machine's]
    #[arg(long, value_name = "SIZE", value_parser = memory::parse_size)]
    pub memory: Option<u64>,
}

impl MemoryArgs {
    pub fn apply(&self) {
        if let Some(bytes) = self.memory {
            memory::budget().name_limit(bytes);
        }
    }
}

#[derive(Args)]
pub struct EditArgs {
    /// Scene file (Mitsuba 3 XML, or glTF 2.0); the Cornell box if there is none
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub defines: DefineArgs,
    #[command(flatten)]
    pub threads: ThreadArgs,
    #[command(flatten)]
    pub memory: MemoryArgs,
    /// Camera to begin with, by its id or its index from 0 on
    #[arg(long, value_name = "NAME|INDEX")]
    pub camera: Option<String>,
    /// Denoise the picture from the beginning, as N does
    #[arg(long)]
    pub denoise: bool,
    /// Size of the window [default: as it was left; 1280x720 at first, and with --exit, --script or a measurement]
    #[arg(long, value_name = "WxH", value_parser = parse::size)]
    pub window: Option<(u32, u32)>,
    /// Save the whole window as PNG once the picture has --after-spp samples
    #[arg(long, value_name = "OUT.png")]
    pub screenshot: Option<PathBuf>,
    /// Do the commands of a file, one a line, as a user would
    #[arg(long, value_name = "FILE")]
    pub script: Option<PathBuf>,
    /// Samples per pixel before the screenshot
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub after_spp: u32,
    /// Quit after the screenshot (or the measurement, or else the samples)
    #[arg(long)]
    pub exit: bool,
    /// Fly, drag a mesh, change a material and a light, undo: N times each, and print how long the picture took to
    /// follow
    #[arg(long, value_name = "N", group = "unattended")]
    pub measure_latency: Option<u32>,
    #[command(flatten)]
    pub settling: SettlingArgs,
    /// With --measure-latency, --measure-settling or --monkey: do not draw the window, so that what a software
    /// graphics driver takes is not in the figures
    #[arg(long, requires = "unattended", conflicts_with = "screenshot")]
    pub undrawn: bool,
    #[command(flatten)]
    pub monkey: MonkeyArgs,
    /// With --exit: fail if it is not done after this time
    #[arg(long, value_name = "TIME", default_value = "10m", value_parser = parse::duration)]
    pub timeout: Duration,
}

/// What is measured of how soon the picture settles.
#[derive(Args)]
pub struct SettlingArgs {
    /// Edit in several ways and print how near the picture in the window soon comes to the one of N samples per pixel
    #[arg(long, value_name = "N", group = "unattended", conflicts_with_all = ["measure_latency", "monkey"],
          value_parser = clap::value_parser!(u32).range(1..))]
    pub measure_settling: Option<u32>,
    /// With --measure-settling: write the pictures that are compared into this folder
    #[arg(long, value_name = "FOLDER", requires = "measure_settling")]
    pub pictures: Option<PathBuf>,
    /// With --measure-settling: print a table, or one JSON object
    #[arg(long, value_enum, value_name = "FORMAT", num_args = 0..=1, require_equals = true, default_missing_value = "text",
          requires = "measure_settling")]
    pub stats: Option<SettlingFormat>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SettlingFormat {
    Text,
    Json,
}
