//! The command line: its arguments, and the commands.
//!
//! Results for machines go to standard output, all other messages to standard error. Exit codes: 0 done; 1 the scene or
//! a file was at fault, or the picture has pixels without a sample; 2 wrong usage (clap's), for `diff` also an
//! unreadable file; 130 interrupted, and the picture with the samples so far is written; 143 terminated, and a
//! checkpoint is written.

mod args;
mod bake;
mod bench;
mod check;
mod convert;
mod diff;
mod display_server;
#[cfg(feature = "window")]
mod edit;
mod ending;
mod generate;
mod html;
#[cfg(target_os = "linux")]
mod limits;
mod measure;
mod merge;
mod monkey;
mod outputs;
mod parse;
mod picture_args;
mod progress;
mod render;
mod report;
mod sequence;
mod share;
mod stats;
mod submit;
mod why;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};
use sunroom::document::suggest::did_you_mean;
use sunroom::memory;
use sunroom::render::denoise;

use args::EditArgs;
use report::Failure;

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
    /// Put together the parts of a picture that were rendered one by one
    Merge(Box<merge::MergeArgs>),
    /// Make a job that renders a scene on many machines
    Submit(Box<submit::SubmitArgs>),
    /// Export a level with lightmaps for a game engine
    Bake(Box<bake::BakeArgs>),
    /// Measure illuminance at the measuring points and grids of a scene
    Measure(Box<measure::MeasureArgs>),
    /// Report what is wrong with scene files
    Check(check::CheckArgs),
    /// Load a scene and write it back as the program understands it
    Convert(convert::ConvertArgs),
    /// Measure how much a picture differs from another
    Diff(Box<diff::DiffArgs>),
    /// Say where the light of a place in the picture comes from, or where the light of a lamp goes
    Why(Box<why::WhyArgs>),
    /// Measure how fast this machine and this version are
    Bench(bench::BenchArgs),
    /// Print the completions of a shell
    Completions(generate::CompletionsArgs),
    /// Write the manual pages
    Man(generate::ManArgs),
}

/// Runs the command given by the arguments of the process.
pub fn run() -> ExitCode {
    #[cfg(target_os = "linux")]
    if let Err(message) = limits::check() {
        return report::error(message);
    }
    // This comes first, since the other arguments make no sense then.
    if let Some(message) = no_command() {
        return report::wrong_usage(message);
    }
    let cli = match Cli::try_parse_from(parse::with_negative_values(std::env::args_os())) {
        Ok(cli) => cli,
        Err(error) => {
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { report::WRONG_USAGE } else { 0 });
        }
    };
    if let Some(Err(message)) = memory::budget_of_variable() {
        return report::wrong_usage(format_args!("{}: {message}", memory::VARIABLE));
    }
    let done = match cli.command {
        None => edit(cli.edit),
        Some(Command::Edit(args)) => edit(args),
        Some(Command::Render(args)) => render::run(&args),
        Some(Command::Merge(args)) => merge::run(&args),
        Some(Command::Submit(args)) => submit::run(&args),
        Some(Command::Bake(args)) => bake::run(&args),
        Some(Command::Measure(args)) => measure::run(&args),
        Some(Command::Check(args)) => Ok(check::run(&args)),
        Some(Command::Convert(args)) => convert::run(&args),
        Some(Command::Diff(args)) => diff::run(&args),
        Some(Command::Why(args)) => why::run(&args),
        Some(Command::Bench(args)) => bench::run(&args),
        Some(Command::Completions(args)) => generate::completions(Cli::command(), &args),
        Some(Command::Man(args)) => generate::man(Cli::command(), &args),
    };
    let code = done.unwrap_or_else(Failure::report);
    denoise::end_all();
    code
}

/// The message if the first argument is a plain word, but neither a command nor the name of a file, which would be a
/// scene to edit.
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
fn edit(args: EditArgs) -> Result<ExitCode, Failure> {
    edit::run(args)
}

#[cfg(not(feature = "window"))]
fn edit(_: EditArgs) -> Result<ExitCode, Failure> {
    Err("this program was built without a window (cargo feature `window`); `sunroom render` works without one".into())
}
