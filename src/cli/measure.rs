//! `sunroom measure`: illuminance at the measuring points and grids of a scene.

mod args;
mod page;
mod results;

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use bevy::prelude::{App, Without};
use sunroom::app::metering::{MeterParts, Upward, asked_meters, under_overcast_sky, upward};
use sunroom::app::threads::worker_count;
use sunroom::bake::progress::about_invalid;
use sunroom::engine::{Limits, PackedScene, load_to_completion};
use sunroom::files::{keep_reads, write_atomically};
use sunroom::meter::glare::{Glare, glare};
use sunroom::meter::job::{MeterEnd, MeterEnding, MeterJob, finds_no_light};
use sunroom::meter::sites::MeterLimits;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::View;
use sunroom::scene::{ActiveSensor, Hidden, find_camera};

pub use self::args::MeasureArgs;

use self::results::Results;

use super::check::{is_shown, load, open};
use super::ending::{INTERRUPTED, cancel_on_interrupt};
use super::outputs::{self, check_scene_stays, check_text, is_stdout};
use super::progress::{Progress, Shown};
use super::report::{self, Failure};

/// The exit code if a limit of a meter is not met.
pub const LIMIT_NOT_MET: u8 = 3;

pub fn run(args: &MeasureArgs) -> Result<ExitCode, Failure> {
    args.memory.apply();
    args.threads.report_limit();
    let files = || args.csv.iter().filter(|path| !is_stdout(path)).chain(&args.html);
    files().try_for_each(|path| check_text(path))?;
    keep_reads();
    let cancel = cancel_on_interrupt()?;
    let Some(app) = loaded(args, &cancel)? else {
        return Ok(ExitCode::FAILURE);
    };
    check_scene_stays(files())?;
    let Prepared { mut job, seen, up } = prepared(args, app)?;
    let threads = worker_count(args.threads.threads, false).get();
    let pool = Arc::new(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?);
    let (ending, seconds) = measured(args, &mut job, &pool, &cancel);
    let Some(readings) = job.readings() else {
        return Err("interrupted before the first samples: there are no values".into());
    };
    let glare = match seen.filter(|_| ending != MeterEnding::Cancelled) {
        Some((scene, view)) => rated(&scene, &view, &pool, &cancel)?,
        None => None,
    };
    for reading in readings.iter().filter(|reading| reading.is_buried) {
        let name = &reading.name;
        report::line(format_args!(
            "warning: {name}: it lies inside of something, or on the side that light does not reach; it measures along its +z"
        ));
    }
    if let Some(about) = about_invalid(job.invalid_samples()) {
        report::line(format_args!("warning: {about}"));
    }
    let results = Results {
        readings,
        glare,
        up,
        noise: args.end().noise,
        seconds,
        ending,
    };
    let text = match args.json {
        true => format!("{}\n", serde_json::to_string_pretty(&results.json())?),
        false => results.text(),
    };
    if let Some(path) = &args.html {
        let scene = args.scene.scene.display().to_string();
        write(path, page::page(&scene, &results))?;
    }
    match &args.csv {
        Some(path) if is_stdout(path) => {
            report::line(text.trim_end());
            outputs::print(results.csv().as_bytes())?;
        }
        Some(path) => {
            outputs::print(text.as_bytes())?;
            write(path, results.csv())?;
        }
        None => outputs::print(text.as_bytes())?,
    }
    if ending == MeterEnding::Cancelled {
        report::error("interrupted; the values are those of the samples so far");
        return Ok(ExitCode::from(INTERRUPTED));
    }
    match results.passes() {
        true => Ok(ExitCode::SUCCESS),
        false => Ok(ExitCode::from(LIMIT_NOT_MET)),
    }
}

/// The app with the scene as it is rendered; None if it is refused, which has been reported.
fn loaded(args: &MeasureArgs, cancel: &Arc<AtomicBool>) -> Result<Option<App>, Failure> {
    let scene = &args.scene.scene;
    let trust = args.trust.trust(scene)?;
    let mut app = open(scene, &args.scene.defines, trust, &args.missing, args.threads.threads);
    let limits = Limits {
        cancel: cancel.clone(),
        ..Limits::default()
    };
    if !load(&mut app, &limits, scene, args.strict)? {
        return Ok(None);
    }
    if let Some(camera) = &args.camera {
        let world = app.world_mut();
        let camera = find_camera(world, camera).map_err(|error| Failure::Usage(error.to_string()))?;
        world.insert_resource(ActiveSensor(Some(camera)));
        // Prepares the scene for the chosen camera.
        load_to_completion(&mut app, &limits)?;
    }
    Ok(is_shown(&app, scene, args.strict).then_some(app))
}

/// The glare of the view; None if interrupted.
fn rated(
    scene: &RenderScene,
    view: &View,
    pool: &rayon::ThreadPool,
    cancel: &AtomicBool,
) -> Result<Option<Glare>, Failure> {
    let camera = view.of_film();
    if camera.is_orthographic() {
        return Err("an orthographic camera has no place from which glare could be rated".into());
    }
    Ok(pool.install(|| glare(scene, view, &camera, cancel)))
}

fn write(path: &Path, text: String) -> Result<(), Failure> {
    let written = write_atomically(path, text);
    Ok(written.map_err(|error| format!("cannot write {}: {error}", path.display()))?)
}

/// A scene that is ready to be measured.
struct Prepared {
    job: MeterJob,
    /// The scene and the view that --ugr rates, if it is asked for.
    seen: Option<(RenderScene, View)>,
    /// The upward direction of the overcast sky; None under the lights of the scene.
    up: Option<Upward>,
}

fn prepared(args: &MeasureArgs, mut app: App) -> Result<Prepared, Failure> {
    let place = args.scene.scene.display();
    let world = app.world_mut();
    let mut asked = asked_meters(world);
    if asked.is_empty() && !args.ugr {
        return Err(format!(
            "{place} has no measuring points: add one with Add > Measuring point or Measuring grid in the window, or to \
             the file, such as\n  {}\nwhich measures the light on the side of its +z",
            r#"<emitter type="illuminancemeter" id="desk"><transform name="to_world"><rotate x="1" angle="-90"/><translate y="0.75"/></transform></emitter>"#
        )
        .into());
    }
    let packed = world.resource::<PackedScene>();
    let (Some(mut scene), Some(mut view)) = (packed.scene.clone(), packed.view.clone()) else {
        return Err(format!("{place}: there is nothing to measure in").into());
    };
    if let Some(seed) = args.seed {
        view.seed = seed;
    }
    if finds_no_light(&view) {
        report::line(format_args!(
            "warning: {place}: max_depth 1 ends paths before any light: every value is 0"
        ));
    }
    let up = args.daylight_factor.then(|| match args.up {
        Some(direction) => Upward {
            direction,
            source: "--up",
        },
        None => {
            let mut emitters = world.query_filtered::<MeterParts, Without<Hidden>>();
            upward(emitters.iter(world), &view)
        }
    });
    if let Some(up) = up {
        (scene, view) = under_overcast_sky(&scene, &view, up.direction);
        // What is asked for is asked of the lights of the scene.
        asked.iter_mut().for_each(|asked| asked.limits = MeterLimits::default());
    }
    let seen = args.ugr.then(|| (scene.clone(), view.clone()));
    let job = MeterJob::new(scene, &view, asked)?;
    Ok(Prepared { job, seen, up })
}

/// Measures, and shows the progress. Returns the seconds too.
fn measured(
    args: &MeasureArgs,
    job: &mut MeterJob,
    pool: &Arc<rayon::ThreadPool>,
    cancel: &AtomicBool,
) -> (MeterEnding, f64) {
    let begin = Instant::now();
    let end: MeterEnd = args.end();
    let mut progress = Progress::new(args.quiet, end.time);
    let mut last = Shown::default();
    let ending = job.run(&end, pool, cancel, &mut |job, done| {
        let seconds = begin.elapsed().as_secs_f64();
        let by_time = end.time.map_or(0.0, |time| seconds / time.as_secs_f64());
        let samples = job.least_samples();
        last = Shown {
            done: done.max(by_time).min(1.0),
            samples,
            seconds,
            message: format!("{samples} samples per point"),
        };
        progress.show(&last);
    });
    progress.end(&last);
    (ending, begin.elapsed().as_secs_f64())
}
