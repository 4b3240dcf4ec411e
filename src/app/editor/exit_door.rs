//! The window without a user: takes a picture of itself and ends, for tests and for people who want to see it.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};

use super::latency::{FrameTimes, LatencyProbe};
use super::motion::Motion;
use super::script::Script;
use crate::engine::{RenderState, RenderStatus};
use crate::files::write_atomically;
use crate::scene::{SceneState, SceneStatus};

#[derive(Resource)]
pub struct ExitDoor {
    screenshot: Option<PathBuf>,
    after_spp: u32,
    exit: bool,
    started: Instant,
    timeout: Duration,
    step: Step,
}

#[derive(Clone, Copy, PartialEq)]
enum Step {
    /// For the samples, or the measurement.
    Waiting,
    /// The picture is ready; a few frames more, so that the panels show it too.
    Settling(u32),
    Capturing,
    Done,
}

const SETTLING_FRAMES: u32 = 3;

impl ExitDoor {
    pub fn new(screenshot: Option<PathBuf>, after_spp: u32, exit: bool, timeout: Duration) -> Self {
        Self {
            screenshot,
            after_spp,
            exit,
            started: Instant::now(),
            timeout,
            step: Step::Waiting,
        }
    }

    /// Nothing is done any more; the picture that is not there then.
    pub fn give_up(&mut self) -> Option<PathBuf> {
        let before = std::mem::replace(&mut self.step, Step::Done);
        self.screenshot.take().filter(|_| before != Step::Done)
    }
}

pub fn drive_exit_door(
    mut commands: Commands,
    mut door: ResMut<ExitDoor>,
    mut exit: MessageWriter<AppExit>,
    status: Res<RenderStatus>,
    scene: Res<SceneStatus>,
    probe: Option<Res<LatencyProbe>>,
    script: Option<Res<Script>>,
    motion: Res<Motion>,
) {
    if door.exit && door.step != Step::Done && door.started.elapsed() > door.timeout {
        error!(
            "Gave up after {:.0} s at {} of {} samples",
            door.timeout.as_secs_f32(),
            status.samples,
            door.after_spp
        );
        exit.write(AppExit::error());
        door.step = Step::Done;
    }
    match door.step {
        Step::Waiting => {
            // A script says itself which of its lines that was.
            if door.exit && scene.state == SceneState::Failed && script.as_ref().is_none_or(|script| script.is_done()) {
                error!("The scene could not be loaded");
                exit.write(AppExit::error());
                door.step = Step::Done;
                return;
            }
            let enough =
                status.samples >= door.after_spp.max(1) || (status.state == RenderState::Done && status.samples > 0);
            let is_scripted = script.is_some_and(|script| !script.is_done());
            let settled = scene.files_loading() == 0
                && motion.is_settled()
                && !matches!(status.state, RenderState::Loading | RenderState::Building)
                && scene.state != SceneState::Loading;
            if enough && settled && !is_scripted && probe.is_none_or(|probe| probe.done) {
                door.step = Step::Settling(SETTLING_FRAMES);
            }
        }
        Step::Settling(0) => match door.screenshot.clone() {
            Some(path) => {
                door.step = Step::Capturing;
                commands.spawn(Screenshot::primary_window()).observe(
                    move |captured: On<ScreenshotCaptured>,
                          mut door: ResMut<ExitDoor>,
                          mut exit: MessageWriter<AppExit>| {
                        let outcome = save_window(&captured.image, &path);
                        door.step = Step::Done;
                        match outcome {
                            Ok(()) => info!("Saved {}", path.display()),
                            Err(message) => {
                                error!("{}: {message}", path.display());
                                exit.write(AppExit::error());
                                return;
                            }
                        }
                        if door.exit {
                            exit.write(AppExit::Success);
                        }
                    },
                );
            }
            None => {
                door.step = Step::Done;
                if door.exit {
                    exit.write(AppExit::Success);
                }
            }
        },
        Step::Settling(frames) => door.step = Step::Settling(frames - 1),
        Step::Capturing | Step::Done => {}
    }
}

/// A captured window as PNG.
pub fn save_window(image: &Image, path: &std::path::Path) -> Result<(), String> {
    let picture = image.clone().try_into_dynamic().map_err(|error| error.to_string())?;
    let mut png = std::io::Cursor::new(Vec::new());
    picture
        .to_rgb8()
        .write_to(&mut png, image::ImageFormat::Png)
        .map_err(|error| error.to_string())?;
    write_atomically(path, png.into_inner()).map_err(|error| error.to_string())
}

/// The figures of this run, once, when it ends.
pub fn log_at_exit(mut exits: MessageReader<AppExit>, status: Res<RenderStatus>, frames: Res<FrameTimes>) {
    if exits.read().next().is_none() {
        return;
    }
    let ms = |value: Option<f32>| value.map_or("none".to_owned(), |ms| format!("{ms:.1} ms"));
    info!(
        "latency: median {}, 95 % {}, {} restarts; frame time: median {}",
        ms(status.latency.median_ms()),
        ms(status.latency.p95_ms()),
        status.latency.len(),
        ms(frames.median_ms()),
    );
}
