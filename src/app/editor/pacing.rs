//! How often the window is drawn: often while the picture changes, hardly ever when nothing does. Input and results wake it at once.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy::render::renderer::RenderAdapterInfo;
use bevy::winit::{EventLoopProxyWrapper, UpdateMode, WinitSettings, WinitUserEvent};

use super::denoiser::Denoiser;
use super::model::DenoiserState;
use super::state::EditorState;
use crate::engine::{InputStamp, RenderState, RenderStatus, WakeUp};

const LIVELY: Duration = Duration::from_millis(16);
/// A software driver draws with the cores that trace rays: once the picture only becomes less noisy it is shown less often.
const SPARING: Duration = Duration::from_millis(100);
const IDLE: Duration = Duration::from_millis(500);
/// How long after a command the window stays lively.
const AFTER_INPUT: Duration = Duration::from_millis(500);
/// Samples from which on a picture only becomes less noisy.
const SETTLED_SAMPLES: u32 = 4;

/// Lets worker threads wake the event loop.
pub fn connect_wake_up(proxy: Res<EventLoopProxyWrapper>, mut wake_up: ResMut<WakeUp>) {
    let proxy = (**proxy).clone();
    // The loop may be gone already when the program ends.
    wake_up.0 = Some(Arc::new(move || {
        let _ = proxy.send_event(WinitUserEvent::WakeUp);
    }));
}

pub fn pace(
    mut settings: ResMut<WinitSettings>,
    mut last_input: Local<Option<Instant>>,
    stamp: Res<InputStamp>,
    status: Res<RenderStatus>,
    denoiser: Res<Denoiser>,
    state: Res<EditorState>,
    adapter: Option<Res<RenderAdapterInfo>>,
) {
    if stamp.0.is_some() {
        *last_input = stamp.0;
    }
    let on_cpu = adapter.is_some_and(|adapter| is_software(&adapter));
    let in_use = last_input.is_some_and(|at| at.elapsed() < AFTER_INPUT);
    let busy = matches!(
        status.state,
        RenderState::Loading | RenderState::Building | RenderState::Rendering
    );
    let wait = if in_use || (busy && !(on_cpu && status.samples >= SETTLED_SAMPLES)) {
        LIVELY
    } else if busy || denoiser.state() == DenoiserState::Running || state.message().is_some() {
        SPARING
    } else {
        IDLE
    };
    let mode = UpdateMode::reactive(wait);
    if settings.focused_mode != mode {
        settings.focused_mode = mode;
        settings.unfocused_mode = mode;
    }
}

/// The type of the adapter's kind is not among what Bevy hands on; its name is.
fn is_software(adapter: &RenderAdapterInfo) -> bool {
    format!("{:?}", adapter.device_type) == "Cpu"
}
