//! How quickly the window answers: frame times, and the time from a camera command to the first changed pixels in the texture.

use std::collections::VecDeque;
use std::io::Write;
use std::time::{Duration, Instant};

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::*;

use super::command::Command;
use super::commands::camera_pose;
use super::pacing::Pacing;
use super::picture::Picture;
use super::state::CommandQueue;
use crate::engine::{RenderFilm, RenderState, RenderStatus};
use crate::scene::{ActiveSensor, FreeView, ToWorld};

/// Times between the last frames.
#[derive(Resource, Default)]
pub struct FrameTimes {
    recent: VecDeque<f32>,
    last: Option<Instant>,
}

const FRAMES_KEPT: usize = 240;

impl FrameTimes {
    /// None before the first frame.
    pub fn frame_started(&self) -> Option<Instant> {
        self.last
    }

    /// Milliseconds; None before the second frame.
    pub fn median_ms(&self) -> Option<f32> {
        median(self.recent.iter().copied().collect(), 0.5)
    }
}

/// Only frames count that followed each other as fast as they could.
pub fn time_frames(mut frames: ResMut<FrameTimes>, pacing: Res<Pacing>) {
    let now = Instant::now();
    if let Some(last) = frames.last.replace(now).filter(|_| pacing.is_lively()) {
        if frames.recent.len() == FRAMES_KEPT {
            frames.recent.pop_front();
        }
        frames.recent.push_back(1e3 * (now - last).as_secs_f32());
    }
}

/// The nearest-rank quantile, `q` in [0, 1].
fn median(mut values: Vec<f32>, q: f32) -> Option<f32> {
    values.sort_by(f32::total_cmp);
    let rank = (q * values.len() as f32).ceil() as usize;
    values.get(rank.saturating_sub(1)).copied()
}

/// The measurement asked for on the command line.
#[derive(Resource)]
pub struct LatencyProbe {
    left: u32,
    phase: Phase,
    results: Vec<f32>,
    origin: Option<Affine3A>,
    pub done: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Phase {
    /// Lets the picture run so that the move interrupts real work.
    Rest(Instant),
    Waiting {
        since: Instant,
        job: u64,
        revision: u64,
    },
}

/// Between two moves.
const REST: Duration = Duration::from_millis(400);

impl LatencyProbe {
    pub fn new(moves: u32) -> Self {
        Self {
            left: moves,
            phase: Phase::Rest(Instant::now()),
            results: Vec::new(),
            origin: None,
            done: false,
        }
    }
}

/// Says the next move, as a key would.
pub fn move_for_probe(
    mut probe: ResMut<LatencyProbe>,
    mut queue: ResMut<CommandQueue>,
    film: Res<RenderFilm>,
    picture: Res<Picture>,
    status: Res<RenderStatus>,
    active: Res<ActiveSensor>,
    free_view: Res<FreeView>,
    poses: Query<&ToWorld>,
) {
    let Phase::Rest(since) = probe.phase else {
        return;
    };
    let has_picture = matches!(status.state, RenderState::Rendering | RenderState::Done) && status.samples > 0;
    let pose = camera_pose(&active, &free_view, &poses);
    let (true, Some(pose)) = (has_picture && since.elapsed() >= REST && probe.left > 0, pose) else {
        return;
    };
    let origin = *probe.origin.get_or_insert(pose);
    // To and fro by a hundredth of a radian, so that the view stays what it was.
    let angle = if probe.left.is_multiple_of(2) { 0.01 } else { -0.01 };
    let turned = Affine3A {
        matrix3: origin.matrix3 * bevy::math::Mat3A::from_axis_angle(Vec3::Y, angle),
        translation: origin.translation,
    };
    queue.0.push(Command::MoveView(turned));
    probe.phase = Phase::Waiting {
        since: Instant::now(),
        job: film.job,
        revision: picture.revision,
    };
}

/// Stops the clock when the new picture's first pixels are in the texture.
pub fn watch_probe(
    mut probe: ResMut<LatencyProbe>,
    film: Res<RenderFilm>,
    picture: Res<Picture>,
    frames: Res<FrameTimes>,
    status: Res<RenderStatus>,
) {
    let Phase::Waiting { since, job, revision } = probe.phase else {
        return;
    };
    if film.job == job || picture.revision == revision {
        return;
    }
    let elapsed = 1e3 * since.elapsed().as_secs_f32();
    probe.results.push(elapsed);
    probe.left -= 1;
    probe.phase = Phase::Rest(Instant::now());
    if probe.left == 0 {
        probe.done = true;
        let at = |q| median(probe.results.clone(), q).unwrap_or(f32::NAN);
        let line = format!(
            "camera command to first changed pixels: median {:.1} ms, 95 % {:.1} ms, worst {:.1} ms, {} moves, {}x{} pixels\n\
             of which until the first tile was rendered: median {:.1} ms, 95 % {:.1} ms; the rest waits for the window's frames: median {:.1} ms each",
            at(0.5),
            at(0.95),
            at(1.0),
            probe.results.len(),
            status.size.x,
            status.size.y,
            status.response.median_ms().unwrap_or(f32::NAN),
            status.response.p95_ms().unwrap_or(f32::NAN),
            frames.median_ms().unwrap_or(f32::NAN),
        );
        // A closed pipe is no reason to fail.
        let _ = writeln!(std::io::stdout(), "{line}");
    }
}
