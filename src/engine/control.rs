//! The requests of the application to the engine. Exposure, tone mapping and the shown layer of the film are not here,
//! since they need no rendering.

use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

use bevy::prelude::*;

use crate::render::visibility::sight::CutPlane;

/// The settings that say how, how much and how fast to render. Write a field only when its value differs, because every
/// change is handled once per frame.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct RenderControl {
    /// Whether rendering pauses. Existing samples stay.
    pub paused: bool,
    /// The samples per pixel to stop at; None is the sensor film's own `sample_count`. Raising it continues the
    /// picture, lowering it keeps the samples.
    pub target_samples: Option<u32>,
    /// The exact number of samples per pixel of the picture; None for no such demand. It replaces `target_samples`, and
    /// the limits of time and noise do not apply. A picture that has more samples, or whose passes are not those of an
    /// uninterrupted render of this number, starts again: equal scenes give equal bits, whatever was rendered before
    /// and however fast.
    pub exact_samples: Option<u32>,
    /// The seconds of rendering to stop at, without pauses; None is no limit. Like the samples it can be raised and
    /// lowered.
    pub time_limit: Option<f32>,
    /// The [`RenderStatus::noise`](super::RenderStatus::noise) to stop at; None is the sensor film's own
    /// `noise_target`, 0 is no limit.
    pub noise_target: Option<f32>,
    /// Whether noisier parts get more samples, see [`crate::render::noise::adaptive`]; None is the sensor film's own
    /// `adaptive`.
    pub adaptive: Option<bool>,
    /// The part of the film that gets samples, (0, 0) top left, (1, 1) bottom right, widened to whole tiles; a view
    /// that shows more than the film may have a part outside of it. None is the whole picture, as is a part outside of
    /// the picture. The rest keeps its samples.
    pub region: Option<Rect>,
    /// The number of the first sample, if the picture is a share of another one: nothing is shown around its region,
    /// and its film has the exact sums from which pictures are merged. It has to be a
    /// [cut](crate::render::passes::is_cut).
    pub share: Option<u32>,
    /// The fraction of the film's size that is rendered, in (0, 1].
    pub resolution_scale: f32,
    /// The fraction of that resolution that is rendered, in (0, 1], while the picture has to keep up with frequent
    /// changes.
    pub motion_scale: f32,
    /// The size in pixels that replaces the film's (before `resolution_scale`), as given on the command line.
    pub film_size_override: Option<UVec2>,
    /// The size in pixels of the area in which the picture is shown. Unless it is [filled](Self::filling), the picture
    /// gets no more pixels than fit there in its own proportions. None is no limit.
    pub view_size: Option<UVec2>,
    /// Whether the picture fills `view_size`, where that is wider or higher than the film.
    pub filling: Filling,
    /// Whether the picture has all of its pixels whatever `view_size` is. The engine resets it at any other change of
    /// the scene or the view.
    pub full_until_change: bool,
    /// The framing of the picture, whatever the film, `view_size` and `filling` say: the framing of a saved picture
    /// that rendering resumes. The engine resets it at any other change of the scene or the view.
    pub framing_until_change: Option<Framing>,
    /// The meaning of a pixel's value.
    pub view_mode: ViewMode,
    /// The surfaces that camera rays pass through; by default none.
    pub sight: SightControl,
    /// Whether the picture compares sampling strategies: the left third has bsdf sampling alone, the middle light
    /// sampling alone, the right both.
    pub strategy_split: bool,
    /// Whether `path` in a file means `auto`, as in a window. The file itself does not change.
    pub path_is_auto: bool,
    /// Whether the film keeps the light of each group of lights in a layer, for mixing.
    pub light_layers: bool,
    /// Whether pictures begin with their G-buffer, see [`RenderFilm::gbuffer`](super::RenderFilm::gbuffer).
    pub gbuffer: bool,
    /// Whether pictures keep their samples when only the strength of lights or the set of emitters changes. Where
    /// memory allows, the film keeps the light of each group of lights in a layer for that.
    pub lights_are_free: bool,
    /// The number of worker threads that trace rays; `app::threads` decides it.
    pub threads: NonZeroUsize,
    /// True with a window: every job begins with a coarse preview, acceleration structures are built in the background
    /// while the last picture stays, and meshes appear as they are loaded. False: rendering starts when the whole scene
    /// is loaded and built.
    pub interactive: bool,
    /// Whether to discard the samples and start again; the engine resets it.
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
            adaptive: None,
            region: None,
            share: None,
            resolution_scale: 1.0,
            motion_scale: 1.0,
            film_size_override: None,
            view_size: None,
            filling: Filling::None,
            full_until_change: false,
            framing_until_change: None,
            view_mode: ViewMode::Path,
            sight: SightControl::default(),
            strategy_split: false,
            path_is_auto: false,
            light_layers: false,
            gbuffer: false,
            lights_are_free: false,
            threads: std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN),
            interactive: false,
            restart_requested: false,
        }
    }
}

impl RenderControl {
    /// Resets the sizes that apply until the scene or the view changes.
    pub fn forget_size_until_change(&mut self) {
        (self.full_until_change, self.framing_until_change) = (false, None);
    }

    /// Demands all pixels of the film until the scene or the view changes.
    pub fn demand_full_until_change(&mut self) {
        (self.full_until_change, self.framing_until_change) = (true, None);
    }
}

/// The pixels and the frame of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Framing {
    /// The size of the picture at the current resolution in pixels.
    pub size: UVec2,
    /// The width and height of the picture in widths and heights of the film; 1 if it is the film.
    pub extent: Vec2,
}

/// Whether a picture fills the place where it is shown, and has all of the place's pixels, whatever the shape and the
/// size of the film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filling {
    /// The picture is the film.
    #[default]
    None,
    /// The picture shows the whole film and its surroundings, which get few samples. A film whose surroundings would be
    /// seen at an angle of more than 100 degrees is shown alone.
    AroundFilm,
    /// The picture shows the film and its surroundings as one, and less of both than would be seen at 100 degrees.
    Free,
}

/// The meaning of a pixel's value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ViewMode {
    /// Radiance by path tracing (albedo, normal and depth come with it).
    #[default]
    Path,
    /// The number of nodes of the acceleration structure that the camera ray visits.
    BvhSteps,
    /// The optical depth of the media before the first surface.
    OpticalDepth,
    /// The irradiance on the first surface.
    Illuminance,
    /// The first surface in its own colour, lit from the camera.
    Headlight,
    /// The first surface in grey, lit from the camera.
    Clay,
}

/// The surfaces that camera rays pass through, as [`Sight`](crate::render::visibility::sight::Sight), with shapes by
/// their entities.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SightControl {
    /// Whether rays pass surfaces that they meet from behind.
    pub passes_backs: bool,
    /// A plane; rays pass all surfaces on its outer side.
    pub cut: Option<CutPlane>,
    /// The only shapes that are visible. If it is empty, all are.
    pub only: Vec<Entity>,
}

/// The time at which the user's input of this frame arrived, for measuring latency. The engine takes it every frame;
/// without it the engine uses the time when it notices the change.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct InputStamp(pub Option<Instant>);

/// Keeps the workers from their next work item while a short task needs the cores.
#[derive(Resource, Clone, Debug, Default)]
pub struct Gate(Arc<AtomicUsize>);

impl Gate {
    /// Closes the gate until the guard is dropped or [opened](ClosedGate::open).
    pub fn close(&self) -> ClosedGate {
        self.0.fetch_add(1, Ordering::AcqRel);
        ClosedGate {
            gate: self.clone(),
            is_open: AtomicBool::new(false),
        }
    }

    /// Whether a guard keeps the gate closed.
    pub(super) fn is_closed(&self) -> bool {
        self.0.load(Ordering::Acquire) > 0
    }
}

/// A gate that is closed.
#[derive(Debug)]
pub struct ClosedGate {
    gate: Gate,
    is_open: AtomicBool,
}

impl ClosedGate {
    /// Lets the workers continue. Further calls do nothing.
    pub fn open(&self) {
        if !self.is_open.swap(true, Ordering::AcqRel) {
            self.gate.0.fetch_sub(1, Ordering::AcqRel);
        }
    }
}

impl Drop for ClosedGate {
    fn drop(&mut self) {
        self.open();
    }
}

/// A function that worker threads call when there are results to collect, so that a sleeping event loop can run a
/// frame: at once at the end of a preview and of a job, and rate limited in between.
#[derive(Resource, Clone, Default)]
pub struct WakeUp(pub Option<Arc<dyn Fn() + Send + Sync>>);
