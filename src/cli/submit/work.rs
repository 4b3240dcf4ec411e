//! The work of a job's tasks: rendering parts of frames, or baking shares of a level.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Instant;

use bevy::prelude::World;
use clap::Parser;
use sunroom::bake::limits::USUAL_SAMPLES;
use sunroom::bake::part::read_part;
use sunroom::engine::{RenderControl, active_film, full_size};

use super::args::{SubmitArgs, System};
use crate::cli::bake::{self, BakeArgs};
use crate::cli::parse::with_negative_values;
use crate::cli::render::{RenderArgs, apply_overrides};
use crate::cli::report::{self, Failure};

/// The time in seconds for which light is gathered to measure the speed of a bake.
const BAKE_SECONDS: f64 = 4.0;

/// The command of the tasks, with its options.
pub enum Work {
    Render(Box<RenderArgs>),
    Bake(Box<BakeArgs>),
}

/// The options of a command, without its name.
#[derive(Parser)]
#[command(no_binary_name = true)]
struct Options<T: clap::Args> {
    #[command(flatten)]
    options: T,
}

impl Work {
    /// Parses the options of this job's tasks. None may be given twice, and some conflict with those that each task
    /// adds.
    pub fn of(args: &SubmitArgs) -> Result<Self, Failure> {
        let mut words = vec![args.scene.scene.clone().into_os_string()];
        if let Some(frames) = &args.frames {
            words.extend(["--frames".into(), frames.start().to_string().into()]);
        }
        words.extend(options(args).into_iter().map(Into::into));
        let mut add = |added: &[&str]| words.extend(added.iter().map(Into::into));
        add(&["--spp", "1", "--samples", "0..1", "--checkpoint", "c", "--resume", "c"]);
        if args.bake {
            add(&["--output", "part"]);
            return Ok(Self::Bake(Box::new(parse(words)?)));
        }
        add(&["--crop", "0,0,1,1"]);
        if matches!(args.to, System::Openjd) {
            add(&["--stats=json-lines"]);
        }
        let render: RenderArgs = parse(words)?;
        if !render.output.is_empty() || args.frames.is_none() && render.sequence.frames.is_some() {
            let message = "the options after `--`: tasks have their own --output, and --frames comes before `--`";
            return Err(Failure::Usage(message.to_owned()));
        }
        // A task renders a single frame, not a whole turntable.
        render.sequence.first_outputs(&[])?;
        Ok(Self::Render(Box::new(render)))
    }

    /// The command of `sunroom` that does a task.
    pub fn command(&self) -> &'static str {
        match self {
            Self::Render(_) => "render",
            Self::Bake(_) => "bake",
        }
    }

    /// The samples of each pixel or texel, and the width and the height of a frame in pixels; a bake is not divided by
    /// texels, and counts as one pixel.
    pub fn extent(&self, args: &SubmitArgs, world: &mut World) -> Result<(u32, [u32; 2]), Failure> {
        let options = match self {
            Self::Render(options) => options,
            Self::Bake(_) => {
                let spp = args.spp.unwrap_or(USUAL_SAMPLES);
                bake::check_samples(&(0..spp), None)?;
                return Ok((spp, [1; 2]));
            }
        };
        apply_overrides(world, options)?;
        let film = active_film(world).ok_or_else(|| format!("{} has no camera", args.scene.scene.display()))?;
        let size = full_size(film, world.resource::<RenderControl>()).to_array();
        Ok((args.spp.unwrap_or(film.sample_count), size))
    }

    /// The estimated seconds for a frame or the bake on this machine, measured on a small part.
    pub fn seconds(&self, args: &SubmitArgs, spp: u32) -> Result<f64, Failure> {
        match self {
            Self::Render(options) => frame_seconds(args, options, spp),
            Self::Bake(options) => bake_seconds(args, options, spp),
        }
    }
}

/// The options that the user has given for each task.
pub fn options(args: &SubmitArgs) -> Vec<String> {
    let defines = args.scene.defines.defines.iter();
    let defines = defines.flat_map(|(name, value)| ["-D".to_owned(), format!("{name}={value}")]);
    let missing = args.missing.allow_missing.then(|| "--allow-missing".to_owned());
    defines.chain(missing).chain(args.options.iter().cloned()).collect()
}

fn parse<T: clap::Args>(words: Vec<OsString>) -> Result<T, Failure> {
    let parsed = Options::try_parse_from(with_negative_values(words)).map_err(|error| {
        // The rest of the message is the usage of another command.
        let text = error.to_string();
        let text = text.split("\n\n").next().unwrap_or_default();
        Failure::Usage(format!(
            "the options after `--`: {}",
            text.trim_start_matches("error: ")
        ))
    })?;
    Ok(parsed.options)
}

/// The program with these words and the options of tasks, without progress.
fn measured(args: &SubmitArgs, command: &str, output: &Path, is_quiet: bool, more: &[&str]) -> Result<Output, Failure> {
    let mut program = Command::new(std::env::current_exe()?);
    program.arg(command).arg(&args.scene.scene).arg("-o").arg(output);
    // The output of tasks is not needed here, and no option may be given twice.
    program.args(options(args).iter().filter(|option| !option.starts_with("--stats")));
    program.args((!is_quiet).then_some("--quiet")).args(more);
    Ok(program.output()?)
}

fn frame_seconds(args: &SubmitArgs, options: &RenderArgs, spp: u32) -> Result<f64, Failure> {
    let folder = tempfile::tempdir()?;
    let first = args.frames.as_ref().map(|frames| frames.start().to_string());
    let mut more = vec!["--time", "5s", "--stats=json"];
    if let Some(first) = &first {
        more.extend(["--frames", first]);
    }
    let output = measured(args, "render", &folder.path().join("a.pfm"), options.quiet, &more)?;
    // If the time limit ends before each pixel has a sample, the render fails, but it still prints its figures.
    let Ok(stats) = serde_json::from_slice::<serde_json::Value>(&output.stdout) else {
        report::line(String::from_utf8_lossy(&output.stderr).trim_end());
        return Err("the scene cannot be rendered as the tasks would render it".into());
    };
    let number = |name: &str| stats[name].as_f64().unwrap_or(0.0);
    let samples = number("width") * number("height") * f64::from(spp);
    Ok(number("load_ms") / 1e3 + samples / (number("msamples_per_s") * 1e6).max(1.0))
}

/// Gathers one sample of each texel, and if that was short, as many as take a few seconds.
fn bake_seconds(args: &SubmitArgs, options: &BakeArgs, spp: u32) -> Result<f64, Failure> {
    let folder = tempfile::tempdir()?;
    let share = folder.path().join("a.bake");
    // The seconds without gathering, and those per sample.
    let measure = |samples: u32| -> Result<[f64; 2], Failure> {
        let begin = Instant::now();
        let range = format!("0..{samples}");
        let output = measured(args, "bake", &share, options.quiet, &["--samples", &range])?;
        if !output.status.success() {
            report::line(String::from_utf8_lossy(&output.stderr).trim_end());
            return Err("the scene cannot be baked as the tasks would bake it".into());
        }
        let all = begin.elapsed().as_secs_f64();
        let (_, _, light) = read_part(&share).map_err(|error| error.to_string())?;
        let gathering: f64 = light.spent.iter().map(|spent| spent.as_secs_f64()).sum();
        Ok([all - gathering, gathering / f64::from(samples)])
    };
    let mut seconds = measure(1)?;
    let affordable = (BAKE_SECONDS / seconds[1].max(1e-9)).clamp(1.0, f64::from(spp)) as u32;
    if affordable > 1 {
        seconds = measure(affordable)?;
    }
    Ok(seconds[0] + seconds[1] * f64::from(spp))
}
