//! `sunroom check`: reads scenes and the files they name, and reports problems.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use bevy::prelude::{App, World};
use clap::Args;
use sunroom::app::baking::probe_faults;
use sunroom::app::headless::render_only;
use sunroom::app::metering::meter_faults;
use sunroom::engine::{Limits, RenderState, RenderStatus, load_to_completion};
use sunroom::scene::{AreaLight, Emitter, OpenScene, SceneStatus, Shape, Trust, cameras};

use super::args::{DefineArgs, MemoryArgs, MissingArgs, TrustArgs};
use super::report::{self, Failure, counted};

#[derive(Args)]
pub struct CheckArgs {
    /// Scene files (Mitsuba 3 XML, or glTF 2.0)
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    #[command(flatten)]
    defines: DefineArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    trust: TrustArgs,
    #[command(flatten)]
    missing: MissingArgs,
    /// Treat warnings as errors
    #[arg(long)]
    strict: bool,
}

pub fn run(args: &CheckArgs) -> ExitCode {
    args.memory.apply();
    // A scene with errors does not end the check of the others.
    let faulty = args.scenes.iter().filter(|scene| !check(scene, args)).count();
    match faulty {
        0 => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    }
}

/// Reports on one scene; false if it has errors.
fn check(scene: &Path, args: &CheckArgs) -> bool {
    let trust = match args.trust.trust(scene) {
        Ok(trust) => trust,
        Err(error) => {
            report::error(error);
            return false;
        }
    };
    let mut app = open(scene, &args.defines, trust, &args.missing, Some(1));
    let loaded = load_to_completion(&mut app, &Limits::default());
    let shown = scene.display();
    let mut faults = probe_faults(app.world_mut());
    faults.extend(meter_faults(app.world_mut()));
    let status = app.world().resource::<SceneStatus>();
    let is_good = report_scene(status, args.strict);
    let has_errors = status.has_errors() || !status.damaged_pictures.is_empty();
    if let Err(error) = loaded
        && is_good
    {
        report::error(format_args!("{shown}: {error}"));
        return false;
    }
    let engine = app.world().resource::<RenderStatus>();
    let is_shown = report_left_out(engine, scene, args.strict);
    // Pictures do not depend on probes and meters, but the scene cannot be baked or measured.
    for fault in &faults {
        report::error(format_args!("{shown}: {fault}"));
    }
    let found = summary(status, engine, faults.len());
    if has_errors || !engine.shortages.is_empty() || !faults.is_empty() {
        report::line(format_args!("{shown}: {found}"));
        return false;
    }
    if !is_good || !is_shown {
        report::refused_for_warnings(scene);
        return false;
    }
    let warnings = match found.is_empty() {
        true => String::new(),
        false => format!("{found}, "),
    };
    let content = content(app.world_mut());
    report::line(format_args!("{shown}: no errors, {warnings}{content}"));
    list_cameras(app.world_mut());
    true
}

/// The numbers of errors and warnings, including those of the engine, of probes and of meters, such as "2 errors, 1
/// warning".
fn summary(status: &SceneStatus, engine: &RenderStatus, faults: usize) -> String {
    let all = status.all_diagnostics();
    let left_out = engine.errors.iter().filter(|what| !engine.shortages.contains(what));
    let numbers = [
        (all.error_count() + engine.shortages.len() + faults, "error"),
        (all.warning_count() + left_out.count(), "warning"),
    ];
    let named = numbers.into_iter().filter(|&(number, _)| number > 0);
    let parts: Vec<_> = named.map(|(number, what)| counted(number, what)).collect();
    parts.join(", ")
}

/// The number of things of each kind in a scene.
fn content(world: &mut World) -> String {
    let shapes = world.query::<&Shape>().iter(world).count();
    let mut emitters = world.query::<&Emitter>();
    let probes = emitters.iter(world).filter(|emitter| emitter.is_probe()).count();
    let meters = emitters.iter(world).filter(|emitter| emitter.is_meter()).count();
    let lights = emitters.iter(world).filter(|emitter| emitter.shines()).count()
        + world.query::<&AreaLight>().iter(world).count();
    let markers = emitters.iter(world).filter(|emitter| emitter.is_marker()).count();
    let others = [(probes, "probe"), (meters, "meter"), (markers, "marker")]
        .into_iter()
        .filter(|(count, _)| *count > 0);
    let all = [(shapes, "shape"), (lights, "light")].into_iter().chain(others);
    all.map(|(count, what)| counted(count, what))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Lists the values for `--camera`, if there is a choice.
fn list_cameras(world: &mut World) {
    let cameras = cameras(world);
    if cameras.len() > 1 {
        for ((_, name), index) in cameras.iter().zip(0..) {
            report::line(format_args!("camera {index}: {name}"));
        }
    }
}

/// An app that will load a scene to render it.
pub fn open(scene: &Path, defines: &DefineArgs, trust: Trust, missing: &MissingArgs, threads: Option<i32>) -> App {
    let open = OpenScene {
        path: scene.to_owned(),
        defines: defines.defines.clone(),
        ..OpenScene::default()
    };
    let mut app = render_only(open, threads);
    app.insert_resource(trust);
    app.world_mut().resource_mut::<SceneStatus>().allows_missing = missing.allow_missing;
    app
}

/// Loads the scene of an app; false if it is refused, which has been reported.
pub fn load(app: &mut App, limits: &Limits, scene: &Path, strict: bool) -> Result<bool, Failure> {
    let loaded = load_to_completion(app, limits);
    let status = app.world().resource::<SceneStatus>();
    if !report_scene(status, strict) {
        if !status.has_errors() && report::acceptable(&status.all_diagnostics(), false) {
            report::refused_for_warnings(scene);
        } else if status.lacks_only_files() {
            report::refused_for_missing(scene);
        }
        return Ok(false);
    }
    match loaded? {
        true => Ok(true),
        false => Err("interrupted while the scene was being loaded: nothing is written".into()),
    }
}

/// Whether a loaded scene is complete enough to be rendered. Missing parts are reported.
pub fn is_shown(app: &App, scene: &Path, strict: bool) -> bool {
    let engine = app.world().resource::<RenderStatus>();
    let is_shown = engine.state == RenderState::Failed || report_left_out(engine, scene, strict);
    if !is_shown && engine.shortages.is_empty() {
        report::refused_for_warnings(scene);
    }
    is_shown
}

/// Prints all messages about a loaded scene; false if its problems are too severe to continue.
pub fn report_scene(status: &SceneStatus, strict: bool) -> bool {
    let all = status.all_diagnostics();
    report::diagnostics(&all);
    report::acceptable(&all, strict) && !status.has_errors()
}

/// Prints the parts that were read but cannot be shown; false if they are too many to continue.
fn report_left_out(status: &RenderStatus, scene: &Path, strict: bool) -> bool {
    let shown = scene.display();
    for message in &status.errors {
        match status.shortages.contains(message) {
            true => drop(report::error(format_args!("{shown}: {message}"))),
            false => report::line(format_args!("warning: {shown}: {message}")),
        }
    }
    status.shortages.is_empty() && (!strict || status.errors.is_empty())
}
