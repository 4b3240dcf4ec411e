//! Decides how often the window is drawn: often while the picture changes, rarely otherwise. Input and results wake it
//! at once.
//!
//! A software driver draws with the cores that trace rays. There the window is not drawn after an edit until the new
//! picture has pixels. While there is no input and the picture only becomes less noisy, drawing takes at most a tenth
//! of a core with any driver.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use bevy::render::view::screenshot::Screenshot;
use bevy::window::WindowEvent;
use bevy::winit::{EventLoopProxyWrapper, UpdateMode, WinitSettings, WinitUserEvent};

use super::carrying::Carrying;
use super::denoiser::Denoiser;
use super::frame_times::FrameTimes;
use super::texture::Picture;
use crate::app::editor::session::history::History;
use crate::app::editor::session::recovery::Recovery;
use crate::app::editor::session::toasts::Toasts;
use crate::engine::{RenderState, RenderStatus, WakeUp};

const LIVELY: Duration = Duration::from_millis(16);
const SPARING: Duration = Duration::from_millis(100);
const IDLE: Duration = Duration::from_millis(500);
/// The time after a command for which the window is drawn often.
const AFTER_INPUT: Duration = Duration::from_millis(500);
/// The time after any event of the window in which no frame is skipped, long enough for tooltips.
const AFTER_EVENT: Duration = Duration::from_millis(800);
/// The least rest after a frame that was drawn without input, as a multiple of the time that it took.
const REST: f32 = 9.0;
/// The longest such rest.
const LONGEST_REST: Duration = Duration::from_secs(2);
/// The decay of the measured drawing time per frame that took less, since skipped frames take no time.
const MEMORY: f32 = 0.97;
/// The longest wait for an edit's first pixels; then the panels are drawn without them.
const LONGEST_HOLD: Duration = Duration::from_millis(120);

#[derive(Resource, Default)]
pub struct Pacing {
    /// The time of the last command.
    last_input: Option<Instant>,
    /// The time of a command whose picture has no pixels yet.
    waiting_since: Option<Instant>,
    /// The time of the last event of the window, such as a moved pointer or a pressed key.
    last_event: Option<Instant>,
    /// The time at which the window was last drawn.
    last_drawn: Option<Instant>,
    /// The milliseconds that drawing takes.
    drawing: f32,
    /// The revision of the texture that was drawn last.
    drawn: u64,
    /// Whether results wake the event loop at once. The worker threads share it.
    is_lively: Arc<AtomicBool>,
    draws_on_cpu: bool,
    /// Whether nothing is drawn, see [`crate::app::editor::session::options::WindowOptions::undrawn`].
    undrawn: bool,
}

impl Pacing {
    pub fn new(undrawn: bool) -> Self {
        Self {
            undrawn,
            ..Self::default()
        }
    }

    /// Whether frames follow each other without rest.
    pub fn is_lively(&self) -> bool {
        self.is_lively.load(Ordering::Relaxed)
    }

    /// Whether there has been no input for a while.
    pub fn rests(&self) -> bool {
        self.last_input.is_none_or(|at| at.elapsed() >= AFTER_INPUT)
    }

    /// Whether this frame is skipped because there is no input and the last drawing took long.
    fn spares(&self, now: Instant, status: &RenderStatus) -> bool {
        let since = |then: Option<Instant>| then.map_or(Duration::MAX, |then| now.duration_since(then));
        let rest = Duration::from_secs_f32(1e-3 * REST * self.drawing).min(LONGEST_REST);
        status.state == RenderState::Rendering
            && self.rests()
            && since(self.last_event) >= AFTER_EVENT
            && since(self.last_drawn) < rest
    }

    /// Notes that commands are applied. `restarts` says that they restart the picture.
    pub fn note_commands(&mut self, restarts: bool) {
        let now = Instant::now();
        self.last_input = Some(now);
        if restarts && self.waiting_since.is_none() {
            self.waiting_since = Some(now);
        }
    }
}

/// Lets worker threads wake the event loop.
pub fn connect_wake_up(
    proxy: Res<EventLoopProxyWrapper>,
    adapter: Option<Res<RenderAdapterInfo>>,
    mut pacing: ResMut<Pacing>,
    mut wake_up: ResMut<WakeUp>,
) {
    pacing.draws_on_cpu = adapter.is_some_and(|adapter| is_software(&adapter));
    let proxy = (**proxy).clone();
    let is_lively = pacing.is_lively.clone();
    wake_up.0 = Some(Arc::new(move || {
        if is_lively.load(Ordering::Relaxed) {
            // The loop may be gone already when the program ends.
            let _ = proxy.send_event(WinitUserEvent::WakeUp);
        }
    }));
}

pub fn pace(
    mut settings: ResMut<WinitSettings>,
    pacing: Res<Pacing>,
    status: Res<RenderStatus>,
    denoiser: Res<Denoiser>,
    carrying: Res<Carrying>,
    toasts: Res<Toasts>,
    history: Res<History>,
    recovery: Option<Res<Recovery>>,
) {
    // A save advances by a slice in each frame, and so do the autosave, the copy of the film for the denoiser, and
    // carrying over.
    let is_copying = denoiser.is_copying() || recovery.is_some_and(|recovery| recovery.is_copying());
    let is_copying = is_copying || carrying.has_backlog();
    let in_use = !pacing.rests() || history.is_saving() || is_copying;
    let busy = matches!(
        status.state,
        RenderState::Loading | RenderState::Building | RenderState::Rendering
    );
    // Until every pixel has a sample, each frame has much that is new. Where many cores trace, their results leave no
    // rest between two frames.
    let settles = busy && status.samples == 0;
    let is_lively = in_use || !busy || settles || !pacing.draws_on_cpu;
    pacing.is_lively.store(is_lively, Ordering::Relaxed);
    let wait = match busy {
        _ if in_use => LIVELY,
        true if settles && !pacing.draws_on_cpu => LIVELY,
        true => SPARING,
        false => IDLE,
    };
    let wait = toasts.wait().map_or(wait, |toast| wait.min(toast));
    let mode = UpdateMode::reactive(wait);
    if settings.focused_mode != mode {
        settings.focused_mode = mode;
        settings.unfocused_mode = mode;
    }
}

/// Skips drawing to leave the cores to the tracer: on a software driver until an edit has something to show, and with
/// any driver while there is no input.
pub fn hold_back_frame(
    mut pacing: ResMut<Pacing>,
    picture: Res<Picture>,
    status: Res<RenderStatus>,
    frames: Res<FrameTimes>,
    mut events: MessageReader<WindowEvent>,
    screenshots: Query<(), With<Screenshot>>,
    mut cameras: Query<&mut Camera>,
) {
    let now = Instant::now();
    if events.read().count() > 0 {
        pacing.last_event = Some(now);
    }
    pacing.drawing = frames.last_frame().drawing.max(MEMORY * pacing.drawing);
    let is_new = picture.revision != pacing.drawn;
    if is_new {
        pacing.waiting_since = None;
    }
    let waits = pacing.waiting_since.is_some_and(|since| since.elapsed() < LONGEST_HOLD);
    let is_spared = screenshots.is_empty() && pacing.spares(now, &status);
    let draws = !(pacing.undrawn || pacing.draws_on_cpu && waits || is_spared);
    if draws {
        pacing.last_drawn = Some(now);
        pacing.drawn = picture.revision;
        pacing.waiting_since = None;
    }
    for mut camera in &mut cameras {
        if camera.is_active != draws {
            camera.is_active = draws;
        }
    }
}

/// Bevy does not hand on the type of the adapter's kind; its name is available.
fn is_software(adapter: &RenderAdapterInfo) -> bool {
    format!("{:?}", adapter.device_type) == "Cpu"
}
