//! Traces samples of pixels by the method that a view needs: in lanes, bidirectionally, or one by one.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::UVec2;

use super::bidirectional;
use super::borders::{headlight, optical_depth};
use super::illuminance;
use super::lanes::{self, Job};
use super::layers::{LayerNotes, PixelLayers};
use super::observer::PathObserver;
use super::path::{PathSample, trace_path};
use super::scene::RenderScene;
use super::splats::TileSplats;
use super::view::{PathSettings, Shown, View};
use crate::accel::TraversalStats;
use crate::color::Rgb;

/// The method for the samples of a tile, chosen once for all of them.
pub(super) enum Tracer {
    /// Sixteen paths side by side, if all paths have the same settings.
    Lanes(PathSettings),
    /// One camera path and one light path at a time.
    Bidirectional(PathSettings, bidirectional::Techniques),
    /// Irradiance at first hits, in lanes.
    Illuminance,
    /// One path at a time, where settings differ between pixels or no paths are traced.
    OneByOne,
}

impl Tracer {
    pub fn of(view: &View) -> Self {
        if let Some((settings, techniques)) = bidirectional::Techniques::of(view) {
            return Self::Bidirectional(settings, techniques);
        }
        match view.shown {
            Shown::Radiance => Self::Lanes(view.integrator.settings()),
            Shown::Illuminance => Self::Illuminance,
            _ => Self::OneByOne,
        }
    }

    /// The method for a preview. So few samples have too few splats, so camera paths find all light.
    pub fn of_preview(view: &View) -> Self {
        match Self::of(view) {
            Self::Bidirectional(settings, _) => Self::Lanes(settings),
            tracer => tracer,
        }
    }

    /// The samples of `jobs`. None if cancelled.
    pub fn trace<'a>(
        &self,
        scene: &'a RenderScene,
        view: &'a View,
        jobs: impl Iterator<Item = Job>,
        cancel: &AtomicBool,
    ) -> Option<Traced<'a>> {
        let mut traced = Traced {
            scene,
            view,
            from_lanes: None,
            bidirectional: None,
            notes: None,
            given: 0,
        };
        match *self {
            Self::Lanes(settings) => {
                let jobs: Vec<Job> = jobs.collect();
                let lanes = lanes::trace(scene, view, &settings, &jobs, cancel)?;
                traced.from_lanes = Some(lanes.list.into_iter());
                traced.notes = lanes.notes;
            }
            _ if cancel.load(Ordering::Relaxed) => return None,
            Self::Illuminance => {
                let jobs: Vec<Job> = jobs.collect();
                traced.from_lanes = Some(illuminance::trace(scene, view, &jobs, cancel)?.into_iter());
            }
            Self::Bidirectional(settings, techniques) => {
                let indices = jobs.map(|job| job.index);
                traced.notes = LayerNotes::new(view, 1);
                traced.bidirectional = Some(bidirectional::Tracer::new(
                    scene, view, settings, techniques, indices, cancel,
                )?);
            }
            Self::OneByOne => traced.notes = LayerNotes::new(view, 1),
        }
        Some(traced)
    }
}

/// An iterator over samples: traced in lanes beforehand, or one by one when needed.
pub(super) struct Traced<'a> {
    scene: &'a RenderScene,
    view: &'a View,
    from_lanes: Option<std::vec::IntoIter<(PathSample, f32)>>,
    bidirectional: Option<bidirectional::Tracer<'a>>,
    /// The notes for layers: of all samples from lanes, or else of the last one.
    notes: Option<LayerNotes<'a>>,
    /// The number of samples from lanes already returned.
    given: usize,
}

impl Traced<'_> {
    /// The next sample and the weight of its light; `job` is the next of the list.
    pub fn next(&mut self, job: Job) -> (PathSample, f32) {
        if let Some(sample) = self.from_lanes.as_mut().and_then(Iterator::next) {
            self.given += 1;
            return sample;
        }
        self.notes.iter_mut().for_each(LayerNotes::clear);
        let mut observer = self.notes.as_mut().map(|notes| notes.of(0));
        if let Some(tracer) = &mut self.bidirectional {
            return tracer.sample(job.pixel, job.index, &mut observer);
        }
        render_sample(self.scene, self.view, job.pixel, job.index, &mut observer)
    }

    /// Moves the splats to `splats`.
    pub fn take_splats(&mut self, splats: &mut TileSplats) {
        if let Some(tracer) = &mut self.bidirectional {
            splats.append(tracer.take_splats());
        }
    }

    /// Adds the notes of the last sample, that of `job`, to the layers of its pixel.
    pub fn add_layers(&self, job: Job, sample: &PathSample, weight: f32, layers: &mut PixelLayers) {
        if let Some(notes) = &self.notes {
            layers.add(job, sample, weight, notes, self.given.saturating_sub(1));
        }
    }
}

/// A sample and the weight of its light.
pub(super) fn render_sample(
    scene: &RenderScene,
    view: &View,
    pixel: UVec2,
    index: u32,
    observer: &mut impl PathObserver,
) -> (PathSample, f32) {
    let camera = view.camera_sample(pixel, index);
    let ray = view.sight.narrow(&scene.geometry, camera.ray);
    let sample = match (view.path_settings(pixel), view.shown) {
        (Some(settings), _) => trace_path(scene, &settings, ray, camera.sampler, view.medium, observer),
        (None, Shown::Illuminance) => {
            let alone = illuminance::trace(scene, view, &[Job { pixel, index }], &AtomicBool::new(false));
            let sample = alone.and_then(|mut alone| alone.pop());
            sample.map_or_else(PathSample::default, |(sample, _)| sample)
        }
        (None, Shown::OpticalDepth) => optical_depth(scene, &ray, view.medium),
        (None, Shown::BvhSteps) => {
            let mut stats = TraversalStats::default();
            let hit = scene.geometry.intersect_counting(&ray, &mut stats);
            PathSample {
                radiance: Rgb::splat(stats.total() as f32),
                first_hit: hit,
                rays: 1,
                ..PathSample::default()
            }
        }
        (None, shown) => headlight(scene, &ray, shown == Shown::Clay),
    };
    if let (None, Some(hit)) = (view.path_settings(pixel), &sample.first_hit) {
        observer.met(&ray, hit);
    }
    (sample, camera.weight)
}
