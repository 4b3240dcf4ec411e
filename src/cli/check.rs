//! `sunroom check`: reads scenes and the files they name, and reports.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use bevy::prelude::World;
use clap::Args;
use sunroom::app::headless::render_only;
use sunroom::engine::{Limits, RenderStatus, load_to_completion};
use sunroom::scene::{AreaLight, Emitter, OpenScene, SceneStatus, Shape, cameras};

use super::{DefineArgs, MemoryArgs, TrustArgs, report};

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
    /// Treat warnings as errors
    #[arg(long)]
    strict: bool,
}

pub fn run(args: CheckArgs) -> ExitCode {
    args.memory.apply();
    // One with errors does not keep those after it from being looked at.
    let faulty = args.scenes.iter().filter(|scene| !check(scene, &args)).count();
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
    let mut app = render_only(
        OpenScene {
            path: scene.to_owned(),
            defines: args.defines.defines.clone(),
            ..OpenScene::default()
        },
        Some(1),
    );
    app.insert_resource(trust);
    let loaded = load_to_completion(&mut app, &Limits::default());
    let shown = scene.display();
    let status = app.world().resource::<SceneStatus>();
    let is_good = report_scene(status, args.strict);
    let has_errors = status.has_errors() || !status.damaged_pictures.is_empty();
    if let Err(error) = loaded
        && is_good
    {
        report::error(format_args!("{shown}: {error}"));
        return false;
    }
    // What can be read and yet not be shown.
    let left_out = &app.world().resource::<RenderStatus>().errors;
    for warning in left_out {
        report::line(format_args!("warning: {shown}: {warning}"));
    }
    if has_errors {
        return false;
    }
    if !is_good || args.strict && !left_out.is_empty() {
        report::line(format_args!("{shown}: refused for its warnings"));
        return false;
    }
    let content = content(app.world_mut());
    report::line(format_args!("{shown}: no errors, {content}"));
    list_cameras(app.world_mut());
    true
}

/// How much there is in a scene.
fn content(world: &mut World) -> String {
    let shapes = world.query::<&Shape>().iter(world).count();
    let lights = world.query::<&Emitter>().iter(world).count() + world.query::<&AreaLight>().iter(world).count();
    format!("{}, {}", counted(shapes, "shape"), counted(lights, "light"))
}

fn counted(number: usize, what: &str) -> String {
    match number {
        1 => format!("1 {what}"),
        _ => format!("{number} {what}s"),
    }
}

/// What `--camera` accepts, where there is a choice.
fn list_cameras(world: &mut World) {
    let cameras = cameras(world);
    if cameras.len() > 1 {
        for ((_, name), index) in cameras.iter().zip(0..) {
            report::line(format_args!("camera {index}: {name}"));
        }
    }
}

/// Prints everything there is to say about a loaded scene; false if it is not good enough to go on.
pub fn report_scene(status: &SceneStatus, strict: bool) -> bool {
    report::diagnostics(&status.diagnostics);
    for warning in &status.mesh_warnings {
        report::line(format_args!("warning: {warning}"));
    }
    for problem in &status.mesh_errors {
        report::line(format_args!("error: {}", problem.message));
    }
    for problem in &status.damaged_pictures {
        report::line(format_args!("error: {problem}"));
    }
    for problem in status.picture_problems.iter().chain(&status.picture_warnings) {
        report::line(format_args!("warning: {problem}"));
    }
    let warnings = [
        &status.mesh_warnings,
        &status.picture_problems,
        &status.picture_warnings,
    ];
    let files_are_clean = warnings.iter().all(|list| list.is_empty());
    let is_whole = !status.has_errors() && status.damaged_pictures.is_empty();
    report::acceptable(&status.diagnostics, strict) && (files_are_clean || !strict) && is_whole
}
