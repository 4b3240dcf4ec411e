//! `sunroom edit`: opens the window.

use std::path::PathBuf;
use std::process::ExitCode;

use sunroom::app::editor::automation::monkey::{Monkey, run_windowless};
use sunroom::app::editor::command::samples::SAMPLES;
use sunroom::app::editor::session::options::SettlingOptions;
use sunroom::app::windowed::{self, WindowOptions};

use super::args::{EditArgs, SettlingArgs, SettlingFormat};
use super::{outputs, report};

/// The sample scene that opens if none is named.
const FIRST_SCENE: &str = "cornell-box.xml";

pub fn run(args: EditArgs) -> ExitCode {
    args.memory.apply();
    args.threads.report_limit();
    let all = args.scene.iter().chain(&args.monkey.more_scenes);
    if let Some(scene) = all.into_iter().find(|scene| !scene.is_file()) {
        return report::error(format_args!("{}: there is no such file", scene.display()));
    }
    if let Some(Err(error)) = args.screenshot.as_deref().map(outputs::check_text) {
        return report::error(error);
    }
    let read: Vec<PathBuf> = args.scene.iter().chain(&args.script).cloned().collect();
    if let Err(error) = outputs::check_inputs_stay(args.screenshot.as_slice(), &read, "what is opened") {
        return report::error(error);
    }
    let measure_settling = match settling(args.settling) {
        Ok(options) => options,
        Err(error) => return report::error(error),
    };
    let begins = args.scene.is_none();
    let scene = args.scene.or_else(first_scene);
    let monkey = args.monkey.options(scene.as_ref());
    if args.monkey.no_window
        && let Some(options) = monkey
    {
        return match Monkey::new(options) {
            Ok(monkey) => run_windowless(monkey, args.threads.threads),
            Err(error) => report::error(format_args!("the monkey's files cannot be written: {error}")),
        };
    }
    let options = WindowOptions {
        // The monkey opens copies.
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
    windowed::run(options).unwrap_or_else(report::error)
}

/// The options of the measurement, if it is asked for; makes the folder for its pictures.
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
