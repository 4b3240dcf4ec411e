//! `sunroom bake`: from a scene file to a level with lightmaps.

mod args;
mod keeping;
mod progress;
mod shares;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bevy::prelude::App;
use sunroom::app::baking::{BakedLevel, baked_level};
use sunroom::app::headless::render_only;
use sunroom::app::origin::origin;
use sunroom::app::signals::{is_terminated, note_termination};
use sunroom::app::threads::worker_count;
use sunroom::bake::blueprint::Blueprint;
use sunroom::bake::files::{self, Content};
use sunroom::bake::job::{BakeEnding, BakeJob, BakeSettings, BakeSource};
use sunroom::bake::limits::BakeLimits;
use sunroom::bake::manifest::BakedLight;
use sunroom::bake::part::is_part;
use sunroom::bake::probes::ProbeSettings;
use sunroom::bake::progress::about_invalid;
use sunroom::bake::unwrap::UnwrapSettings;
use sunroom::document::paths::settle;
use sunroom::engine::{Limits, PackedScene, RenderState, RenderStatus, load_to_completion};
use sunroom::files::{check_writable, is_same_file, keep_reads};
use sunroom::scene::assets::scene_asset::load_document;
use sunroom::scene::export::Hidden;
use sunroom::scene::{OpenScene, SceneStatus, read};

pub use self::args::BakeArgs;
pub use self::shares::Shares;

use self::keeping::Keeper;
use self::progress::BakeProgress;

use super::check::{report_left_out, report_refusal, report_scene};
use super::ending::{INTERRUPTED, TERMINATED};
use super::outputs::check_scene_stays;
use super::render::cancel_on_interrupt;
use super::report::{self, Failure, check_denoiser, counted};
use super::share::{Settings, check_cut};

/// How a bake does without a denoiser.
pub const BAKES_WITHOUT: &str = "--no-denoise bakes without it";

/// The end of the last share at most: a point of a volume has eight times as many samples.
const MOST_SAMPLES_OF_SHARES: u32 = u32::MAX / 8;

pub fn run(args: BakeArgs) -> ExitCode {
    args.memory.apply();
    args.threads.report_limit();
    match bake(&args) {
        Ok(code) => code,
        Err(failure) => failure.report(),
    }
}

fn bake(args: &BakeArgs) -> Result<ExitCode, Failure> {
    let Some(samples) = &args.samples else {
        check_denoiser(!args.no_denoise, BAKES_WITHOUT)?;
        return within_folder(&args.output, || {
            args.checkpoints
                .check("bake", |path| is_file_of_level(&args.output, path), is_part)?;
            bake_whole(args)
        });
    };
    check_samples(samples, args.spp)?;
    let name = args.output.display();
    if args.output.is_dir() {
        return Err(Failure::Usage(format!(
            "{name} is a folder: a share of a bake is one file"
        )));
    }
    check_writable(&args.output).map_err(|error| format!("cannot write {name}: {error}"))?;
    args.checkpoints
        .check("bake", |path| is_same_file(&args.output, path), is_part)?;
    bake_share(args, [samples.start, samples.end])
}

/// Whether a bake into the folder may replace this file, be it there or not.
fn is_file_of_level(folder: &Path, path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default();
    files::is_name_of_bake(&name.to_string_lossy()) && is_same_file(&folder.join(name), path)
}

/// Refuses ranges of samples that cannot be shares of a bake of `spp` samples, if that number is known.
pub fn check_samples(samples: &Range<u32>, spp: Option<u32>) -> Result<(), Failure> {
    check_cut(samples)?;
    if spp.is_some_and(|spp| samples.end > spp) {
        let message = "the range of --samples goes beyond --spp, the samples of the whole bake";
        return Err(Failure::Usage(message.to_owned()));
    }
    match samples.end > MOST_SAMPLES_OF_SHARES {
        true => Err(Failure::Usage(format!(
            "samples of shares end at {MOST_SAMPLES_OF_SHARES} at most, and these at {}",
            samples.end
        ))),
        false => Ok(()),
    }
}

/// Makes the folder and has it filled. Nothing is left of a bake that has failed.
fn within_folder(folder: &Path, fill: impl FnOnce() -> Result<ExitCode, Failure>) -> Result<ExitCode, Failure> {
    let _folder = files::OutputFolder::prepare(folder)?;
    fill()
}

/// A job, and what looks after it.
struct Begun<'a> {
    job: BakeJob,
    keeper: Keeper<'a>,
    progress: BakeProgress,
    cancel: Arc<AtomicBool>,
}

/// Prepares the bake of so many samples of each texel, and lets it go on with a checkpoint; None if the scene is
/// refused, which has been reported.
fn begin<'a>(args: &'a BakeArgs, samples: [u32; 2], limits: &BakeLimits) -> Result<Option<Begun<'a>>, Failure> {
    let cancel = cancel_on_interrupt()?;
    if args.checkpoints.checkpoint.is_some() {
        note_termination(cancel.clone());
    }
    keep_reads();
    let Some(mut app) = packed(args, &cancel)? else {
        return Ok(None);
    };
    let Some(level) = level(args)? else {
        return Ok(None);
    };
    let replaced = files::replaceable(&args.output).into_iter();
    check_scene_stays(
        replaced
            .chain([args.output.clone()])
            .chain(args.checkpoints.checkpoint.clone()),
    )?;
    let mut packed = app.world_mut().resource_mut::<PackedScene>();
    if let (Some(seed), Some(view)) = (args.seed, &mut packed.view) {
        view.seed = seed;
    }
    let (Some(scene), Some(view)) = (packed.scene.clone(), packed.view.clone()) else {
        return Err(format!("{}: there is nothing to bake", args.scene.scene.display()).into());
    };
    let origin = origin(app.world_mut(), &args.scene.scene, settings_by_name(args))?;
    drop(app);
    let threads = worker_count(args.threads.threads, false).get();
    let source = BakeSource {
        scene,
        view,
        level: level.writer,
        probes: level.probes,
        pool: Arc::new(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?),
        is_seen: false,
        discards: Arc::default(),
    };
    let mut progress = BakeProgress::new(args.quiet, limits);
    let mut job = BakeJob::prepare(source, &settings(args), &cancel, &mut |now, words| {
        progress.prepare(now, words)
    })?;
    progress.end();
    for warning in job.warnings() {
        report::line(format_args!("warning: {warning}"));
    }
    if args.strict && !job.warnings().is_empty() {
        report::refused_for_warnings(&args.scene.scene);
        return Ok(None);
    }
    if args.samples.is_some() {
        job.begin_share(samples)?;
    }
    let keeper = Keeper::new(args, origin, samples);
    keeper.take_up(&mut job, args)?;
    if !args.quiet {
        report::line(summary(job.blueprint()));
    }
    Ok(Some(Begun {
        job,
        keeper,
        progress,
        cancel,
    }))
}

/// Bakes into a folder that is there.
fn bake_whole(args: &BakeArgs) -> Result<ExitCode, Failure> {
    let limits = BakeLimits {
        samples: args.spp,
        time: args.time,
        noise: args.noise,
    };
    let Some(begun) = begin(args, [0, limits.target()], &limits)? else {
        return Ok(ExitCode::FAILURE);
    };
    let Begun {
        mut job,
        mut keeper,
        mut progress,
        cancel,
    } = begun;
    let ending = job.run(&limits, &cancel, &mut |job, now| {
        keeper.look(job, now);
        progress.show(job, now);
    })?;
    progress.end();
    let is_saved = keeper.save(&job);
    let kept = args.checkpoints.checkpoint.as_ref().filter(|_| is_saved);
    if ending == BakeEnding::Cancelled {
        if let Some(path) = kept.filter(|_| is_terminated()) {
            report::line(format_args!("terminated; {} has what was gathered", path.display()));
            return Ok(ExitCode::from(TERMINATED));
        }
        if let Some(path) = kept.filter(|_| job.light().samples() == 0) {
            let path = path.display();
            report::error(format_args!(
                "interrupted before the first samples of all texels; {path} has what was gathered, and no lightmap is written"
            ));
            return Ok(ExitCode::from(INTERRUPTED));
        }
        let there = Content::of_folder(&args.output);
        if let Some(there) = there.filter(|there| !job.content().may_replace(there)) {
            report::error(stays(&args.output, job.content(), there, kept));
            return Ok(ExitCode::from(INTERRUPTED));
        }
        job.finish_so_far(&mut |job, now| progress.show(job, now))?;
        progress.end();
    }
    let Some(baked) = job.baked() else {
        return Err("there is nothing to write".into());
    };
    files::write(&args.output, job.blueprint(), baked)?;
    report_invalid(job.invalid_samples());
    let place = args.output.display();
    if ending == BakeEnding::Cancelled {
        let samples = counted(baked.samples, "sample");
        let more = kept.map_or_else(String::new, |path| {
            format!("; {} has what was gathered", path.display())
        });
        report::error(format_args!(
            "interrupted; the lightmaps in {place} have {samples} per texel, and probes that were not finished are left out{more}"
        ));
        return Ok(ExitCode::from(INTERRUPTED));
    }
    if !args.quiet {
        report::line(format_args!("the level is in {place}"));
    }
    Ok(ExitCode::SUCCESS)
}

/// The message about an interrupted bake that does not replace the level in its folder. `kept` is its checkpoint.
fn stays(folder: &Path, gathered: Content, there: Content, kept: Option<&PathBuf>) -> String {
    let end = match kept {
        Some(path) => format!("{} has what was gathered", path.display()),
        None => "nothing is written".to_owned(),
    };
    format!(
        "interrupted with {gathered}: {} keeps its level, which has {there}; {end}",
        folder.display()
    )
}

/// A line about the lightmaps.
fn summary(blueprint: &Blueprint) -> String {
    let size = blueprint.places.size;
    format!(
        "{} in {} of {} x {}, {:.4} texels per unit, {}",
        counted(blueprint.nodes.len(), "shape"),
        counted(blueprint.page_count(), "lightmap"),
        size.x,
        size.y,
        blueprint.texels_per_unit,
        counted(blueprint.places.texels.len(), "texel"),
    )
}

/// Gathers a share and writes its file.
fn bake_share(args: &BakeArgs, samples: [u32; 2]) -> Result<ExitCode, Failure> {
    let limits = BakeLimits {
        samples: Some(samples[1]),
        ..BakeLimits::default()
    };
    let Some(begun) = begin(args, samples, &limits)? else {
        return Ok(ExitCode::FAILURE);
    };
    let Begun {
        mut job,
        mut keeper,
        mut progress,
        cancel,
    } = begun;
    let is_finished = job.gather_share(samples[1], &cancel, &mut |job, now| {
        keeper.look(job, now);
        progress.show(job, now);
    });
    progress.end();
    let is_saved = keeper.save(&job);
    if let Some(path) = args
        .checkpoints
        .checkpoint
        .as_ref()
        .filter(|_| is_saved && is_terminated())
    {
        report::line(format_args!("terminated; {} has what was gathered", path.display()));
        return Ok(ExitCode::from(TERMINATED));
    }
    keeper.write_share(&job, &args.output)?;
    report_invalid(job.invalid_samples());
    let place = args.output.display();
    if !is_finished {
        report::error(format_args!("interrupted; {place} has what was gathered, for --resume"));
        return Ok(ExitCode::from(INTERRUPTED));
    }
    if !args.quiet {
        report::line(format_args!("the share is in {place}"));
    }
    Ok(ExitCode::SUCCESS)
}

fn report_invalid(samples: u64) {
    if let Some(about) = about_invalid(samples) {
        report::line(format_args!("warning: {about}"));
    }
}

/// What samples depend on beside the scene and the view.
fn settings_by_name(args: &BakeArgs) -> Settings {
    let or_default = |number: Option<f32>| number.map_or_else(|| "not given".to_owned(), |number| number.to_string());
    let probes = match args.no_probes {
        true => "none".to_owned(),
        false => format!("{} texels, spacing {}", args.probe_size, or_default(args.probe_spacing)),
    };
    let own = [
        ("the bake", "lightmaps and probes".to_owned()),
        ("--indirect-only", args.indirect_only.to_string()),
        ("--texels-per-unit", or_default(args.texels_per_unit)),
        ("--atlas-size", args.atlas_size.to_string()),
        ("the size of probes", probes),
    ];
    let own = own.into_iter().map(|(name, value)| (name.to_owned(), value));
    let defines = args.scene.defines.defines.iter();
    own.chain(defines.map(|(name, value)| (format!("-D {name}"), value.clone())))
        .collect()
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

/// The app with the scene as it is rendered; None if it is refused, which has been reported.
fn packed(args: &BakeArgs, cancel: &Arc<AtomicBool>) -> Result<Option<App>, Failure> {
    let trust = args.trust.trust(&args.scene.scene)?;
    let open = OpenScene {
        path: args.scene.scene.clone(),
        defines: args.scene.defines.defines.clone(),
        ..OpenScene::default()
    };
    let mut app: App = render_only(open, args.threads.threads);
    app.insert_resource(trust);
    args.missing.apply(&mut app);
    let limits = Limits {
        cancel: cancel.clone(),
        ..Limits::default()
    };
    let loaded = load_to_completion(&mut app, &limits);
    let status = app.world().resource::<SceneStatus>();
    if !report_scene(status, args.strict) {
        report_refusal(status, &args.scene.scene);
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
    Ok(Some(app))
}

/// The level and the probes as they are in the file of the scene; None if it is refused, which has been reported.
/// Messages about the scene itself have been printed when it was loaded.
fn level(args: &BakeArgs) -> Result<Option<BakedLevel>, Failure> {
    let path = settle(&args.scene.scene);
    let access = args.trust.trust(&args.scene.scene)?.access(&path);
    let mut document = load_document(&path, &args.scene.defines.defines, access)?;
    let scene = read::read(&mut document);
    let level = baked_level(&scene, &Hidden::default(), &args.output, &document.access)?;
    for message in &level.messages {
        report::line(format_args!("warning: {message}"));
    }
    if args.strict && !level.messages.is_empty() {
        report::refused_for_warnings(&args.scene.scene);
        return Ok(None);
    }
    Ok(Some(level))
}
