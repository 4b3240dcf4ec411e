//! The end of a run without a user: waits for the picture, saves the window, and ends the program.

use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, ScreenshotCaptured};

use super::exit_door::{ExitDoor, Step};
use super::latency::LatencyProbe;
use super::screenshot::{WindowWait, save_window};
use super::script::Script;
use super::settling::SettlingProbe;
use crate::app::editor::picture::denoiser::Denoiser;
use crate::app::editor::picture::frame_times::FrameTimes;
use crate::app::editor::picture::motion::Motion;
use crate::app::editor::picture::pacing::Pacing;
use crate::app::editor::picture::resolution::PicturePlace;
use crate::app::editor::window::preview::Previews;
use crate::engine::{RenderControl, RenderState, RenderStatus};
use crate::scene::{SceneState, SceneStatus, SceneWatch};

const SETTLING_FRAMES: u32 = 3;

pub(crate) fn drive_exit_door(
    mut commands: Commands,
    mut door: ResMut<ExitDoor>,
    mut exit: MessageWriter<AppExit>,
    status: Res<RenderStatus>,
    scene: Res<SceneStatus>,
    probe: Option<Res<LatencyProbe>>,
    script: Option<Res<Script>>,
    motion: Res<Motion>,
    mut control: ResMut<RenderControl>,
    mut window_wait: Local<WindowWait>,
    (pacing, previews, place, denoiser): (Res<Pacing>, Res<Previews>, Res<PicturePlace>, Res<Denoiser>),
    settling: Option<Res<SettlingProbe>>,
) {
    let settling = settling.as_ref().filter(|probe| !probe.done);
    if door.exit && door.step != Step::Done && door.started.elapsed() > door.timeout {
        let awaited = match script.as_ref().filter(|script| !script.is_done()) {
            Some(script) => script.awaited(&status),
            None if settling.is_some() => settling.map_or_else(String::new, |probe| probe.awaited()),
            None => {
                let wanted = door.wanted_samples();
                let lack = if status.samples < wanted {
                    ""
                } else if denoiser.is_copying() || denoiser.is_working() {
                    ", which are being denoised"
                } else if !previews.are_done() {
                    ", without all previews of materials"
                } else {
                    ""
                };
                format!("at {} of {wanted} samples per pixel{lack}", status.samples)
            }
        };
        error!("Gave up after {:.0} s {awaited}", door.timeout.as_secs_f32());
        exit.write(AppExit::error());
        door.step = Step::Done;
    }
    let is_scripted = script.is_some_and(|script| !script.is_done());
    let waits = matches!(door.step, Step::Waiting | Step::Sampling(_));
    // A script reports the line itself.
    if door.exit && waits && scene.state == SceneState::Failed && !is_scripted {
        error!("The scene could not be loaded");
        exit.write(AppExit::error());
        door.step = Step::Done;
    }
    match door.step {
        Step::Waiting => {
            if is_scripted || settling.is_some() || probe.is_some_and(|probe| !probe.done) {
                return;
            }
            // A script may have waited for more samples.
            let samples = door.after_spp.max(control.exact_samples.unwrap_or(1));
            let exact = match (&door.screenshot, door.exit) {
                (Some(_), _) => Some(samples),
                // The program is about to end.
                (None, true) => control.exact_samples,
                (None, false) => None,
            };
            if control.exact_samples != exact {
                control.exact_samples = exact;
            }
            door.step = Step::Sampling(samples);
        }
        Step::Sampling(samples) => {
            let is_reached = match status.state {
                RenderState::Done if door.screenshot.is_some() => status.samples >= samples,
                RenderState::Done => status.samples > 0,
                RenderState::Rendering => door.screenshot.is_none() && status.samples >= samples,
                RenderState::Paused => status.samples >= door.after_spp,
                _ => false,
            };
            let is_denoised = !denoiser.is_copying() && !denoiser.is_working();
            let is_there = is_reached && status.is_up_to_date && motion.is_settled() && place.is_settled();
            let is_complete =
                door.screenshot.is_none() || is_there && is_denoised && window_wait.is_over(&pacing, &previews);
            if is_there && is_complete {
                door.step = Step::Settling(SETTLING_FRAMES);
            }
        }
        Step::Settling(0) => match door.screenshot.clone() {
            Some(path) => {
                door.step = Step::Capturing;
                commands.spawn(Screenshot::primary_window()).observe(
                    move |captured: On<ScreenshotCaptured>,
                          mut door: ResMut<ExitDoor>,
                          mut control: ResMut<RenderControl>,
                          scene: Res<SceneWatch>,
                          mut exit: MessageWriter<AppExit>| {
                        let outcome = save_window(&captured.image, &path, &scene);
                        door.step = Step::Done;
                        control.exact_samples = None;
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

/// Logs the figures of this run, once, when it ends.
pub(crate) fn log_at_exit(mut exits: MessageReader<AppExit>, status: Res<RenderStatus>, frames: Res<FrameTimes>) {
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
