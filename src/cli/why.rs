//! `sunroom why`: where the light of a place in the picture comes from, and where the light of a lamp goes.

mod lamp;
mod report;

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bevy::prelude::*;
use clap::Args;
use sunroom::app::interrupt::on_interrupt;
use sunroom::app::threads::worker_count;
use sunroom::engine::reasons::Things;
use sunroom::engine::{Limits, PackedScene, load_to_completion};
use sunroom::render::breakdown::{Area, Batches, LEAST_SAMPLES, break_down};
use sunroom::render::part::Crop;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::View;

use super::args::{MemoryArgs, MissingArgs, SceneArgs, ThreadArgs, TrustArgs};
use super::check::{is_shown, load, open};
use super::ending::INTERRUPTED;
use super::render::{choose_camera, set_size};
use super::report::Failure;
use super::{outputs, parse};

#[derive(Args)]
pub struct WhyArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    subject: Subject,
    /// Samples per pixel; with --lamp paths from the lamp [default: 65536 in all, at least 64 per pixel; 262144 paths]
    #[arg(short, long, value_parser = clap::value_parser!(u32).range(i64::from(LEAST_SAMPLES)..))]
    spp: Option<u32>,
    /// Camera of the picture, by its id or its index from 0 on [default: the first]
    #[arg(long, value_name = "NAME|INDEX")]
    camera: Option<String>,
    /// Both sides of the picture in pixels
    #[arg(long, value_name = "WxH", value_parser = parse::picture_size, conflicts_with_all = ["width", "height"])]
    size: Option<(u32, u32)>,
    /// Width of the picture in pixels; the other side follows if it is not given
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=65536))]
    width: Option<u32>,
    /// Height in pixels
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=65536))]
    height: Option<u32>,
    /// Seed of the random numbers; the same seed gives the same figures on any number of threads
    #[arg(long)]
    seed: Option<u32>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    memory: MemoryArgs,
    #[command(flatten)]
    trust: TrustArgs,
    #[command(flatten)]
    missing: MissingArgs,
    /// Treat warnings about the scene as errors
    #[arg(long)]
    strict: bool,
}

/// The subject of the question: a pixel, a rectangle of pixels, or a lamp.
#[derive(Args)]
#[group(required = true, multiple = false)]
struct Subject {
    /// Pixel of the picture, (0, 0) at the upper left
    #[arg(long, value_name = "X,Y", value_parser = parse::pixel)]
    at: Option<UVec2>,
    /// Rectangle of pixels
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse::crop)]
    region: Option<Crop>,
    /// Lamp whose light is followed, by its id or name
    #[arg(long, value_name = "NAME")]
    lamp: Option<String>,
}

/// The samples of all pixels by default, and the least samples of a pixel.
const SAMPLES: u64 = 1 << 16;
const SAMPLES_OF_PIXEL: u64 = 64;

pub fn run(args: &WhyArgs) -> Result<ExitCode, Failure> {
    args.memory.apply();
    args.threads.report_limit();
    let scene = &args.scene.scene;
    let trust = args.trust.trust(scene)?;
    let cancel = cancelled_by_interrupt()?;
    let limits = Limits {
        cancel: cancel.clone(),
        ..Limits::default()
    };
    let mut app = open(scene, &args.scene.defines, trust, &args.missing, args.threads.threads);
    if !load(&mut app, &limits, scene, args.strict)? {
        return Ok(ExitCode::FAILURE);
    }
    choose_camera(app.world_mut(), args.camera.as_deref())?;
    set_size(app.world_mut(), args.size, [args.width, args.height])?;
    // Prepares the scene for the chosen camera.
    load_to_completion(&mut app, &limits)?;
    if !is_shown(&app, scene, args.strict) {
        return Ok(ExitCode::FAILURE);
    }
    let packed = app.world().resource::<PackedScene>();
    let (Some(kernel), Some(mut view)) = (packed.scene.clone(), packed.view.clone()) else {
        return Err(format!("{}: there is nothing to see", scene.display()).into());
    };
    view.seed = args.seed.unwrap_or(view.seed);
    let subject = Question {
        args,
        world: app.world(),
        things: Things::of(packed),
        scene: kernel,
        view,
        cancel: &cancel,
    };
    let threads = worker_count(args.threads.threads, false).get();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let text = match &args.subject.lamp {
        Some(name) => subject.lamp(name, &pool)?,
        None => subject.area(&pool)?,
    };
    match text {
        Some(text) => outputs::print(text.as_bytes())?,
        None => return Ok(ExitCode::from(INTERRUPTED)),
    }
    Ok(ExitCode::SUCCESS)
}

/// A flag that an interrupt sets; a second interrupt ends the process.
fn cancelled_by_interrupt() -> Result<Arc<AtomicBool>, Failure> {
    let cancel = Arc::new(AtomicBool::new(false));
    let flag = cancel.clone();
    on_interrupt(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(i32::from(INTERRUPTED));
        }
    })?;
    Ok(cancel)
}

/// A loaded scene and what is asked about it.
struct Question<'a> {
    args: &'a WhyArgs,
    world: &'a World,
    things: Things,
    scene: RenderScene,
    view: View,
    cancel: &'a AtomicBool,
}

impl Question<'_> {
    /// The report on the light of an area; None if interrupted.
    fn area(&self, pool: &rayon::ThreadPool) -> Result<Option<String>, Failure> {
        let area = match (self.args.subject.at, self.args.subject.region) {
            (Some(pixel), _) => Area::pixel(pixel),
            (None, Some(Crop { x, y, width, height })) => Area { x, y, width, height },
            (None, None) => return Err(Failure::Usage("expected --at, --region or --lamp".to_owned())),
        };
        let View { width, height, .. } = self.view;
        if !area.is_within(width, height) {
            return Err(Failure::Usage(format!(
                "the place is outside of the picture, which has {width} x {height} pixels"
            )));
        }
        let usual = (SAMPLES / area.pixels()).clamp(SAMPLES_OF_PIXEL, SAMPLES) as u32;
        let batches = Batches::of(self.args.spp.unwrap_or(usual));
        let found = pool.install(|| break_down(&self.scene, &self.view, area, batches, self.cancel));
        let Some(breakdown) = found else {
            return Ok(None);
        };
        let report = report::Report::new(self, &breakdown);
        Ok(Some(match self.args.json {
            true => format!("{}\n", serde_json::to_string_pretty(&report)?),
            false => report.text(),
        }))
    }
}
