//! Sixteen paths traced side by side, each from one vertex to the next in every step: work that most of them share is
//! done for all at once, in vectors.
//!
//! Surfaces are looked up one by one. If a surface has one of the models of [`crate::shading::lanes`], the rest is done
//! in lanes; a model below nested maps is evaluated by itself, but its random numbers, lights and shadow rays are in
//! lanes. Where several models are mixed, or light passes straight through, the path takes its whole step by itself, by
//! [`PathState::advance`]. Scatterings in media are vertices like those on surfaces. A finished path gives its lane to
//! the next one. The results equal those of one path at a time up to rounding.
//!
//! [`PathState::advance`]: super::path_state::PathState::advance

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use self::batch::PathBatch;
use self::context::{Coherence, Context, STEPS_TO_CANCEL};
use super::bidirectional::arrivals;
use super::gathering::{Arrivals, Arrived};
use super::guide::{Field, PhotonPaths};
use super::layers::LayerNotes;
use super::path_state::PathState;
use super::scene::RenderScene;
use super::view::{PathSettings, Strategy, View};
use crate::color::Rgb;
use crate::math::lanes::{LANES, each_lane};
use crate::render::path::PathSample;

mod batch;
mod camera_rays;
mod context;
mod guided;
mod light_samples;
mod media;
mod scatter;
mod vertices;

pub(super) use self::context::{Job, Samples};

/// Traces all `jobs`, whose samples and their weights are in the same order. None if `cancel` was set in the meantime.
pub(super) fn trace<'v>(
    scene: &RenderScene,
    view: &'v View,
    settings: &PathSettings,
    jobs: &[Job],
    cancel: &AtomicBool,
) -> Option<Samples<'v>> {
    let field = field(scene, view, settings, cancel)?;
    let context = Context {
        scene,
        view,
        settings,
        sole_light: scene.lights.sole(),
        field: field.as_deref(),
    };
    let mut samples = Samples::new(view, jobs.len());
    let has_media = settings.media && !scene.media.is_empty();
    let is_done = match has_media {
        true => Paths::<true>::new(view, jobs).trace(&context, cancel, &mut samples),
        false => Paths::<false>::new(view, jobs).trace(&context, cancel, &mut samples),
    };
    is_done.then_some(samples)
}

/// The guide of paths, which is learnt if necessary; the inner None means no guide, or no light to guide paths. None if
/// `cancel` was set in the meantime.
pub(super) fn field(
    scene: &RenderScene,
    view: &View,
    settings: &PathSettings,
    cancel: &AtomicBool,
) -> Option<Option<Arc<Field>>> {
    let Some(guide) = view.guide.as_ref().filter(|_| is_guided(scene, settings)) else {
        return Some(None);
    };
    let paths = PhotonPaths {
        longest_path: settings.longest_path(),
        rr_depth: settings.rr_depth,
    };
    let trace = |numbers: Range<u32>| arrivals(scene, view, numbers);
    guide.field(scene, paths, trace, cancel)
}

/// Whether a guide helps: not for paths without a density of directions, in media, or for direct light alone.
fn is_guided(scene: &RenderScene, settings: &PathSettings) -> bool {
    let has_media = settings.media && !scene.media.is_empty();
    !has_media && settings.strategy == Strategy::Mis && settings.longest_path() > 2
}

/// Traces paths that have left a vertex, with the results of tracing them one by one. Paths without throughput have
/// ended. `notes` have the light that they have found before. None if `cancel` was set in the meantime.
pub(super) fn trace_begun(
    scene: &RenderScene,
    view: &View,
    settings: &PathSettings,
    begun: &[PathState],
    notes: Option<LayerNotes>,
    cancel: &AtomicBool,
) -> Option<Arrivals> {
    let context = Context {
        scene,
        view,
        settings,
        sole_light: scene.lights.sole(),
        field: None,
    };
    match settings.media && !scene.media.is_empty() {
        true => trace_lanes::<true>(&context, begun, notes, cancel),
        false => trace_lanes::<false>(&context, begun, notes, cancel),
    }
}

/// Paths come from the camera sixteen at a time, of neighbouring samples. Up to their first bounce they stay together
/// and their rays are coherent. Afterwards each goes to any free lane, since some end sooner than others.
struct Paths<'a, const MEDIA: bool> {
    jobs: &'a [Job],
    /// The number of jobs that have been started.
    begun: usize,
    /// The paths that have left their first vertex and wait for a lane.
    first: PathBatch<'a, MEDIA>,
    later: PathBatch<'a, MEDIA>,
}

impl<'a, const MEDIA: bool> Paths<'a, MEDIA> {
    fn new(view: &View, jobs: &'a [Job]) -> Self {
        Self {
            jobs,
            begun: 0,
            first: PathBatch::new(view),
            later: PathBatch::new(view),
        }
    }

    /// Traces all jobs. False if `cancel` was set in the meantime.
    fn trace(mut self, context: &Context<'a>, cancel: &AtomicBool, samples: &mut Samples) -> bool {
        loop {
            if cancel.load(Ordering::Relaxed) {
                return false;
            }
            for _ in 0..STEPS_TO_CANCEL {
                self.later.trace(Coherence::Incoherent, context, samples);
                self.begin(context, samples);
                if self.later.active == 0 {
                    return true;
                }
                self.later.step(Coherence::Incoherent, context, samples);
            }
        }
    }

    /// Gives every free lane a path, until all jobs are started.
    fn begin(&mut self, context: &Context<'a>, samples: &mut Samples) {
        const ALL: u32 = (1 << LANES) - 1;
        for lane in each_lane(!self.later.active & ALL) {
            while self.first.active == 0 {
                let jobs = &self.jobs[self.begun..];
                if jobs.is_empty() {
                    return;
                }
                self.begun += self.first.begin(context, jobs, self.begun);
                self.first.trace(Coherence::Coherent, context, samples);
                self.first.step(Coherence::Coherent, context, samples);
                self.first.trace(Coherence::Incoherent, context, samples);
            }
            let next = self.first.active.trailing_zeros() as usize % LANES;
            self.later.move_lane_from(lane, &mut self.first, next);
        }
    }
}

/// All lanes.
const ALL: u32 = (1 << LANES) - 1;

/// See [`trace_begun`].
fn trace_lanes<const MEDIA: bool>(
    context: &Context,
    begun: &[PathState],
    notes: Option<LayerNotes>,
    cancel: &AtomicBool,
) -> Option<Arrivals> {
    let mut batch = PathBatch::<MEDIA>::new(context.view);
    let mut samples = Samples {
        list: vec![(PathSample::default(), 1.0); begun.len()],
        notes,
    };
    let mut backs = vec![false; begun.len()];
    let mut waiting = begun.iter().enumerate();
    loop {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        for _ in 0..STEPS_TO_CANCEL {
            let mut new = 0;
            for lane in each_lane(!batch.active & ALL) {
                let next = waiting.find(|(job, path)| {
                    let goes_on = path.throughput != Rgb::ZERO;
                    samples.list[*job].0 = path.sample();
                    goes_on
                });
                let Some((job, path)) = next else {
                    break;
                };
                batch.set(lane, path, job);
                new |= 1 << lane;
            }
            if batch.active == 0 {
                let arrived = |((sample, _), meets_back): (&(PathSample, f32), bool)| Arrived {
                    light: sample.radiance,
                    meets_back,
                    rays: sample.rays,
                };
                return Some(Arrivals {
                    samples: samples.list.iter().zip(backs).map(arrived).collect(),
                    groups: samples.notes.map_or_else(Vec::new, LayerNotes::into_groups),
                });
            }
            batch.trace(Coherence::Incoherent, context, &mut samples);
            for lane in each_lane(new & batch.active) {
                backs[batch.outputs[lane].job] = batch.meets_back(lane, context);
            }
            batch.step(Coherence::Incoherent, context, &mut samples);
        }
    }
}
