//! `sunroom bake`: bakes a scene file to a level with lightmaps.

mod args;
mod keeping;
mod progress;

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bevy::prelude::App;
use sunroom::app::baking::{BakedLevel, baked_level, lamp_layers};
use sunroom::app::origin::origin;
use sunroom::app::threads::worker_count;
use sunroom::bake::blueprint::Blueprint;
use sunroom::bake::files::{self, Content};
use sunroom::bake::job::{BakeEnding, BakeJob, BakeSettings, BakeSource};
use sunroom::bake::limits::BakeLimits;
use sunroom::bake::manifest::BakedLight;
use sunroom::bake::part::is_part;
use sunroom::bake::probes::ProbeSettings;
use sunroom::bake::progress::{Progress, about_invalid};
use sunroom::bake::unwrap::UnwrapSettings;
use sunroom::document::paths::settle;
use sunroom::engine::{Limits, PackedScene};
use sunroom::files::{is_same_file, keep_reads};
use sunroom::scene::assets::scene_asset::load_document;
use sunroom::scene::export::Hidden;
use sunroom::scene::read;

pub use self::args::BakeArgs;

use self::keeping::Keeper;
use self::progress::BakeProgress;

use super::check::{is_shown, load, open};
use super::ending::INTERRUPTED;
use super::outputs::{check_scene_stays, check_text};
use super::report::{self, Failure, check_denoiser, counted};
use super::share::{Settings, check_cut};

/// How to bake without a denoiser.
pub const BAKES_WITHOUT: &str = "--no-denoise bakes without it";

/// The limit of the end of the last share: a point of a volume has eight times as many samples.
const MOST_SAMPLES_OF_SHARES: u32 = u32::MAX / 8;

pub fn run(args: &BakeArgs) -> Result<ExitCode, Failure> {
    args.memory.apply();
    args.threads.report_limit();
    let Some(samples) = &args.samples else {
        check_denoiser(!args.no_denoise, BAKES_WITHOUT)?;
        return within_folder(&args.output, || {
            args.checkpoints
                .check("bake", |path| is_file_of_level(&args.output, path), is_part)?;
            let limits = BakeLimits {
                samples: args.spp,
                time: args.time,
                noise: args.noise,
            };
            bake(args, [0, limits.target()], &limits)
        });
    };
    check_samples(samples, args.spp)?;
    let name = args.output.display();
    if args.output.is_dir() {
        return Err(Failure::Usage(format!(
            "{name} is a folder: a share of a bake is one file"
        )));
    }
    check_text(&args.output)?;
    args.checkpoints
        .check("bake", |path| is_same_file(&args.output, path), is_part)?;
    let limits = BakeLimits {
        samples: Some(samples.end),
        ..BakeLimits::default()
    };
    bake(args, [samples.start, samples.end], &limits)
}

/// Whether a bake into the folder may write or replace this file.
pub fn is_file_of_level(folder: &Path, path: &Path) -> bool {
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

/// Makes the folder and calls `fill`. A failed bake leaves nothing behind.
pub fn within_folder(folder: &Path, fill: impl FnOnce() -> Result<ExitCode, Failure>) -> Result<ExitCode, Failure> {
    let _folder = files::OutputFolder::prepare(folder)?;
    fill()
}

/// Bakes these samples of each texel, and writes the level or the share.
fn bake(args: &BakeArgs, samples: [u32; 2], limits: &BakeLimits) -> Result<ExitCode, Failure> {
    let cancel = args.checkpoints.cancel()?;
    let mut progress = BakeProgress::new(args.quiet, limits);
    let Some((mut job, mut keeper)) = begin(args, samples, &cancel, &mut progress)? else {
        return Ok(ExitCode::FAILURE);
    };
    let watch = &mut |job: &BakeJob, now: &Progress| {
        keeper.look(job, now);
        progress.show(job, now);
    };
    let is_share = args.samples.is_some();
    let is_done = match is_share {
        true => job.gather_share(samples[1], &cancel, watch),
        false => job.run(limits, &cancel, watch)? == BakeEnding::Done,
    };
    progress.end();
    let is_saved = keeper.save(&job);
    if (is_share || !is_done)
        && let Some(code) = args.checkpoints.terminated(is_saved, "gathered")
    {
        return Ok(code);
    }
    let kept = args.checkpoints.checkpoint.as_ref().filter(|_| is_saved);
    let interrupted = |message: String| {
        report::error(message);
        Ok(ExitCode::from(INTERRUPTED))
    };
    if !is_share && !is_done {
        if let Some(message) = why_unfinished(&job, &args.output, kept) {
            return interrupted(message);
        }
        job.finish_so_far(&mut |job, now| progress.show(job, now))?;
        progress.end();
    }
    let place = args.output.display();
    let interruption = match is_share {
        true => {
            keeper.write(&job, &args.output)?;
            format!("interrupted; {place} has what was gathered, for --resume")
        }
        false => {
            let baked = job.baked().ok_or("there is nothing to write")?;
            files::write(&args.output, job.blueprint(), baked)?;
            report_merged(baked.merged);
            let samples = counted(baked.samples, "sample");
            let more = kept.map_or_else(String::new, |path| {
                format!("; {} has what was gathered", path.display())
            });
            format!(
                "interrupted; the lightmaps in {place} have {samples} per texel, and probes that were not finished are left out{more}"
            )
        }
    };
    report_invalid(job.invalid_samples());
    if !is_done {
        return interrupted(interruption);
    }
    if !args.quiet {
        let what = if is_share { "share" } else { "level" };
        report::line(format_args!("the {what} is in {place}"));
    }
    Ok(ExitCode::SUCCESS)
}

/// Prepares a bake of `samples` samples of each texel, and resumes a checkpoint; None if the scene is refused, which
/// has been reported.
fn begin<'a>(
    args: &'a BakeArgs,
    samples: [u32; 2],
    cancel: &Arc<AtomicBool>,
    progress: &mut BakeProgress,
) -> Result<Option<(BakeJob, Keeper<'a>)>, Failure> {
    keep_reads();
    let Some(mut app) = packed(args, cancel)? else {
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
    let layers = args.layers.then(|| lamp_layers(app.world(), args.memory_of_layers()));
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
        layers,
    };
    let mut job = BakeJob::prepare(source, &settings(args), cancel, &mut |now, words| {
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
    Ok(Some((job, keeper)))
}

/// The message about an interrupted bake that has no light yet, or that does not replace the level in its folder; None
/// if its light is written. `kept` is its checkpoint.
fn why_unfinished(job: &BakeJob, folder: &Path, kept: Option<&PathBuf>) -> Option<String> {
    if let Some(path) = kept.filter(|_| job.light().samples() == 0) {
        let path = path.display();
        return Some(format!(
            "interrupted before the first samples of all texels; {path} has what was gathered, and no lightmap is written"
        ));
    }
    let gathered = job.content();
    let there = Content::of_folder(folder).filter(|there| !gathered.may_replace(there))?;
    let end = match kept {
        Some(path) => format!("{} has what was gathered", path.display()),
        None => "nothing is written".to_owned(),
    };
    Some(format!(
        "interrupted with {gathered}: {} keeps its level, which has {there}; {end}",
        folder.display()
    ))
}

/// A line about the size and number of lightmaps.
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

pub fn report_invalid(samples: u64) {
    if let Some(about) = about_invalid(samples) {
        report::line(format_args!("warning: {about}"));
    }
}

/// Says that some layers were merged.
pub fn report_merged(layers: usize) {
    if layers > 0 {
        report::line(format_args!(
            "warning: {} of lightmaps and probes, the weakest of each, are in the rest, which cannot be dimmed: more --layer-memory keeps them apart",
            counted(layers, "layer")
        ));
    }
}

/// The settings on which samples depend, apart from the scene and the view.
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
    let layers = args.layers.then(|| {
        (
            "--layers".to_owned(),
            format!("{} bytes at most", args.memory_of_layers()),
        )
    });
    let defines = args.scene.defines.defines.iter();
    own.chain(layers)
        .chain(defines.map(|(name, value)| (format!("-D {name}"), value.clone())))
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
    let scene = &args.scene.scene;
    let trust = args.trust.trust(scene)?;
    let mut app = open(scene, &args.scene.defines, trust, &args.missing, args.threads.threads);
    let limits = Limits {
        cancel: cancel.clone(),
        ..Limits::default()
    };
    let is_good = load(&mut app, &limits, scene, args.strict)? && is_shown(&app, scene, args.strict);
    Ok(is_good.then_some(app))
}

/// The level and the probes as in the scene file; None if it is refused, which has been reported. Messages about the
/// scene itself have been printed when it was loaded.
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
