//! `sunroom bake`: from a scene file to a level with lightmaps.

mod args;
mod progress;

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bevy::prelude::App;
use sunroom::app::baking::{BakedLevel, baked_level};
use sunroom::app::headless::render_only;
use sunroom::app::threads::worker_count;
use sunroom::bake::files;
use sunroom::bake::job::{BakeEnding, BakeJob, BakeLimits, BakeSettings, BakeSource};
use sunroom::bake::manifest::BakedLight;
use sunroom::bake::probes::ProbeSettings;
use sunroom::bake::unwrap::UnwrapSettings;
use sunroom::document::paths::settle;
use sunroom::engine::{Limits, PackedScene, RenderState, RenderStatus, load_to_completion};
use sunroom::render::denoise::DenoiseError;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::View;
use sunroom::scene::assets::scene_asset::load_document;
use sunroom::scene::export::Hidden;
use sunroom::scene::{OpenScene, SceneStatus, read};

pub use self::args::BakeArgs;

use self::progress::BakeProgress;

use super::check::{has_only_warnings, report_left_out, report_scene};
use super::ending::INTERRUPTED;
use super::render::cancel_on_interrupt;
use super::report::{self, Failure, counted};

pub fn run(args: BakeArgs) -> ExitCode {
    args.memory.apply();
    args.threads.report_limit();
    match bake(&args) {
        Ok(code) => code,
        Err(failure) => failure.report(),
    }
}

fn bake(args: &BakeArgs) -> Result<ExitCode, Failure> {
    if !args.no_denoise && !cfg!(feature = "denoise") {
        return Err(Failure::Usage(format!(
            "{}; --no-denoise bakes without it",
            DenoiseError::NotBuilt
        )));
    }
    let is_new = !args.output.exists();
    files::prepare(&args.output)?;
    let result = bake_into(args);
    // Nothing is left of a bake that has failed.
    if is_new && !matches!(result, Ok(ExitCode::SUCCESS)) {
        let _ = std::fs::remove_dir(&args.output);
    }
    result
}

/// Bakes into a folder that is there.
fn bake_into(args: &BakeArgs) -> Result<ExitCode, Failure> {
    let cancel = cancel_on_interrupt()?;
    let Some((scene, mut view)) = packed(args, &cancel)? else {
        return Ok(ExitCode::FAILURE);
    };
    let Some(level) = level(args)? else {
        return Ok(ExitCode::FAILURE);
    };
    if let Some(seed) = args.seed {
        view.seed = seed;
    }
    let threads = worker_count(args.threads.threads, false).get();
    let source = BakeSource {
        scene,
        view,
        level: level.writer,
        probes: level.probes,
        pool: Arc::new(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?),
    };
    let mut job = BakeJob::prepare(source, &settings(args), &cancel, &mut |_| {})?;
    for warning in job.warnings() {
        report::line(format_args!("warning: {warning}"));
    }
    let blueprint = job.blueprint();
    if !args.quiet {
        report::line(format_args!(
            "{} in {} of {} x {}, {:.4} texels per unit, {}",
            counted(blueprint.nodes.len(), "shape"),
            counted(blueprint.page_count(), "lightmap"),
            blueprint.places.size.x,
            blueprint.places.size.y,
            blueprint.texels_per_unit,
            counted(blueprint.places.texels.len(), "texel"),
        ));
    }
    let limits = BakeLimits {
        samples: args.spp,
        time: args.time,
        noise: args.noise,
    };
    let mut progress = BakeProgress::new(args.quiet, &limits);
    let ending = job.run(&limits, &cancel, &mut |job, now| progress.show(job, now))?;
    if ending == BakeEnding::Cancelled {
        job.finish_so_far(&mut |job, now| progress.show(job, now))?;
    }
    progress.end();
    let Some(baked) = job.baked() else {
        return Err("there is nothing to write".into());
    };
    files::write(&args.output, job.blueprint(), baked)?;
    if job.invalid_samples() > 0 {
        let samples = counted(job.invalid_samples(), "sample");
        report::line(format_args!("warning: {samples} not finite, which count as black"));
    }
    let place = args.output.display();
    if ending == BakeEnding::Cancelled {
        let samples = counted(baked.samples, "sample");
        report::error(format_args!(
            "interrupted; the lightmaps in {place} have {samples} per texel, and probes that were not finished are left out"
        ));
        return Ok(ExitCode::from(INTERRUPTED));
    }
    if !args.quiet {
        report::line(format_args!("the level is in {place}"));
    }
    Ok(ExitCode::SUCCESS)
}

fn light(args: &BakeArgs) -> BakedLight {
    match args.indirect_only {
        true => BakedLight::WithoutDirectPunctual,
        false => BakedLight::All,
    }
}

fn settings(args: &BakeArgs) -> BakeSettings {
    BakeSettings {
        unwrap: UnwrapSettings {
            atlas_size: args.atlas_size,
            texels_per_unit: args.texels_per_unit,
            ..UnwrapSettings::default()
        },
        light: light(args),
        probes: (!args.no_probes).then_some(ProbeSettings {
            size: args.probe_size,
            spacing: args.probe_spacing,
        }),
        denoise: !args.no_denoise,
    }
}

/// The scene as it is rendered; None if it is refused, which has been reported.
fn packed(args: &BakeArgs, cancel: &Arc<AtomicBool>) -> Result<Option<(RenderScene, View)>, Failure> {
    let trust = args.trust.trust(&args.scene.scene)?;
    let open = OpenScene {
        path: args.scene.scene.clone(),
        defines: args.scene.defines.defines.clone(),
        ..OpenScene::default()
    };
    let mut app: App = render_only(open, args.threads.threads);
    app.insert_resource(trust);
    let limits = Limits {
        cancel: cancel.clone(),
        ..Limits::default()
    };
    let loaded = load_to_completion(&mut app, &limits);
    let status = app.world().resource::<SceneStatus>();
    if !report_scene(status, args.strict) {
        if has_only_warnings(status) {
            report::refused_for_warnings(&args.scene.scene);
        }
        return Ok(None);
    }
    if !loaded? {
        return Err("interrupted while the scene was being loaded: nothing is written".into());
    }
    let engine = app.world().resource::<RenderStatus>();
    if engine.state != RenderState::Failed && !report_left_out(engine, &args.scene.scene, args.strict) {
        if engine.shortages.is_empty() {
            report::refused_for_warnings(&args.scene.scene);
        }
        return Ok(None);
    }
    let packed = app.world().resource::<PackedScene>();
    match (packed.scene.clone(), packed.view.clone()) {
        (Some(scene), Some(view)) => Ok(Some((scene, view))),
        _ => Err(format!("{}: there is nothing to bake", args.scene.scene.display()).into()),
    }
}

/// The level and the probes as they are in the file of the scene; None if it is refused, which has been reported. Messages about the scene itself have been printed when
/// it was loaded.
fn level(args: &BakeArgs) -> Result<Option<BakedLevel>, Failure> {
    let path = settle(&args.scene.scene);
    let access = args.trust.trust(&args.scene.scene)?.access(&path);
    let mut document = load_document(&path, &args.scene.defines.defines, access)?;
    let scene = read::read(&mut document);
    let level = baked_level(&scene, &Hidden::default(), light(args), &args.output, &document.access)?;
    for message in &level.messages {
        report::line(format_args!("warning: {message}"));
    }
    if args.strict && !level.messages.is_empty() {
        report::refused_for_warnings(&args.scene.scene);
        return Ok(None);
    }
    Ok(Some(level))
}
