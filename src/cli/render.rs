//! `sunroom render`: renders a scene file to image files.

mod args;
mod overrides;
mod picture;
mod rendering;
mod watch;

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Instant;

use bevy::prelude::*;
use sunroom::app::signals::note_show;
use sunroom::engine::{Limits, PackedScene, load_to_completion, open_shutter};
use sunroom::files::keep_reads;
use sunroom::layer::{Layer, Layers};
use sunroom::scene::{IntegratorSettings, KeepSource, SamplerSettings, SceneFile};

pub use self::args::RenderArgs;
pub use self::overrides::{apply_overrides, choose_camera, set_size};

use self::picture::{Picture, file_options};
use self::rendering::samples_of_film;
use super::check::{is_shown, load, open};
use super::display_server;
use super::ending::INTERRUPTED;
use super::outputs::{self, check_compression, has_file};
use super::progress::{InSequence, Progress};
use super::report::{Failure, RENDERS_WITHOUT, check_denoiser};
use super::sequence::{TurningCamera, frame_path};
use super::share::{self, Settings};
use super::stats::{StatsFormat, milliseconds};

pub fn run(args: &RenderArgs) -> Result<ExitCode, Failure> {
    args.memory.apply();
    args.threads.report_limit();
    check(args)?;
    let scene = &args.scene.scene;
    let trust = args.trust.trust(scene)?;
    let cancel = args.checkpoints.cancel()?;
    note_show();
    keep_reads();
    let begin = Instant::now();
    let mut app = open(scene, &args.scene.defines, trust, &args.missing, args.threads.threads);
    // Other frames are read from the same text.
    app.world().resource::<KeepSource>().set(args.sequence.frames.is_some());
    app.insert_resource(args.accel);
    let samples = args.shares.samples.as_ref().map(|samples| samples.end).or(args.spp);
    let limits = Limits {
        // If only a limit of time or noise is given, the file's number of samples is ignored.
        samples: samples.or((args.time.is_some() || args.noise.is_some()).then_some(u32::MAX)),
        time: args.time,
        cancel,
        ..Limits::default()
    };
    if !load(&mut app, &limits, scene, args.strict)? {
        return Ok(ExitCode::FAILURE);
    }
    let load_ms = milliseconds(begin.elapsed());
    apply_overrides(app.world_mut(), args)?;
    // Prepares the scene for the chosen camera. The render handles an interrupt.
    load_to_completion(&mut app, &limits)?;
    if !is_shown(&app, scene, args.strict) {
        return Ok(ExitCode::FAILURE);
    }
    let named = match args.output.is_empty() {
        true => vec![args.sequence.default_output(app.world(), scene)?],
        false => args.output.clone(),
    };
    outputs::check_scene_stays(args.checkpoints.checkpoint.as_deref())?;
    outputs::check_scene_stays(args.sequence.outputs(&named).flatten())?;
    check_compression(app.world(), file_options(app.world(), args).exr_compression, &named)?;
    if let Some(address) = &args.display_server {
        display_server::show(&mut app, address, scene);
    }
    let layers = app.world().resource::<PackedScene>().view.as_ref();
    let layers = layers.map(|view| view.film_layers().layers.without(Layers::of(&[Layer::Alpha])));
    if layers.is_some_and(|layers| !layers.is_empty()) {
        outputs::report_without_layers(&named);
    }
    if args.sequence.frames.is_some() {
        return frames(&mut app, args, &named, &limits);
    }
    let picture = Picture {
        args,
        outputs: &named,
        limits: &limits,
        load_ms,
        settings: settings(args, Settings::new()),
    };
    picture.render(&mut app, Progress::new(args.quiet, args.time))
}

/// Refuses impossible requests, before the scene is loaded.
fn check(args: &RenderArgs) -> Result<(), Failure> {
    let first_outputs = args.sequence.first_outputs(&args.output)?;
    outputs::check_pictures(&first_outputs)?;
    // The last frame has the longest file names.
    outputs::check_pictures(&args.sequence.last_outputs(&args.output))?;
    args.shares.check(&args.output)?;
    check_together(args)?;
    args.checkpoints.check(
        "picture",
        |path| has_file(&first_outputs, path),
        share::is_checkpoint_of_picture,
    )?;
    if !args.shares.is_given() {
        // An unfinished part may be overwritten by its finished one, which keeps its exact sums. A picture has none.
        let resumed = args.checkpoints.resume.as_slice();
        outputs::check_inputs_stay(&first_outputs, resumed, "what the picture goes on with").map_err(Failure::Usage)?;
    }
    check_denoiser(args.denoise, RENDERS_WITHOUT)
}

/// Renders the frames of an animation in turn.
fn frames(app: &mut App, args: &RenderArgs, named: &[PathBuf], limits: &Limits) -> Result<ExitCode, Failure> {
    let Some(frames) = args.sequence.frames.clone() else {
        return Ok(ExitCode::SUCCESS);
    };
    let mut sequence = InSequence::begin(&frames);
    let seed = app.world().resource::<SamplerSettings>().seed;
    // Later changes of the file do not affect the frames.
    app.world_mut().resource_mut::<SceneFile>().hold(true);
    let turning = args.sequence.turntable.and_then(|_| TurningCamera::of(app.world()));
    let mut code = ExitCode::SUCCESS;
    for frame in frames {
        let began = Instant::now();
        let samples = args.spp.or(limits.samples.filter(|_| args.shares.samples.is_none()));
        let samples = samples.unwrap_or_else(|| samples_of_film(app.world()));
        let moments = args.sequence.moments(app.world(), frame, samples);
        let layers = app.world().resource::<IntegratorSettings>().layers;
        let of_frame = args.sequence.settings(frame, &moments, layers.contains(Layer::Motion));
        let show = |world: &mut World, frame| args.sequence.show(world, frame, turning.as_ref());
        // The noise of every frame is independent.
        app.world_mut().resource_mut::<SamplerSettings>().seed = seed.wrapping_add(frame);
        if !open_shutter(app, moments, limits, show)? {
            break;
        }
        let outputs: Vec<PathBuf> = named.iter().map(|path| frame_path(path, frame)).collect();
        let picture = Picture {
            args,
            outputs: &outputs,
            limits,
            load_ms: milliseconds(began.elapsed()),
            settings: settings(args, of_frame),
        };
        let progress = Progress::new(args.quiet, args.time).within(sequence.clone());
        let this = picture.render(app, progress)?;
        if this != ExitCode::SUCCESS {
            code = this;
        }
        sequence.next();
        if limits.cancel.load(Ordering::Relaxed) {
            break;
        }
    }
    if sequence.is_broken_off() && code == ExitCode::SUCCESS {
        code = ExitCode::from(INTERRUPTED);
    }
    Ok(code)
}

/// Refuses conflicting options.
fn check_together(args: &RenderArgs) -> Result<(), Failure> {
    let frames = args.sequence.frames.as_ref().map_or(1, |frames| frames.clone().count());
    let message = if args.checkpoints.are_given() && frames > 1 {
        "a checkpoint is of one picture: --frames has to be a single frame"
    } else if args.checkpoints.are_given() && args.output.is_empty() {
        "a picture with a checkpoint needs a name, by `-o`: the same command has to go on with it"
    } else if args.stats == Some(StatsFormat::JsonLines) && args.output.iter().any(|path| outputs::is_stdout(path)) {
        "a picture and events cannot both go to standard output"
    } else if args.partial.is_some() && args.output.iter().any(|path| outputs::is_stdout(path)) {
        "--partial writes several pictures, and standard output has place for one"
    } else if let (Some(samples), Some(spp)) = (&args.shares.samples, args.spp)
        && samples.end > spp
    {
        "the range of --samples goes beyond --spp, the samples of the whole picture"
    } else {
        return Ok(());
    };
    Err(Failure::Usage(message.to_owned()))
}

/// The settings on which samples depend, apart from the scene and the view.
fn settings(args: &RenderArgs, of_frame: Settings) -> Settings {
    let accel = args.accel.name();
    let mut settings = vec![("the acceleration structure".to_owned(), accel.to_owned())];
    settings.extend(of_frame);
    let defines = args.scene.defines.defines.iter();
    settings.extend(defines.map(|(name, value)| (format!("-D {name}"), value.clone())));
    settings
}
