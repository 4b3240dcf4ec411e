//! `sunroom edit`: opens the window.

use std::path::PathBuf;
use std::process::ExitCode;

use sunroom::app::editor::automation::monkey::{Monkey, run_windowless};
use sunroom::app::editor::command::samples::SAMPLES;
use sunroom::app::editor::session::options::SettlingOptions;
use sunroom::app::windowed::{self, WindowOptions};

use super::args::{EditArgs, SettlingArgs, SettlingFormat};
use super::outputs;
use super::report::Failure;

/// The sample scene that opens if none is named.
const FIRST_SCENE: &str = "cornell-box.xml";

pub fn run(args: EditArgs) -> Result<ExitCode, Failure> {
    args.memory.apply();
    args.threads.report_limit();
    let all = args.scene.iter().chain(&args.monkey.more_scenes);
    if let Some(scene) = all.into_iter().find(|scene| !scene.is_file()) {
        return Err(format!("{}: there is no such file", scene.display()).into());
    }
    args.screenshot.as_deref().map_or(Ok(()), outputs::check_text)?;
    let read: Vec<PathBuf> = args.scene.iter().chain(&args.script).cloned().collect();
    outputs::check_inputs_stay(args.screenshot.as_slice(), &read, "what is opened")?;
    let measure_settling = settling(args.settling)?;
    let begins = args.scene.is_none();
    let scene = args.scene.or_else(first_scene);
    let monkey = args.monkey.options(scene.as_ref());
    if args.monkey.no_window
        && let Some(options) = monkey
    {
        let monkey = Monkey::new(options).map_err(|error| format!("the monkey's files cannot be written: {error}"))?;
        return Ok(run_windowless(monkey, args.threads.threads));
    }
    let options = WindowOptions {
        // The monkey opens copies instead.
        scene: scene.filter(|_| monkey.is_none()),
        begins,
        defines: args.defines.defines,
        camera: args.camera,
        size: args.window.map(Into::into),
        threads: args.threads.threads,
        screenshot: args.screenshot,
        script: args.script,
        after_spp: args.after_spp,
        exit: args.exit,
        measure_latency: args.measure_latency,
        measure_settling,
        monkey,
        undrawn: args.undrawn,
        denoise: args.denoise,
        timeout: args.timeout,
    };
    Ok(windowed::run(options)?)
}

/// The options of the measurement, if requested; makes the folder for its pictures.
fn settling(args: SettlingArgs) -> Result<Option<SettlingOptions>, String> {
    let Some(samples) = args.measure_settling else {
        return Ok(None);
    };
    if let Some(folder) = &args.pictures {
        let fails = |error| format!("cannot write to {}: {error}", folder.display());
        std::fs::create_dir_all(folder).map_err(fails)?;
        outputs::check_text(&folder.join("a.png"))?;
    }
    Ok(Some(SettlingOptions {
        samples,
        pictures: args.pictures,
        json: args.stats == Some(SettlingFormat::Json),
    }))
}

fn first_scene() -> Option<PathBuf> {
    SAMPLES.iter().find(|sample| sample.file == FIRST_SCENE)?.path()
}
