//! `sunroom check`: reads a scene and the files it names, and reports.

use std::process::ExitCode;

use bevy::prelude::World;
use clap::Args;
use sunroom::app::headless::headless;
use sunroom::engine::{Limits, load_to_completion};
use sunroom::scene::{OpenScene, SceneStatus, cameras};

use super::{SceneArgs, report};

#[derive(Args)]
pub struct CheckArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Treat warnings as errors
    #[arg(long)]
    strict: bool,
}

pub fn run(args: CheckArgs) -> ExitCode {
    let mut app = headless(
        OpenScene {
            path: args.scene.scene,
            defines: args.scene.defines.defines,
            ..OpenScene::default()
        },
        Some(1),
    );
    let loaded = load_to_completion(&mut app, &Limits::default());
    let status = app.world().resource::<SceneStatus>();
    if !report_scene(status, args.strict) {
        return ExitCode::FAILURE;
    }
    if let Err(error) = loaded {
        return report::error(error);
    }
    list_cameras(app.world_mut());
    ExitCode::SUCCESS
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
    for problem in &status.picture_problems {
        report::line(format_args!("warning: {problem}"));
    }
    let files_are_clean = status.mesh_warnings.is_empty() && status.picture_problems.is_empty();
    report::acceptable(&status.diagnostics, strict) && (files_are_clean || !strict) && !status.has_errors()
}
