//! Measures how long the window's frames take.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use bevy::prelude::*;
use bevy::render::{Render, RenderApp, RenderSystems};

use super::pacing::Pacing;

/// The times of the last frames.
#[derive(Resource, Default)]
pub(crate) struct FrameTimes {
    recent: VecDeque<f32>,
    /// The whole time of the last frame, see [`Frame`].
    whole: Option<f32>,
    last: Option<Instant>,
    /// The milliseconds that the systems of the last frame took, the editor's and egui's, until the window was handed
    /// to the thread that draws it.
    own: f32,
    /// The microseconds that drawing the last frame took, with the driver's time.
    drawn: Arc<AtomicU64>,
}

const FRAMES_KEPT: usize = 240;

impl FrameTimes {
    /// The start of the present frame; None before the first.
    pub fn frame_started(&self) -> Option<Instant> {
        self.last
    }

    /// The milliseconds that the systems of the last frame took, the editor's and egui's, without the drawing of the
    /// window.
    pub fn own_ms(&self) -> f32 {
        self.own
    }

    /// Milliseconds; None before the second frame.
    pub fn median_ms(&self) -> Option<f32> {
        median(self.recent.iter().copied().collect(), 0.5)
    }
}

/// The durations of a frame, in milliseconds.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// The time from its beginning to that of the next one; None where the window rested in between.
    pub whole: Option<f32>,
    /// The window's own systems.
    pub own: f32,
    /// The time of drawing on another thread, at the same time as the next frame's `own`.
    pub drawing: f32,
}

impl FrameTimes {
    pub fn last_frame(&self) -> Frame {
        Frame {
            whole: self.whole,
            own: self.own,
            drawing: 1e-3 * self.drawn.load(Ordering::Relaxed) as f32,
        }
    }
}

/// Takes the time at the end of the frame's systems.
pub(crate) fn time_systems(mut frames: ResMut<FrameTimes>) {
    frames.own = frames.last.map_or(0.0, |begun| 1e3 * begun.elapsed().as_secs_f32());
}

/// Measures the thread that draws the window.
pub(crate) fn time_drawing(app: &mut App) {
    let drawn = app.world().resource::<FrameTimes>().drawn.clone();
    if let Some(renderer) = app.get_sub_app_mut(RenderApp) {
        let begun = Arc::new(Mutex::new(None));
        let end = begun.clone();
        let begin = move || *begun.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
        let finish = move || {
            let begun: Option<Instant> = *end.lock().unwrap_or_else(PoisonError::into_inner);
            let micros = begun.map_or(0, |begun| begun.elapsed().as_micros() as u64);
            drawn.store(micros, Ordering::Relaxed);
        };
        renderer
            .add_systems(Render, begin.before(RenderSystems::ExtractCommands))
            .add_systems(Render, finish.after(RenderSystems::PostCleanup));
    }
}

/// Measures the time of frames. Only frames that follow each other without a pause count.
pub(crate) fn time_frames(mut frames: ResMut<FrameTimes>, pacing: Res<Pacing>) {
    let now = Instant::now();
    let last = frames.last.replace(now).filter(|_| pacing.is_lively());
    frames.whole = last.map(|last| 1e3 * (now - last).as_secs_f32());
    if let Some(whole) = frames.whole {
        if frames.recent.len() == FRAMES_KEPT {
            frames.recent.pop_front();
        }
        frames.recent.push_back(whole);
    }
}

/// The nearest-rank quantile, `q` in [0, 1].
pub fn median(mut values: Vec<f32>, q: f32) -> Option<f32> {
    values.sort_by(f32::total_cmp);
    let rank = (q * values.len() as f32).ceil() as usize;
    values.get(rank.saturating_sub(1)).copied()
}
