//! The requests of the application to the engine. Exposure, tone mapping and the shown layer of the film are not here, since they need no
//! rendering.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::time::Instant;

use bevy::prelude::*;

/// How, how much and how fast to render. Write a field only when its value differs: a change is looked at once per frame.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct RenderControl {
    /// Whether no new samples are made. Those that exist stay.
    pub paused: bool,
    /// Samples per pixel to stop at; None is the sensor film's own `sample_count`. Raising it continues the picture, lowering it keeps
    /// what is there.
    pub target_samples: Option<u32>,
    /// The exact number of samples per pixel of the picture; None is no such demand. It takes the place of `target_samples`, and the limits of time
    /// and noise do not count. A picture that has more samples, or that was not divided into the passes of an uninterrupted render of so many
    /// samples, is begun anew: equal scenes give equal bits, whatever was rendered before and however fast.
    pub exact_samples: Option<u32>,
    /// Seconds of rendering to stop at, pauses not counted; None is no limit. Like the samples it can be raised and lowered.
    pub time_limit: Option<f32>,
    /// [`RenderStatus::noise`](super::RenderStatus::noise) to stop at; None is no limit.
    pub noise_target: Option<f32>,
    /// The part of the picture that gets samples, (0, 0) top left, (1, 1) bottom right, widened to whole tiles; None is all of it, as
    /// is a part outside of the picture. The rest keeps what it has.
    pub region: Option<Rect>,
    /// Fraction of the film's size that is rendered, in (0, 1].
    pub resolution_scale: f32,
    /// The fraction of that resolution that is rendered for now, in (0, 1], while the picture has to keep up with frequent changes.
    pub motion_scale: f32,
    /// Size in pixels that replaces the film's (before `resolution_scale`), as given on the command line.
    pub film_size_override: Option<UVec2>,
    /// What the value of a pixel is.
    pub view_mode: ViewMode,
    /// Show what each way of finding light does: the left third of the picture by bsdf sampling alone, the middle by light sampling
    /// alone, the right by both.
    pub strategy_split: bool,
    /// Keep the light of each group of lights in a layer of the film, for mixing.
    pub light_layers: bool,
    /// Worker threads that trace rays; decided by `app::threads`.
    pub threads: NonZeroUsize,
    /// True with a window: every job begins with a coarse preview, acceleration structures are built in the background while the last
    /// picture stays, and meshes appear as they are loaded. False: rendering starts when everything is loaded and built.
    pub interactive: bool,
    /// Throw the samples away and begin anew; the engine takes it back.
    pub restart_requested: bool,
}

impl Default for RenderControl {
    fn default() -> Self {
        Self {
            paused: false,
            target_samples: None,
            exact_samples: None,
            time_limit: None,
            noise_target: None,
            region: None,
            resolution_scale: 1.0,
            motion_scale: 1.0,
            film_size_override: None,
            view_mode: ViewMode::Path,
            strategy_split: false,
            light_layers: false,
            threads: std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN),
            interactive: false,
            restart_requested: false,
        }
    }
}

/// The meaning of a pixel's value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ViewMode {
    /// Radiance by path tracing (albedo, normal and depth come with it).
    #[default]
    Path,
    /// The number of nodes of the acceleration structure that the camera ray visits.
    BvhSteps,
}

/// The time at which the user's input of this frame arrived, from which the latency log counts. The engine takes it every frame; without it the
/// engine uses the time when it notices the change.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct InputStamp(pub Option<Instant>);

/// Called by worker threads when there is something to collect, so that an event loop that sleeps can run a frame: at the end of a
/// preview and of a job at once, in between rate limited.
#[derive(Resource, Clone, Default)]
pub struct WakeUp(pub Option<Arc<dyn Fn() + Send + Sync>>);
