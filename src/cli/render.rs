//! `sunroom render`: from a scene file to image files.

mod args;
mod overrides;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use bevy::prelude::*;
use clap::ValueEnum;
use sunroom::app::headless::render_only;
use sunroom::app::interrupt::on_interrupt;
use sunroom::app::signals::{is_terminated, note_show, note_termination};
use sunroom::color::Rgb;
use sunroom::engine::{Limits, PackedScene, RenderControl, RenderFilm, RenderState, RenderStatus};
use sunroom::engine::{
    choose_integrator, describe_picture, layered_picture, load_to_completion, open_shutter, render_watched,
};
use sunroom::files::keep_reads;
use sunroom::layer::{Layer, Layers};
use sunroom::render::auto::{Method, pays_for_pilot};
use sunroom::render::denoise::{denoise_film, end_all};
use sunroom::render::image_io::{FileOptions, ImageRgb};
use sunroom::render::layered_image::LayeredImage;
use sunroom::render::view::{Shown, View};
use sunroom::scene::Film as SensorFilm;
use sunroom::scene::{
    AccelMethod, ActiveSensor, IntegratorSettings, KeepSource, OpenScene, SamplerSettings, SceneFile, SceneStatus,
};

pub use self::args::RenderArgs;
pub use self::overrides::apply_overrides;

use self::args::Accel;
use super::check::{report_left_out, report_refusal, report_scene};
use super::display_server;
use super::ending::{Ending, INTERRUPTED, TERMINATED, above};
use super::named_outputs::{check_compression, default_output};
use super::outputs::has_file;
use super::progress::{InSequence, Progress};
use super::report::{Failure, RENDERS_WITHOUT, check_denoiser};
use super::sequence::{TurningCamera, frame_path};
use super::share::{self, Settings};
use super::stats::{Auto, Bvh, Guide, Stats, StatsFormat, milliseconds, peak_memory_bytes};
use super::watch::{Last, Watch, event};
use super::{outputs, report};

pub fn run(args: RenderArgs) -> ExitCode {
    args.memory.apply();
    args.threads.report_limit();
    match render(&args) {
        Ok(code) => code,
        Err(failure) => failure.report(),
    }
}

type Error = Box<dyn std::error::Error>;

fn render(args: &RenderArgs) -> Result<ExitCode, Failure> {
    let first_outputs = args.sequence.first_outputs(&args.output)?;
    outputs::check_pictures(&first_outputs)?;
    // Its names are the longest.
    outputs::check_pictures(&args.sequence.last_outputs(&args.output))?;
    args.shares.check(&args.output)?;
    check_together(args)?;
    args.checkpoints.check(
        "picture",
        |path| has_file(&first_outputs, path),
        share::is_checkpoint_of_picture,
    )?;
    if !args.shares.is_given() {
        // A part that is not finished may be finished in its file, which has the exact sums then as before. A picture
        // has none.
        let resumed = args.checkpoints.resume.as_slice();
        outputs::check_inputs_stay(&first_outputs, resumed, "what the picture goes on with").map_err(Failure::Usage)?;
    }
    check_denoiser(args.denoise, RENDERS_WITHOUT)?;
    let trust = args.trust.trust(&args.scene.scene)?;
    let cancel = cancel_on_interrupt()?;
    note_show();
    if args.checkpoints.checkpoint.is_some() {
        note_termination(cancel.clone());
    }
    keep_reads();
    let begin = Instant::now();
    let mut app = render_only(
        OpenScene {
            path: args.scene.scene.clone(),
            defines: args.scene.defines.defines.clone(),
            ..OpenScene::default()
        },
        args.threads.threads,
    );
    // Other moments are read of the same text.
    app.world().resource::<KeepSource>().set(args.sequence.frames.is_some());
    app.insert_resource(trust);
    args.missing.apply(&mut app);
    app.insert_resource(match args.accel {
        Accel::Linear => AccelMethod::Linear,
        Accel::Median => AccelMethod::Median,
        Accel::Sah => AccelMethod::Sah,
    });
    let limits = Limits {
        // If only a limit of time or noise is given, the file's number of samples does not count.
        samples: args
            .shares
            .samples
            .as_ref()
            .map(|samples| samples.end)
            .or(args.spp)
            .or((args.time.is_some() || args.noise.is_some()).then_some(u32::MAX)),
        time: args.time,
        cancel: cancel.clone(),
        ..Limits::default()
    };
    let loaded = load_to_completion(&mut app, &limits);
    let status = app.world().resource::<SceneStatus>();
    if !report_scene(status, args.strict) {
        report_refusal(status, &args.scene.scene);
        return Ok(ExitCode::FAILURE);
    }
    if !loaded? {
        return Err("interrupted while the scene was being loaded: nothing is written".into());
    }
    let load_ms = milliseconds(begin.elapsed());
    apply_overrides(app.world_mut(), args)?;
    // Packs the scene as it is seen by the camera that was chosen. An interrupt is noticed by the render.
    load_to_completion(&mut app, &limits)?;
    let engine = app.world().resource::<RenderStatus>();
    if engine.state != RenderState::Failed && !report_left_out(engine, &args.scene.scene, args.strict) {
        if engine.shortages.is_empty() {
            report::refused_for_warnings(&args.scene.scene);
        }
        return Ok(ExitCode::FAILURE);
    }

    let named = match args.output.is_empty() {
        true => vec![default_output(app.world(), &args.scene.scene, &args.sequence)?],
        false => args.output.clone(),
    };
    outputs::check_scene_stays(args.checkpoints.checkpoint.as_deref())?;
    outputs::check_scene_stays(args.sequence.outputs(&named).flatten())?;
    let compression = file_options(app.world(), args).exr_compression;
    check_compression(app.world(), compression, &named)?;
    if let Some(address) = &args.display_server {
        display_server::show(&mut app, address, &args.scene.scene);
    }
    let layers = app.world().resource::<PackedScene>().view.as_ref();
    let layers = layers.map(|view| view.film_layers().layers.without(Layers::of(&[Layer::Alpha])));
    if layers.is_some_and(|layers| !layers.is_empty()) {
        outputs::report_without_layers(&named);
    }
    let Some(frames) = args.sequence.frames.clone() else {
        let progress = Progress::new(args.quiet, args.time);
        return picture(&mut app, args, &named, &limits, progress, load_ms, Settings::new());
    };
    let mut sequence = InSequence::begin(&frames);
    let seed = app.world().resource::<SamplerSettings>().seed;
    // The frames are of the file as it is now.
    app.world_mut().resource_mut::<SceneFile>().hold(true);
    let turning = args.sequence.turntable.and_then(|_| TurningCamera::of(app.world()));
    let mut code = ExitCode::SUCCESS;
    for frame in frames {
        let began = Instant::now();
        let samples = args.spp.or(limits.samples.filter(|_| args.shares.samples.is_none()));
        let samples = samples.unwrap_or_else(|| samples_of_film(app.world()));
        let moments = args.sequence.moments(app.world(), frame, samples);
        let has_motion = app
            .world()
            .resource::<IntegratorSettings>()
            .layers
            .contains(Layer::Motion);
        let of_frame = args.sequence.settings(frame, &moments, has_motion);
        let show = |world: &mut World, frame| args.sequence.show(world, frame, turning.as_ref());
        // Every frame has noise of its own.
        app.world_mut().resource_mut::<SamplerSettings>().seed = seed.wrapping_add(frame);
        if !open_shutter(&mut app, moments, &limits, show)? {
            break;
        }
        let outputs: Vec<PathBuf> = named.iter().map(|path| frame_path(path, frame)).collect();
        let progress = Progress::new(args.quiet, args.time).within(sequence.clone());
        let this = picture(
            &mut app,
            args,
            &outputs,
            &limits,
            progress,
            milliseconds(began.elapsed()),
            of_frame,
        )?;
        if this != ExitCode::SUCCESS {
            code = this;
        }
        sequence.next();
        if cancel.load(Ordering::Relaxed) {
            break;
        }
    }
    if sequence.is_broken_off() && code == ExitCode::SUCCESS {
        code = ExitCode::from(INTERRUPTED);
    }
    Ok(code)
}

/// The samples per pixel that the active camera asks for.
fn samples_of_film(world: &World) -> u32 {
    let sensor = world.resource::<ActiveSensor>().0;
    let film = sensor.and_then(|sensor| world.get::<SensorFilm>(sensor));
    film.map_or(1, |film| film.sample_count)
}

/// The samples per pixel of the whole picture, for every share of it.
fn samples_of_whole(args: &RenderArgs, limits: &Limits, world: &World) -> u32 {
    let of_film = samples_of_film(world);
    match &args.shares.samples {
        // How far other shares go beyond the film's number is not known.
        Some(share) => args.spp.unwrap_or(if share.end > of_film { u32::MAX } else { of_film }),
        None => limits.samples.unwrap_or(of_film),
    }
}

/// Says what `auto` has chosen.
fn report_choice(status: &RenderStatus, samples: u64) {
    let Some(auto) = status.auto else {
        return;
    };
    let (name, method) = (auto.integrator, auto.choice.method);
    let missed = 100.0 * auto.choice.missed;
    let why = match auto.choice.gain {
        Some(gain) if method == Method::GuidedPath => {
            let of_guide = auto.choice.gain_of_guide.unwrap_or(gain);
            format!(
                "for the same cost the variance of `path` is {of_guide:.2} times that of guided paths and {gain:.2} times that of `bdpt`, as a few paths tell"
            )
        }
        Some(_) if missed >= 1.0 => format!("`path` never finds {missed:.0} % of the light, as a few paths tell"),
        Some(gain) => {
            format!("the variance of `path` is {gain:.2} times that of `bdpt` for the same cost, as a few paths tell")
        }
        None if name == "volpath" => "it alone knows the media of the scene".to_owned(),
        None if method != Method::Path => "the picture was begun by it".to_owned(),
        None if !pays_for_pilot(samples) => {
            format!("with {samples} samples over all pixels there are too few to compare it with `bdpt`")
        }
        None => "there is nothing to compare it with, or the picture was begun by it".to_owned(),
    };
    report::line(format_args!("auto takes `{name}`: {why}"));
}

/// Warns where layers keep light from the picture.
fn report_missing_light(view: Option<&View>) {
    if view.is_some_and(|view| {
        view.shown == Shown::Radiance && view.integrator.splats() && view.film_layers().parts_light()
    }) {
        report::line(format_args!(
            "warning: with layers that tell light apart, what paths from the lights bring to the lens is left out: caustics of points and spots are missing"
        ));
    }
}

/// Renders the scene as it is and writes the picture.
fn picture(
    app: &mut App,
    args: &RenderArgs,
    outputs: &[PathBuf],
    limits: &Limits,
    progress: Progress,
    load_ms: f64,
    of_frame: Settings,
) -> Result<ExitCode, Failure> {
    let samples = limits.samples.unwrap_or_else(|| samples_of_film(app.world()));
    let of_whole = samples_of_whole(args, limits, app.world());
    let settings = settings(args, of_frame);
    let (scene, checkpoints) = (&args.scene.scene, &args.checkpoints);
    if !share::take_choice(app.world_mut(), checkpoints)? {
        choose_integrator(app, Some(of_whole), limits)?;
    }
    // The status tells of the choice.
    load_to_completion(app, limits)?;
    if !args.quiet {
        let view = app.world().resource::<PackedScene>().view.as_ref();
        report_missing_light(view);
        let pixels = view.map_or(0, |view| u64::from(view.width) * u64::from(view.height));
        report_choice(app.world().resource(), pixels * u64::from(of_whole));
    }
    let share = share::begin(
        app.world_mut(),
        scene,
        &args.shares,
        checkpoints,
        samples,
        of_whole,
        settings,
    )?;
    // Standard output has place for one picture, the finished one.
    let files: Vec<PathBuf> = outputs
        .iter()
        .filter(|path| !outputs::is_stdout(path))
        .cloned()
        .collect();
    let write = |world: &World, picture: &LayeredImage, places| {
        let options = file_options(world, args);
        match share.as_ref().filter(|share| share.is_part) {
            Some(share) => {
                let part = share.piece.cut(picture.clone());
                outputs::write_each(places, |path| share.piece.write(world, path, &part, &options))
            }
            None => outputs::write_each(places, |path| outputs::write_picture(path, picture, &options)),
        }
    };
    let mut watch = Watch {
        progress,
        share: share.as_ref(),
        checkpoint: checkpoints.checkpoint.as_deref().map(|path| (path, checkpoints.every)),
        partial: args.partial,
        has_events: args.stats == Some(StatsFormat::JsonLines),
        describe: &|picture, world| describe(picture, world, args),
        write: &|world, picture| write(world, picture, &files).len() == files.len(),
        last: Last::default(),
    };
    let rendered = render_watched(app, limits, |world| watch.look(world));
    watch.progress.finish(app.world().resource::<RenderStatus>());
    let is_saved = rendered.is_ok() && watch.save(app.world());
    if is_terminated() && is_saved {
        let path = checkpoints.checkpoint.as_deref().unwrap_or(Path::new(""));
        report::line(format_args!("terminated; {} has what was rendered", path.display()));
        return Ok(ExitCode::from(TERMINATED));
    }

    let film = &app.world().resource::<RenderFilm>().film;
    let ending = Ending::new(rendered, share::pixel_counts(share.as_ref(), film))?;
    let threads = app.world().resource::<RenderControl>().threads.get();
    let denoising = Instant::now();
    let denoised = match args.denoise && ending.is_whole() {
        true => Some(denoise_film(film, Some(threads), &AtomicBool::new(false)).map_err(Error::from)),
        false => None,
    };
    let (pixels, denoise_ms, denoise_failure) = match denoised {
        Some(Ok(pixels)) => (pixels, milliseconds(denoising.elapsed()), None),
        // The noisy picture is better than none.
        Some(Err(error)) => (film.radiance(), 0.0, Some(error)),
        None => (film.radiance(), 0.0, None),
    };
    let is_denoised = args.denoise && ending.is_whole() && denoise_failure.is_none();
    let image = ImageRgb {
        width: film.width(),
        height: film.height(),
        pixels,
    };
    display_server::finish(app.world_mut(), &image.pixels);
    let status = app.world().resource::<RenderStatus>();
    let film = &app.world().resource::<RenderFilm>().film;
    let chosen = film.layers().layers;
    let denoised_layer = match (is_denoised, chosen.contains(Layer::Denoised) && ending.is_whole()) {
        (true, _) => Some(image.pixels.clone()),
        (false, true) => match denoise_film(film, Some(threads), &AtomicBool::new(false)) {
            Ok(pixels) => Some(pixels),
            Err(error) => {
                report::line(format_args!("warning: {error}; the layer `denoised` is missing"));
                None
            }
        },
        (false, false) => None,
    };
    let mut picture = layered_picture(app.world(), &image, denoised_layer.as_deref());
    describe(&mut picture, app.world(), args);
    let written = write(app.world(), &picture, outputs);
    if written.is_empty() {
        outputs::keep_elsewhere(&picture);
    }

    // A share counts the samples of the whole picture.
    let samples = status.samples.saturating_sub(status.first);
    ending.report(samples, args.quiet, args.denoise, &written);
    if let Some(error) = &denoise_failure {
        report::error(format_args!("{error}; the picture is not denoised"));
    }
    if status.invalid_samples > 0 {
        let count = status.invalid_samples;
        report::line(format_args!(
            "warning: {count} samples were not finite and counted as black"
        ));
    }
    if let (Some(limit), false) = (status.missed_noise(), args.quiet || ending.is_broken_off()) {
        let noise = match status.noise {
            Some(noise) => format!("the noise is {}", above(noise, limit)),
            None if image.pixels.iter().all(|&pixel| pixel == Rgb::ZERO) => "the picture is all black".to_owned(),
            None => "the noise is not known of so few samples".to_owned(),
        };
        report::line(format_args!(
            "the limit of noise {limit} was not reached: {noise} at {samples} samples per pixel"
        ));
    }
    if let Some(limit) = status.clamped.filter(|_| !args.quiet) {
        let (limit, removed) = (limit.luminance, 100.0 * limit.removed);
        report::line(format_args!(
            "samples brighter than {limit:.3} were clamped, which removes about {removed:.2} % of the light"
        ));
    }
    if let Some(format) = args.stats {
        let stats = Stats {
            scene: args.scene.scene.clone(),
            width: image.width,
            height: image.height,
            spp: samples,
            noise: status.noise,
            auto: status.auto.map(Auto::from),
            seed: app.world().resource::<SamplerSettings>().seed,
            threads,
            denoised: is_denoised,
            triangles: status.triangles,
            load_ms,
            bvh: Bvh::of(status),
            render_ms: status.seconds * 1e3,
            denoise_ms,
            rays: status.rays,
            guide: status.guide.map(Guide::from),
            mrays_per_s: status.mrays_per_s,
            msamples_per_s: status.msamples_per_s,
            invalid_samples: status.invalid_samples,
            clamped_light: status.clamped.map(|limit| limit.removed),
            peak_memory_bytes: peak_memory_bytes(),
            outputs: outputs.to_vec(),
        };
        match format {
            StatsFormat::Text => outputs::print(format!("{}\n", stats.text()).as_bytes())?,
            StatsFormat::Json => outputs::print(format!("{}\n", serde_json::to_string_pretty(&stats)?).as_bytes())?,
            StatsFormat::JsonLines => event(stats.event()?),
        }
    }
    let all_written = written.len() == outputs.len();
    Ok(match all_written && denoise_failure.is_none() {
        true => ending.exit_code(),
        false => ExitCode::FAILURE,
    })
}

/// Refuses options that do not go together.
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

/// What samples depend on beside the scene and the view.
fn settings(args: &RenderArgs, of_frame: Settings) -> Settings {
    let accel = args
        .accel
        .to_possible_value()
        .map_or_else(String::new, |value| value.get_name().to_owned());
    let mut settings = vec![("the acceleration structure".to_owned(), accel)];
    settings.extend(of_frame);
    let defines = args.scene.defines.defines.iter();
    settings.extend(defines.map(|(name, value)| (format!("-D {name}"), value.clone())));
    settings
}

/// How the outputs are stored.
fn file_options(world: &World, args: &RenderArgs) -> FileOptions {
    let sensor = world.resource::<ActiveSensor>().0;
    let film = sensor.and_then(|sensor| world.get::<SensorFilm>(sensor));
    let storage = film.map(|film| film.storage).unwrap_or_default();
    args.file.options(args.display.display(), storage)
}

/// Says in the picture where it comes from.
fn describe(picture: &mut LayeredImage, world: &World, args: &RenderArgs) {
    let seconds = args.time.map(|_| world.resource::<RenderStatus>().seconds);
    describe_picture(picture, world, Some(&args.scene.scene), seconds);
}

/// The first interrupt asks for an orderly end, the second one ends the process.
pub fn cancel_on_interrupt() -> Result<Arc<AtomicBool>, Error> {
    let cancel = Arc::new(AtomicBool::new(false));
    let flag = cancel.clone();
    on_interrupt(move || {
        if flag.swap(true, Ordering::Relaxed) {
            end_all();
            std::process::exit(i32::from(INTERRUPTED));
        }
    })?;
    Ok(cancel)
}
