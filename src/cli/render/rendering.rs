//! Renders, watches, finishes, writes and reports one picture.

use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use bevy::prelude::*;
use sunroom::color::Rgb;
use sunroom::engine::{
    Limits, PackedScene, RenderControl, RenderFilm, RenderStatus, active_film, choose_integrator, layered_picture,
    load_to_completion, render_watched,
};
use sunroom::layer::Layer;
use sunroom::render::auto::{Method, pays_for_pilot};
use sunroom::render::denoise::denoise_film;
use sunroom::render::image_io::ImageRgb;
use sunroom::render::view::{Shown, View};

use super::args::RenderArgs;
use super::picture::Picture;
use super::watch::{Watch, event};
use crate::cli::ending::{Ending, above};
use crate::cli::progress::Progress;
use crate::cli::report::Failure;
use crate::cli::share::{self, Checkpoints, Share};
use crate::cli::stats::{Stats, StatsFormat, milliseconds};
use crate::cli::{display_server, outputs, report};

impl Picture<'_> {
    /// Renders the picture and writes it.
    pub fn render(self, app: &mut App, progress: Progress) -> Result<ExitCode, Failure> {
        let (args, limits) = (self.args, self.limits);
        let share = self.begin(app)?;
        let mut watch = Watch {
            picture: &self,
            progress,
            share: share.as_ref(),
            checkpoints: Checkpoints::new(&args.checkpoints),
            last_event: None,
            last_picture: Instant::now(),
        };
        let rendered = render_watched(app, limits, |world| watch.look(world));
        watch.progress.finish(app.world().resource::<RenderStatus>());
        let is_saved = rendered.is_ok() && watch.save(app.world());
        if let Some(code) = args.checkpoints.terminated(is_saved, "rendered") {
            return Ok(code);
        }
        let film = &app.world().resource::<RenderFilm>().film;
        let ending = Ending::new(rendered, share::pixel_counts(share.as_ref(), film))?;
        let threads = app.world().resource::<RenderControl>().threads.get();
        let denoise = || denoise_film(film, Some(threads), &AtomicBool::new(false));
        let denoising = Instant::now();
        let denoised = (args.denoise && ending.is_whole()).then(denoise);
        let is_denoised = matches!(denoised, Some(Ok(_)));
        let denoise_ms = if is_denoised {
            milliseconds(denoising.elapsed())
        } else {
            0.0
        };
        // If denoising fails, the noisy picture is written.
        let (pixels, denoise_failure) = match denoised {
            Some(Ok(pixels)) => (pixels, None),
            Some(Err(error)) => (film.radiance(), Some(error)),
            None => (film.radiance(), None),
        };
        let image = ImageRgb {
            width: film.width(),
            height: film.height(),
            pixels,
        };
        let has_layer = film.layers().layers.contains(Layer::Denoised) && ending.is_whole();
        let layer = match is_denoised {
            true => Some(image.pixels.clone()),
            false if has_layer => match denoise() {
                Ok(pixels) => Some(pixels),
                Err(error) => {
                    report::line(format_args!("warning: {error}; the layer `denoised` is missing"));
                    None
                }
            },
            false => None,
        };
        display_server::finish(app.world_mut(), &image.pixels);
        let world = app.world();
        let mut picture = layered_picture(world, &image, layer.as_deref());
        self.describe(&mut picture, world);
        let written = self.write(share.as_ref(), world, &picture, self.outputs);
        if written.is_empty() {
            outputs::keep_elsewhere(&picture);
        }
        let status = world.resource::<RenderStatus>();
        // A share of a picture counts samples of the whole picture.
        let samples = status.samples.saturating_sub(status.first);
        ending.report(samples, args.quiet, args.denoise, &written);
        if let Some(error) = &denoise_failure {
            report::error(format_args!("{error}; the picture is not denoised"));
        }
        self.report_limits(status, samples, &image.pixels, ending.is_broken_off());
        if let Some(format) = args.stats {
            let stats = Stats {
                scene: args.scene.scene.clone(),
                denoised: is_denoised,
                load_ms: self.load_ms,
                denoise_ms,
                outputs: self.outputs.to_vec(),
                ..Stats::of(world)
            };
            match format {
                StatsFormat::Text => outputs::print(format!("{}\n", stats.text()).as_bytes())?,
                StatsFormat::Json => {
                    outputs::print(format!("{}\n", serde_json::to_string_pretty(&stats)?).as_bytes())?;
                }
                StatsFormat::JsonLines => event(stats.event()?),
            }
        }
        Ok(match written.len() == self.outputs.len() && denoise_failure.is_none() {
            true => ending.exit_code(),
            false => ExitCode::FAILURE,
        })
    }

    /// Chooses the integrator, and resumes a checkpoint. Returns the share of the picture that is rendered; None for an
    /// ordinary picture.
    fn begin(&self, app: &mut App) -> Result<Option<Share>, Failure> {
        let (args, limits) = (self.args, self.limits);
        let samples = limits.samples.unwrap_or_else(|| samples_of_film(app.world()));
        let of_whole = samples_of_whole(args, limits, app.world());
        if !share::take_choice(app.world_mut(), &args.checkpoints)? {
            choose_integrator(app, Some(of_whole), limits)?;
        }
        // The choice is in the status.
        load_to_completion(app, limits)?;
        if !args.quiet {
            let view = app.world().resource::<PackedScene>().view.as_ref();
            report_missing_light(view);
            let pixels = view.map_or(0, |view| u64::from(view.width) * u64::from(view.height));
            report_choice(app.world().resource(), pixels * u64::from(of_whole));
        }
        share::begin(
            app.world_mut(),
            &args.scene.scene,
            &args.shares,
            &args.checkpoints,
            samples,
            of_whole,
            self.settings.clone(),
        )
    }

    /// Reports samples that are not finite, noise above its limit, and clamped light.
    fn report_limits(&self, status: &RenderStatus, samples: u32, pixels: &[Rgb], is_broken_off: bool) {
        if status.invalid_samples > 0 {
            let count = status.invalid_samples;
            report::line(format_args!(
                "warning: {count} samples were not finite and counted as black"
            ));
        }
        if self.args.quiet {
            return;
        }
        if let Some(limit) = status.missed_noise().filter(|_| !is_broken_off) {
            let noise = match status.noise {
                Some(noise) => format!("the noise is {}", above(noise, limit)),
                None if pixels.iter().all(|&pixel| pixel == Rgb::ZERO) => "the picture is all black".to_owned(),
                None => "the noise is not known of so few samples".to_owned(),
            };
            report::line(format_args!(
                "the limit of noise {limit} was not reached: {noise} at {samples} samples per pixel"
            ));
        }
        if let Some(limit) = status.clamped {
            let (limit, removed) = (limit.luminance, 100.0 * limit.removed);
            report::line(format_args!(
                "samples brighter than {limit:.3} were clamped, which removes about {removed:.2} % of the light"
            ));
        }
    }
}

/// The samples per pixel set by the active camera.
pub fn samples_of_film(world: &World) -> u32 {
    active_film(world).map_or(1, |film| film.sample_count)
}

/// The samples per pixel of the whole picture, for every share of it.
fn samples_of_whole(args: &RenderArgs, limits: &Limits, world: &World) -> u32 {
    let of_film = samples_of_film(world);
    match &args.shares.samples {
        // The number of samples in other shares beyond the film's is unknown.
        Some(share) => args.spp.unwrap_or(if share.end > of_film { u32::MAX } else { of_film }),
        None => limits.samples.unwrap_or(of_film),
    }
}

/// Reports the choice of `auto`.
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

/// Warns if layers keep light from the picture.
fn report_missing_light(view: Option<&View>) {
    if view.is_some_and(|view| {
        view.shown == Shown::Radiance && view.integrator.splats() && view.film_layers().parts_light()
    }) {
        report::line(format_args!(
            "warning: with layers that tell light apart, what paths from the lights bring to the lens is left out: caustics of points and spots are missing"
        ));
    }
}
