//! Runs an app without a window until loading or a picture is done.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use bevy::app::PluginsState;
use bevy::prelude::*;

use super::choosing::{Cancelled, find_choice, set_choice};
use super::control::{RenderControl, WakeUp};
use super::renderer::Renderer;
use super::status::{RenderState, RenderStatus};
use crate::scene::{SceneState, SceneStatus};

/// The limits of loading and rendering.
#[derive(Clone, Debug)]
pub struct Limits {
    /// The samples per pixel; None takes the number from [`RenderControl`] or the scene.
    pub samples: Option<u32>,
    /// The rendering time, without loading and building. The current pass is still finished unless that takes long.
    pub time: Option<Duration>,
    /// The time limit for loading the scene and its meshes.
    pub loading: Duration,
    /// A flag that is set from outside (Ctrl-C) to stop as soon as possible.
    pub cancel: Arc<AtomicBool>,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            samples: None,
            time: None,
            loading: Duration::from_secs(600),
            cancel: Arc::default(),
        }
    }
}

/// The reason why rendering ended; the film is usable in each case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The film has all samples.
    Complete,
    /// Time was up; pixels may differ in their number of samples if the last pass took too long to finish.
    TimeUp,
    /// The flag was set; the film holds whole passes.
    Cancelled,
}

/// The reason why there is no picture, or only a part of it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum RenderError {
    /// The diagnostics are in [`SceneStatus`].
    #[error("the scene could not be loaded")]
    SceneFailed,
    #[error("the scene has not loaded within {} s", .0.as_secs())]
    LoadingTooLong(Duration),
    #[error("the scene has no sensor to render from")]
    NoSensor,
    #[error("rendering broke off: {0}")]
    Failed(String),
}

/// The wait between two polls of a state that sends no signal.
const NAP: Duration = Duration::from_millis(2);
/// The longest wait while workers are busy. Cancelling and progress are checked in between, and results wait as long,
/// because each check takes time from the workers.
const LONGEST_WAIT: Duration = Duration::from_millis(50);
/// The time beyond the limit that finishing a pass may take: at least `LEAST_GRACE`, or `GRACE_SHARE` of the limit if
/// that is longer.
const LEAST_GRACE: Duration = Duration::from_secs(1);
const GRACE_SHARE: f64 = 0.1;

/// Updates the app until the scene and its meshes have been read or have failed: [`SceneStatus`] lists the failed
/// meshes. Rendering waits meanwhile. If no scene was requested, loading is done at once. Returns false if it was
/// cancelled.
pub fn load_to_completion(app: &mut App, limits: &Limits) -> Result<bool, RenderError> {
    let begin = Instant::now();
    finish_plugins(app);
    let paused = std::mem::replace(&mut app.world_mut().resource_mut::<RenderControl>().paused, true);
    let result = loop {
        app.update();
        if limits.cancel.load(Ordering::Relaxed) {
            break Ok(false);
        }
        let (scene, status) = (
            app.world().resource::<SceneStatus>(),
            app.world().resource::<RenderStatus>(),
        );
        match scene.state {
            SceneState::Failed => break Err(RenderError::SceneFailed),
            SceneState::Empty | SceneState::Ready if scene.files_loading() == 0 && status.meshes_loading == 0 => {
                break Ok(true);
            }
            _ if begin.elapsed() > limits.loading => break Err(RenderError::LoadingTooLong(limits.loading)),
            _ => std::thread::sleep(NAP),
        }
    };
    app.world_mut().resource_mut::<RenderControl>().paused = paused;
    result
}

/// Makes the choice of the integrator `auto` for the packed scene and a picture with this number of samples per pixel,
/// before it is rendered; None takes the film's number. The choice is the same on any number of threads, and for every
/// share of the picture. An existing choice stays, and without `auto` nothing happens. Returns false if it was
/// cancelled.
pub fn choose_integrator(app: &mut App, samples: Option<u32>, limits: &Limits) -> Result<bool, RenderError> {
    if !load_to_completion(app, limits)? {
        return Ok(false);
    }
    match find_choice(app.world(), samples, &limits.cancel) {
        Ok(choice) => {
            choice
                .into_iter()
                .for_each(|choice| set_choice(app.world_mut(), choice));
            Ok(true)
        }
        Err(Cancelled) => Ok(false),
    }
}

/// Loads, renders and returns when a limit is reached; `progress` is called after every update of the app.
pub fn render_to_completion(
    app: &mut App,
    limits: &Limits,
    mut progress: impl FnMut(&RenderStatus),
) -> Result<Outcome, RenderError> {
    render_watched(app, limits, |world| progress(world.resource()))
}

/// [`render_to_completion`] that calls `watch` with the whole world while film and job are in agreement.
pub fn render_watched(app: &mut App, limits: &Limits, watch: impl FnMut(&World)) -> Result<Outcome, RenderError> {
    let waiting = std::thread::current();
    let wake_up = WakeUp(Some(Arc::new(move || waiting.unpark())));
    let before = std::mem::replace(&mut *app.world_mut().resource_mut::<WakeUp>(), wake_up);
    let outcome = render_until(app, limits, watch);
    *app.world_mut().resource_mut() = before;
    outcome
}

fn render_until(app: &mut App, limits: &Limits, mut watch: impl FnMut(&World)) -> Result<Outcome, RenderError> {
    let control = app.world().resource::<RenderControl>();
    let (asked, is_interactive) = (limits.samples.or(control.target_samples), control.interactive);
    if !load_to_completion(app, limits)? || !is_interactive && !choose_integrator(app, asked, limits)? {
        return Ok(Outcome::Cancelled);
    }
    let mut control = app.world_mut().resource_mut::<RenderControl>();
    // A time limit that an earlier picture reached has paused the engine.
    control.paused = false;
    if limits.samples.is_some() {
        control.target_samples = limits.samples;
    }
    // Once the time is up: the samples at the end of the current pass, and when to abandon it.
    let mut last_pass: Option<(u32, Duration)> = None;
    loop {
        app.update();
        watch(app.world());
        let status = app.world().resource::<RenderStatus>();
        let (state, spent) = (status.state, Duration::from_secs_f64(status.seconds));
        match state {
            RenderState::Failed => {
                return Err(RenderError::Failed(status.errors.first().cloned().unwrap_or_default()));
            }
            RenderState::Idle => return Err(RenderError::NoSensor),
            RenderState::Done if last_pass.is_some() => return Ok(Outcome::TimeUp),
            RenderState::Done => return Ok(Outcome::Complete),
            RenderState::Paused | RenderState::Loading | RenderState::Building | RenderState::Rendering => {}
        }
        if limits.cancel.load(Ordering::Relaxed) {
            return Ok(stop(app, Outcome::Cancelled));
        }
        match (limits.time, last_pass) {
            (Some(time), None) if spent >= time => {
                let end = app
                    .world()
                    .resource::<Renderer>()
                    .job()
                    .and_then(super::job::Job::finish_pass);
                let grace = LEAST_GRACE.max(time.mul_f64(GRACE_SHARE));
                last_pass = Some((end.unwrap_or(0), time + grace));
                if end.is_some() {
                    // The dispatcher sets the queue's target in every frame, so that it must know the lower one too.
                    app.world_mut().resource_mut::<RenderControl>().target_samples = end;
                }
            }
            (_, Some((end, latest))) if status.samples >= end || spent >= latest => {
                return Ok(stop(app, Outcome::TimeUp));
            }
            _ => {}
        }
        match state {
            RenderState::Rendering => {
                let end = last_pass.map(|(_, latest)| latest).or(limits.time);
                let left = end.map_or(LONGEST_WAIT, |end| end.saturating_sub(spent));
                std::thread::park_timeout(left.clamp(NAP, LONGEST_WAIT));
            }
            _ => std::thread::sleep(NAP),
        }
    }
}

/// Stops the workers; the film keeps its samples.
fn stop(app: &mut App, outcome: Outcome) -> Outcome {
    app.world_mut().resource_mut::<RenderControl>().paused = true;
    app.update();
    outcome
}

/// Finishes the plugins, as a runner does before the first update.
fn finish_plugins(app: &mut App) {
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
        std::thread::sleep(NAP);
    }
    if app.plugins_state() == PluginsState::Ready {
        app.finish();
        app.cleanup();
    }
}
