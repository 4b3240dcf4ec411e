//! Adds the workers' results to the film.

use std::time::{Duration, Instant};

use bevy::prelude::*;

use super::control::{RenderControl, WakeUp};
use super::deferred_drop::DeferredDrop;
use super::film::RenderFilm;
use super::renderer::Renderer;
use super::status::RenderStatus;

/// The time per frame for adding tiles to the film; further tiles wait for the next frame.
const BUDGET: Duration = Duration::from_millis(8);
/// The time for adding tiles to the film where there are no frames to wait for.
const BUDGET_WITHOUT_WINDOW: Duration = Duration::from_millis(50);

pub(super) fn collect_results(
    mut renderer: ResMut<Renderer>,
    mut film: ResMut<RenderFilm>,
    mut status: ResMut<RenderStatus>,
    control: Res<RenderControl>,
    wake_up: Res<WakeUp>,
    deferred: Res<DeferredDrop>,
) {
    let Some(job) = renderer.job_mut().filter(|job| job.is_running()) else {
        return;
    };
    let budget = if control.interactive {
        BUDGET
    } else {
        BUDGET_WITHOUT_WINDOW
    };
    // This is read before collecting, which may end the run.
    let first_result = job.first_result();
    // Change detection is triggered only by new results, because the display relies on it.
    let collected = job.collect(film.bypass_change_detection(), Instant::now() + budget, &deferred);
    if collected == 0 {
        return;
    }
    film.set_changed();
    if let Some(wake) = &wake_up.0
        && job.has_results()
    {
        // The workers may have no further results, and so no reason to wake the event loop.
        wake();
    }
    // The G-buffer alone shows nothing.
    if film.is_lit
        && let Some(since) = job.since.take()
    {
        let milliseconds = |duration: Duration| duration.as_secs_f32() * 1e3;
        status.latency.record(milliseconds(since.elapsed()));
        if let Some(at) = first_result {
            status
                .response
                .record(milliseconds(at.saturating_duration_since(since)));
        }
    }
}
