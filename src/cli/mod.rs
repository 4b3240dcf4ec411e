//! The command line: what it accepts, and which part of the program answers.
//!
//! Results for machines go to standard output, everything for people to standard error. Exit codes: 0 done; 1 the scene or a file was
//! at fault, or the picture has pixels without a sample; 2 wrong usage (clap's); 130 interrupted, and the picture with the samples so far is
//! written.

mod bench;
mod check;
mod convert;
#[cfg(feature = "window")]
mod edit;
mod ending;
mod monkey;
mod outputs;
mod parse;
mod progress;
mod render;
mod report;
mod stats;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, CommandFactory, Parser, Subcommand};

use sunroom::app::threads::MOST_WORKERS;
use sunroom::document::paths::settle;
use sunroom::document::suggest::did_you_mean;
use sunroom::files::FileError;
use sunroom::memory;
use sunroom::scene::Trust;

/// A small level editor whose viewport is a path tracer.
#[derive(Parser)]
#[command(version, about, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    edit: EditArgs,
}

#[derive(Subcommand)]
enum Command {
    /// Open a scene in the editor (also without the word `edit`)
    Edit(EditArgs),
    /// Render a scene to image files
    Render(Box<render::RenderArgs>),
    /// Report what is wrong with scene files
    Check(check::CheckArgs),
    /// Load a scene and write it back as the program understands it
    Convert(convert::ConvertArgs),
    /// Measure how fast this machine and this version are
    Bench(bench::BenchArgs),
}

/// Which scene, and the values of its parameters.
#[derive(Args)]
struct SceneArgs {
    /// Scene file (Mitsuba 3 XML, or glTF 2.0)
    scene: PathBuf,
    #[command(flatten)]
    defines: DefineArgs,
}

#[derive(Args)]
struct TrustArgs {
    /// Read nothing outside the scene's own folder, whatever the scene names and wherever its links lead
    #[arg(long)]
    untrusted: bool,
}

impl TrustArgs {
    /// What the scene in this file may read. An error if the file itself is a link that leads out of its folder: messages quote the lines of a
    /// scene, which would be those of a file that it may not read.
    fn trust(&self, scene: &Path) -> Result<Trust, String> {
        if !self.untrusted {
            return Ok(Trust::Everything);
        }
        let trust = Trust::Folders(Vec::new());
        let path = settle(scene);
        match trust.access(&path).covers(&path) {
            true => Ok(trust),
            false => Err(format!("{}: {}", scene.display(), FileError::Outside)),
        }
    }
}

#[derive(Args)]
struct DefineArgs {
    /// Give the scene's parameter $NAME a value
    #[arg(short = 'D', long = "define", value_name = "NAME=VALUE", value_parser = parse::define)]
    defines: Vec<(String, String)>,
}

#[derive(Args)]
struct ThreadArgs {
    /// Threads that trace rays; a negative number leaves that many cores free
    #[arg(short, long, allow_negative_numbers = true)]
    threads: Option<i32>,
}

impl ThreadArgs {
    /// Says so if fewer threads are started than the user asks for.
    fn report_limit(&self) {
        if let Some(asked) = self.threads.filter(|&asked| asked > MOST_WORKERS as i32) {
            report::line(format_args!(
                "warning: {asked} threads are more than are started; {MOST_WORKERS} threads trace rays"
            ));
        }
    }
}

#[derive(Args)]
struct MemoryArgs {
    /// Memory for pictures, meshes and the film, such as 8GB [default: $SUNROOM_MEMORY, or three quarters of the machine's]
    #[arg(long, value_name = "SIZE", value_parser = memory::parse_size)]
    memory: Option<u64>,
}

impl MemoryArgs {
    fn apply(&self) {
        if let Some(bytes) = self.memory {
            memory::budget().name_limit(bytes);
        }
    }
}

#[derive(Args)]
struct EditArgs {
    /// Scene file (Mitsuba 3 XML, or glTF 2.0); the Cornell box if there is none
    scene: Option<PathBuf>,
    #[command(flatten)]
    defines: DefineArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    /// Camera to begin with, by its id or its index from 0 on
    #[arg(long, value_name = "NAME|INDEX")]
    camera: Option<String>,
    /// Size of the window
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse::size)]
    window: (u32, u32),
    /// Save the whole window as PNG once the picture has --after-spp samples
    #[arg(long, value_name = "OUT.png")]
    screenshot: Option<PathBuf>,
    /// Do the commands of a file, one a line, as a user would
    #[arg(long, value_name = "FILE")]
    script: Option<PathBuf>,
    /// Samples per pixel before the screenshot
    #[arg(long, value_name = "N", default_value_t = 1)]
    after_spp: u32,
    /// Quit after the screenshot (or the measurement, or else the samples)
    #[arg(long)]
    exit: bool,
    /// Fly, drag a mesh, change a material and a light, undo: N times each, and print how long the picture took to follow
    #[arg(long, value_name = "N", group = "unattended")]
    measure_latency: Option<u32>,
    /// With --measure-latency or --monkey: do not draw the window, so that what a software graphics driver takes is not in the figures
    #[arg(long, requires = "unattended", conflicts_with = "screenshot")]
    undrawn: bool,
    #[command(flatten)]
    monkey: monkey::MonkeyArgs,
    /// With --exit: fail if it is not done after this time
    #[arg(long, value_name = "TIME", default_value = "10m", value_parser = parse::duration)]
    timeout: std::time::Duration,
}

/// Does what the arguments of the process ask for.
pub fn run() -> ExitCode {
    // Said first: the other arguments mean nothing then.
    if let Some(message) = no_command() {
        return report::wrong_usage(message);
    }
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { report::WRONG_USAGE } else { 0 });
        }
    };
    if let Some(Err(message)) = memory::budget_of_variable() {
        return report::wrong_usage(format_args!("{}: {message}", memory::VARIABLE));
    }
    match cli.command {
        None => edit(cli.edit),
        Some(Command::Edit(args)) => edit(args),
        Some(Command::Render(args)) => render::run(*args),
        Some(Command::Check(args)) => check::run(args),
        Some(Command::Convert(args)) => convert::run(args),
        Some(Command::Bench(args)) => bench::run(args),
    }
}

/// Says so if the first argument is a plain word, but neither a command nor the name of a file, which would be a scene to edit.
fn no_command() -> Option<String> {
    let first = PathBuf::from(std::env::args_os().nth(1)?);
    let word = first.to_str()?;
    if word.is_empty() || word.starts_with('-') || word.contains(['.', '/', '\\']) || first.exists() {
        return None;
    }
    let command = Cli::command();
    let names: Vec<&str> = command.get_subcommands().map(clap::Command::get_name).collect();
    if word == "help" || names.contains(&word) {
        return None;
    }
    let help = did_you_mean(word, names.iter().copied());
    let help = help.unwrap_or_else(|| format!("the commands are {}", names.join(", ")));
    Some(format!(
        "there is no command `{word}`, and no file of that name ({help})"
    ))
}

#[cfg(feature = "window")]
fn edit(args: EditArgs) -> ExitCode {
    edit::run(args)
}

#[cfg(not(feature = "window"))]
fn edit(_: EditArgs) -> ExitCode {
    report::error(
        "this program was built without a window (cargo feature `window`); `sunroom render` works without one",
    )
}
