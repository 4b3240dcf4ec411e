//! Records the paths of a pixel with all decisions along them, step by step, to be drawn and read.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use glam::{UVec2, Vec3};

use super::bidirectional::{Techniques, Tracer};
use super::observer::{Bounce, Glow, Joined, MetEmitter, PathEnd, PathObserver, PathVertex, SampledLight};
use super::scene::RenderScene;
use super::splats::Splat;
use super::tracer::render_sample;
use super::view::View;
use crate::color::Rgb;
use crate::math::Ray;

/// One sample of a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedPath {
    /// Index of the sample.
    pub sample: u32,
    /// The first ray, in world space.
    pub camera_ray: Ray,
    /// The surfaces along the path, the one nearest to the camera first.
    pub vertices: Vec<RecordedVertex>,
    /// The light of media that the path has gone through, each with the number of its vertices before.
    pub glows: Vec<(usize, Glow)>,
    /// Emitters hit at infinity, in the direction of the last bounce or of the camera ray.
    pub escaped_to: Vec<MetEmitter>,
    /// The reason why the path ended after its last vertex.
    pub end: PathEnd,
    /// The light path with which its vertices were joined, from the light on, in world space; empty without one.
    pub light_path: Vec<Vec3>,
    /// The light that the light path has sent to the lens.
    pub splats: Vec<Splat>,
    /// The sum of the contributions to its own pixel.
    pub radiance: Rgb,
    /// The weight of the radiance in its pixel, by the filter; 1 on average.
    pub filter_weight: f32,
}

/// A vertex of the path, with the decisions made there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordedVertex {
    /// The point at which the path was scattered.
    pub place: PathVertex,
    /// The surface's own light.
    pub met: Option<MetEmitter>,
    /// The light that was sampled from here; None if none was.
    pub sampled: Option<SampledLight>,
    /// The join with the light path; None without a contribution.
    pub joined: Option<Joined>,
    /// The continuation; None if the path ended.
    pub bounce: Option<Bounce>,
}

/// The paths of samples `samples` of a pixel, exactly as in the picture; empty where the view traces no paths. Photons
/// are ignored: for [`Integrator::Merging`](super::view::Integrator::Merging) the paths are those of bidirectional path
/// tracing.
pub fn record_paths(scene: &RenderScene, view: &View, pixel: UVec2, samples: Range<u32>) -> Vec<RecordedPath> {
    if view.path_settings(pixel).is_none() {
        return Vec::new();
    }
    let mut tracer = Techniques::of(view).and_then(|(settings, techniques)| {
        let techniques = Techniques {
            merging: None,
            ..techniques
        };
        Tracer::new(
            scene,
            view,
            settings,
            techniques,
            samples.clone(),
            &AtomicBool::new(false),
        )
    });
    let mut record = |index| {
        let mut recorder = Recorder::default();
        let (sample, filter_weight) = match &mut tracer {
            Some(tracer) => tracer.sample(pixel, index, &mut recorder),
            None => render_sample(scene, view, pixel, index, &mut recorder),
        };
        let tracer = tracer.as_mut();
        let light_path = tracer.as_ref().map(|tracer| tracer.light_path().collect());
        RecordedPath {
            sample: index,
            camera_ray: view.camera_sample(pixel, index).ray,
            vertices: recorder.vertices,
            glows: recorder.glows,
            escaped_to: recorder.escaped_to,
            end: recorder.end,
            light_path: light_path.unwrap_or_default(),
            splats: tracer.map(|tracer| tracer.take_splats().list).unwrap_or_default(),
            radiance: sample.radiance,
            filter_weight,
        }
    };
    samples.map(&mut record).collect()
}

#[derive(Default)]
struct Recorder {
    vertices: Vec<RecordedVertex>,
    glows: Vec<(usize, Glow)>,
    escaped_to: Vec<MetEmitter>,
    end: PathEnd,
}

impl PathObserver for Recorder {
    fn vertex(&mut self, vertex: &PathVertex) {
        self.vertices.push(RecordedVertex {
            place: *vertex,
            met: None,
            sampled: None,
            joined: None,
            bounce: None,
        });
    }

    fn emitted(&mut self, glow: &Glow) {
        self.glows.push((self.vertices.len(), *glow));
    }

    fn emitter_met(&mut self, met: &MetEmitter) {
        match self.vertices.last_mut() {
            // A path that has left its last vertex is at infinity.
            Some(vertex) if vertex.bounce.is_none() => vertex.met = Some(*met),
            _ => self.escaped_to.push(*met),
        }
    }

    fn light_sampled(&mut self, sampled: &SampledLight) {
        if let Some(vertex) = self.vertices.last_mut() {
            vertex.sampled = Some(*sampled);
        }
    }

    fn joined(&mut self, joined: &Joined) {
        if let Some(vertex) = self.vertices.last_mut() {
            vertex.joined = Some(*joined);
        }
    }

    fn bounced(&mut self, bounce: &Bounce) {
        if let Some(vertex) = self.vertices.last_mut() {
            vertex.bounce = Some(*bounce);
        }
    }

    fn ended(&mut self, end: PathEnd) {
        self.end = end;
    }
}
