//! `sunroom why`: where the light of a place in the picture comes from, and where the light of a lamp goes.

mod lamp;
mod question;
mod report;

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bevy::prelude::*;
use sunroom::app::interrupt::on_interrupt;
use sunroom::app::threads::worker_count;
use sunroom::engine::reasons::Things;
use sunroom::engine::{Limits, PackedScene, load_to_completion};

pub use self::question::WhyArgs;

use self::question::Question;
use super::check::{is_shown, load, open};
use super::ending::INTERRUPTED;
use super::outputs;
use super::render::{choose_camera, set_size};
use super::report::Failure;

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
    let is_loaded = load(&mut app, &limits, scene, args.strict);
    let is_interrupted = || cancel.load(Ordering::Relaxed);
    if is_interrupted() {
        return Ok(ExitCode::from(INTERRUPTED));
    }
    if !is_loaded? {
        return Ok(ExitCode::FAILURE);
    }
    choose_camera(app.world_mut(), args.camera.as_deref())?;
    set_size(app.world_mut(), &args.size)?;
    // Prepares the scene for the chosen camera.
    if !load_to_completion(&mut app, &limits)? || is_interrupted() {
        return Ok(ExitCode::from(INTERRUPTED));
    }
    if !is_shown(&app, scene, args.strict) {
        return Ok(ExitCode::FAILURE);
    }
    let packed = app.world().resource::<PackedScene>();
    let (Some(kernel), Some(mut view)) = (packed.scene.clone(), packed.view.clone()) else {
        return Err(format!("{}: there is nothing to see", scene.display()).into());
    };
    view.seed = args.seed.unwrap_or(view.seed);
    let question = Question {
        args,
        world: app.world(),
        things: Things::of(packed),
        scene: kernel,
        view,
        cancel: cancel.clone(),
    };
    let threads = worker_count(args.threads.threads, false).get();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let text = match &args.subject.lamp {
        Some(name) => question.lamp(name, &pool)?,
        None => question.area(&pool)?,
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
