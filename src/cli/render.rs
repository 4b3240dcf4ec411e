//! `sunroom render`: from a scene file to image files.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use bevy::prelude::*;
use clap::{Args, ValueEnum};
use sunroom::app::headless::render_only;
use sunroom::app::interrupt::on_interrupt;
use sunroom::engine::{Limits, RenderControl, RenderFilm, RenderState, RenderStatus};
use sunroom::engine::{layered_picture, load_to_completion, open_shutter, render_to_completion};
use sunroom::layer::{Layer, Layers, layer_names};
use sunroom::render::denoise::{DenoiseError, denoise_film};
use sunroom::render::image_io::ImageRgb;
use sunroom::render::layered_image::{Attribute, LayeredImage};
use sunroom::scene::{
    AccelMethod, ActiveSensor, Crop, IntegratorSettings, KeepSource, OpenScene, SamplerSettings, SceneFile,
    SceneStatus, Sequence, find_camera,
};
use sunroom::scene::{Film as SensorFilm, Strategy};

use super::args::{MemoryArgs, SceneArgs, ThreadArgs, TrustArgs};
use super::check::{has_only_warnings, report_left_out, report_scene};
use super::display_server;
use super::ending::{Ending, INTERRUPTED};
use super::picture_args::{DisplayArgs, FileArgs};
use super::progress::{InSequence, Progress};
use super::report::Failure;
use super::sequence::{SequenceArgs, TurningCamera, frame_path};
use super::stats::{Bvh, Stats, StatsFormat, milliseconds, peak_memory_bytes};
use super::{outputs, parse, report};

#[derive(Args)]
pub struct RenderArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Image file: .exr, .hdr or .pfm (linear), .png or .jpg (sRGB); `-` is PNG on standard output; may be given several times
    #[arg(short, long, required = true, value_name = "OUT")]
    output: Vec<PathBuf>,
    /// Camera to render with, by its id or its index from 0 on [default: the first]
    #[arg(long, value_name = "NAME|INDEX")]
    camera: Option<String>,
    /// Samples per pixel [default: the scene's, or as many as --time and --noise allow]
    #[arg(short, long, value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Stop after this time, such as 500ms, 60s, 5m; a bare number is seconds
    #[arg(long, value_name = "TIME", value_parser = parse::duration)]
    time: Option<Duration>,
    /// Stop at this noise, such as 0.01 or 1%: the root mean square error of pixels relative to their luminance, as estimated
    #[arg(long, value_name = "NOISE", value_parser = parse::noise)]
    noise: Option<f32>,
    /// Send more samples where the noise is
    #[arg(long)]
    adaptive: bool,
    /// Both sides of the picture in pixels
    #[arg(long, value_name = "WxH", value_parser = parse::picture_size, conflicts_with_all = ["width", "height"])]
    size: Option<(u32, u32)>,
    /// Width of the picture in pixels; the other side follows if it is not given
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=65536))]
    width: Option<u32>,
    /// Height in pixels
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=65536))]
    height: Option<u32>,
    #[command(flatten)]
    sequence: SequenceArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    trust: TrustArgs,
    /// Seed of the random numbers; the same seed gives the same picture on any number of threads
    #[arg(long)]
    seed: Option<u32>,
    /// Longest path in segments, -1 for any [default: the scene's]
    #[arg(long, allow_negative_numbers = true, value_parser = clap::value_parser!(i32).range(-1..))]
    max_depth: Option<i32>,
    /// Remove the noise with Open Image Denoise
    #[arg(long)]
    denoise: bool,
    #[arg(long, value_name = "NAME[,NAME...]", value_parser = parse::layers, help = layers_help())]
    aov: Vec<Layers>,
    /// Acceleration structure
    #[arg(long, value_enum, default_value_t = Accel::Sah)]
    accel: Accel,
    /// How light is looked for
    #[arg(long, value_enum)]
    strategy: Option<StrategyName>,
    /// Reflect on glass by Schlick's approximation instead of the exact Fresnel equations
    #[arg(long)]
    schlick: bool,
    /// Random numbers: well spread points whatever the file's sampler is called, or truly independent ones [default: sobol]
    #[arg(long, value_enum)]
    sampler: Option<SamplerName>,
    #[command(flatten)]
    display: DisplayArgs,
    #[command(flatten)]
    file: FileArgs,
    /// Show the picture in tev while it is rendered, at this address (tev listens to localhost:14158)
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "frames")]
    display_server: Option<String>,
    /// Print the figures of the render on standard output
    #[arg(long, value_enum, value_name = "FORMAT", num_args = 0..=1, require_equals = true, default_missing_value = "text")]
    stats: Option<StatsFormat>,
    /// Treat warnings about the scene as errors
    #[arg(long)]
    strict: bool,
    /// No progress
    #[arg(short, long)]
    quiet: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Accel {
    Linear,
    Median,
    Sah,
}

#[derive(Clone, Copy, ValueEnum)]
enum StrategyName {
    Bsdf,
    Light,
    Mis,
}

#[derive(Clone, Copy, ValueEnum)]
enum SamplerName {
    Sobol,
    Independent,
}

/// The text of `--help` about `--aov`.
fn layers_help() -> String {
    let names = layer_names().join(", ");
    format!("Save layers with the picture in EXR files, besides those of the scene: {names}")
}

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
    if args.denoise && !cfg!(feature = "denoise") {
        return Err(DenoiseError::NotBuilt.into());
    }
    let trust = args.trust.trust(&args.scene.scene)?;
    let cancel = cancel_on_interrupt()?;
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
    app.insert_resource(match args.accel {
        Accel::Linear => AccelMethod::Linear,
        Accel::Median => AccelMethod::Median,
        Accel::Sah => AccelMethod::Sah,
    });
    let limits = Limits {
        // If only a limit of time or noise is given, the file's number of samples does not count.
        samples: args
            .spp
            .or((args.time.is_some() || args.noise.is_some()).then_some(u32::MAX)),
        time: args.time,
        cancel: cancel.clone(),
        ..Limits::default()
    };
    let loaded = load_to_completion(&mut app, &limits);
    let status = app.world().resource::<SceneStatus>();
    if !report_scene(status, args.strict) {
        if has_only_warnings(status) {
            report::refused_for_warnings(&args.scene.scene);
        }
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

    check_compression(app.world(), args)?;
    if let Some(address) = &args.display_server {
        display_server::show(&mut app, address, &args.scene.scene);
    }
    let Some(frames) = args.sequence.frames.clone() else {
        let progress = Progress::new(args.quiet, args.time);
        return picture(&mut app, args, &args.output, &limits, progress, load_ms);
    };
    let mut sequence = InSequence::begin(&frames);
    let seed = app.world().resource::<SamplerSettings>().seed;
    // The frames are of the file as it is now.
    app.world_mut().resource_mut::<SceneFile>().hold(true);
    let turning = args.sequence.turntable.and_then(|_| TurningCamera::of(app.world()));
    let mut code = ExitCode::SUCCESS;
    for frame in frames {
        let began = Instant::now();
        let samples = limits.samples.unwrap_or_else(|| samples_of_film(app.world()));
        let moments = args.sequence.moments(app.world(), frame, samples);
        let show = |world: &mut World, frame| args.sequence.show(world, frame, turning.as_ref());
        // Every frame has noise of its own.
        app.world_mut().resource_mut::<SamplerSettings>().seed = seed.wrapping_add(frame);
        if !open_shutter(&mut app, moments, &limits, show)? {
            break;
        }
        let outputs: Vec<PathBuf> = args.output.iter().map(|path| frame_path(path, frame)).collect();
        let progress = Progress::new(args.quiet, args.time).within(sequence.clone());
        let this = picture(
            &mut app,
            args,
            &outputs,
            &limits,
            progress,
            milliseconds(began.elapsed()),
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

/// An error if the compression would damage a layer, before anything is rendered.
fn check_compression(world: &World, args: &RenderArgs) -> Result<(), Failure> {
    let compression = args.file.compression();
    let layers = world.resource::<IntegratorSettings>().layers;
    let mut mattes = [Layer::CryptoObject, Layer::CryptoMaterial].into_iter();
    let Some(matte) = mattes.find(|&layer| layers.contains(layer)) else {
        return Ok(());
    };
    if compression.keeps_floats() || !outputs::has_exr(&args.output) {
        return Ok(());
    }
    let (layer, compression) = (matte.name(), compression.name());
    Err(Failure::Usage(format!(
        "the layer `{layer}` would be damaged by the compression `{compression}`: choose one without loss, such as `zip`"
    )))
}

/// The samples per pixel that the active camera asks for.
fn samples_of_film(world: &World) -> u32 {
    let sensor = world.resource::<ActiveSensor>().0;
    let film = sensor.and_then(|sensor| world.get::<SensorFilm>(sensor));
    film.map_or(1, |film| film.sample_count)
}

/// Renders the scene as it is and writes the picture.
fn picture(
    app: &mut App,
    args: &RenderArgs,
    outputs: &[PathBuf],
    limits: &Limits,
    mut progress: Progress,
    load_ms: f64,
) -> Result<ExitCode, Failure> {
    let rendered = render_to_completion(app, limits, |status| progress.update(status));
    progress.finish(app.world().resource::<RenderStatus>());

    let film = &app.world().resource::<RenderFilm>().film;
    let ending = Ending::new(rendered, film)?;
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
    if !chosen.without(Layers::of(&[Layer::Alpha])).is_empty() {
        outputs::report_without_layers(outputs);
    }
    let mut picture = layered_picture(app.world(), &image, denoised_layer.as_deref());
    describe(&mut picture, app.world(), args);
    let sensor = app.world().resource::<ActiveSensor>().0;
    let storage = sensor.and_then(|sensor| app.world().get::<SensorFilm>(sensor));
    let storage = storage.map(|film| film.storage).unwrap_or_default();
    let options = args.file.options(args.display.display(), storage);
    let written = outputs::write_pictures(outputs, &picture, &options);

    ending.report(status.samples, args.quiet, args.denoise, &written);
    if let Some(error) = &denoise_failure {
        report::error(format_args!("{error}; the picture is not denoised"));
    }
    if status.invalid_samples > 0 {
        let count = status.invalid_samples;
        report::line(format_args!(
            "warning: {count} samples were not finite and counted as black"
        ));
    }
    if let Some(format) = args.stats {
        let stats = Stats {
            scene: args.scene.scene.clone(),
            width: image.width,
            height: image.height,
            spp: status.samples,
            noise: status.noise,
            seed: app.world().resource::<SamplerSettings>().seed,
            threads,
            denoised: is_denoised,
            triangles: status.triangles,
            load_ms,
            bvh: Bvh::of(status),
            render_ms: status.seconds * 1e3,
            denoise_ms,
            rays: status.rays,
            mrays_per_s: status.mrays_per_s,
            msamples_per_s: status.msamples_per_s,
            invalid_samples: status.invalid_samples,
            peak_memory_bytes: peak_memory_bytes(),
            outputs: outputs.to_vec(),
        };
        let text = match format {
            StatsFormat::Text => stats.text(),
            StatsFormat::Json => serde_json::to_string_pretty(&stats)?,
        };
        outputs::print(format!("{text}\n").as_bytes())?;
    }
    let all_written = written.len() == outputs.len();
    Ok(match all_written && denoise_failure.is_none() {
        true => ending.exit_code(),
        false => ExitCode::FAILURE,
    })
}

/// Says in the picture where it comes from. Times are named only where the picture depends on them, so that the same render gives the same file.
fn describe(picture: &mut LayeredImage, world: &World, args: &RenderArgs) {
    let status = world.resource::<RenderStatus>();
    let mut text = |name: &str, value: String| picture.set_attribute(name, Attribute::Text(value));
    text("software", concat!("Sunroom ", env!("CARGO_PKG_VERSION")).to_owned());
    text("sunroom:scene", args.scene.scene.display().to_string());
    let camera = world.resource::<ActiveSensor>().0;
    if let Some(name) = camera.and_then(|camera| world.get::<Name>(camera)) {
        text("sunroom:camera", name.as_str().to_owned());
    }
    let mut int = |name: &str, value: u32| {
        picture.set_attribute(name, Attribute::Int(i32::try_from(value).unwrap_or(i32::MAX)));
    };
    int("sunroom:spp", status.samples);
    int("sunroom:seed", world.resource::<SamplerSettings>().seed);
    if args.time.is_some() {
        picture.set_attribute("sunroom:seconds", Attribute::Float(status.seconds as f32));
    }
}

/// The first interrupt asks for an orderly end, the second one ends the process.
fn cancel_on_interrupt() -> Result<Arc<AtomicBool>, Error> {
    let cancel = Arc::new(AtomicBool::new(false));
    let flag = cancel.clone();
    on_interrupt(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    })?;
    Ok(cancel)
}

/// Applies the options of the command line, which override the file.
fn apply_overrides(world: &mut World, args: &RenderArgs) -> Result<(), Failure> {
    let mut integrator = world.resource_mut::<IntegratorSettings>();
    if let Some(depth) = args.max_depth {
        integrator.max_depth = u32::try_from(depth).ok();
    }
    integrator.schlick |= args.schlick;
    integrator.layers = args.aov.iter().fold(integrator.layers, |all, layers| all.and(*layers));
    match args.strategy {
        Some(StrategyName::Bsdf) => integrator.strategy = Strategy::Bsdf,
        Some(StrategyName::Light) => integrator.strategy = Strategy::Light,
        Some(StrategyName::Mis) => integrator.strategy = Strategy::Mis,
        None => {}
    }
    let mut sampler = world.resource_mut::<SamplerSettings>();
    if let Some(seed) = args.seed {
        sampler.seed = seed;
    }
    match args.sampler {
        Some(SamplerName::Sobol) => sampler.sequence = Sequence::Sobol,
        Some(SamplerName::Independent) => sampler.sequence = Sequence::Independent,
        None => {}
    }
    if args.adaptive {
        world.resource_mut::<RenderControl>().adaptive = Some(true);
    }
    if args.noise.is_some() {
        world.resource_mut::<RenderControl>().noise_target = args.noise;
    } else if args.spp.is_some() || args.time.is_some() {
        // What is asked for takes the place of both limits of the file.
        world.resource_mut::<RenderControl>().noise_target = Some(0.0);
    }
    if let Some(camera) = &args.camera {
        let camera = find_camera(world, camera).map_err(|error| Failure::Usage(error.to_string()))?;
        world.insert_resource(ActiveSensor(Some(camera)));
    }
    let window = world
        .resource::<ActiveSensor>()
        .0
        .and_then(|sensor| world.get::<SensorFilm>(sensor))
        .map(SensorFilm::window);
    let sides = match args.size {
        Some((width, height)) => [Some(width), Some(height)],
        None => [args.width, args.height],
    };
    if let Some(Crop { width, height, .. }) = window
        && sides != [None; 2]
    {
        let scaled = |side: u32, to: u32, from: u32| (f64::from(side) * f64::from(to) / f64::from(from)).round() as u32;
        let size = UVec2::new(
            sides[0]
                .or_else(|| Some(scaled(width, sides[1]?, height)))
                .unwrap_or(width)
                .max(1),
            sides[1]
                .or_else(|| Some(scaled(height, sides[0]?, width)))
                .unwrap_or(height)
                .max(1),
        );
        if !SensorFilm::is_possible(size.x, size.y) {
            let most = SensorFilm::MOST_PIXELS;
            return Err(Failure::Usage(format!(
                "a film of {} x {} pixels is too large: at most {most} are possible",
                size.x, size.y
            )));
        }
        world.resource_mut::<RenderControl>().film_size_override = Some(size);
    }
    Ok(())
}
