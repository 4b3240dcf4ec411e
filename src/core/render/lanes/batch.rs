//! A batch of sixteen paths between vertices, which takes all of them from vertex to vertex.

use glam::{UVec2, Vec3};

use super::camera_rays::CameraRays;
use super::context::{Coherence, Context, Job, Samples, Travelled};
use super::vertices::{Met, Vertices};
use crate::accel::{Detail, Hit};
use crate::light::LightId;
use crate::math::lanes::{LANES, Vec3Lanes, each_lane, ones_in};
use crate::math::{PerLane, Ray};
use crate::render::observer::PathObserver;
use crate::render::path::PathSample;
use crate::render::path_state::{PathLanes, PathState};
use crate::render::scene::SurfaceSlot;
use crate::render::view::View;
use crate::sampling::Sampler;

/// The unfinished paths. Without `MEDIA` all space is empty, and the code for media is not compiled.
pub(super) struct PathBatch<'a, const MEDIA: bool> {
    /// The lanes that have a path, a bit per lane.
    pub active: u32,
    /// The paths; their rays are infinite except for those from the camera.
    pub(super) paths: PathLanes,
    pub(super) outputs: [Output; LANES],
    /// The hits of the rays, valid in the lanes of `traced`.
    pub(super) hits: [Option<Hit>; LANES],
    traced: u32,
    /// The current vertices of the paths, while they take a step.
    pub(super) vertices: Vertices<'a, MEDIA>,
}

/// The destination of a path's sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Output {
    /// Index of the job.
    pub job: usize,
    /// The weight as [`crate::render::view::CameraSample::weight`].
    weight: f32,
}

impl<'a, const MEDIA: bool> PathBatch<'a, MEDIA> {
    /// A batch without paths.
    pub fn new(view: &View) -> Self {
        let nowhere = PathState::new(
            Ray::new(Vec3::ZERO, Vec3::Z),
            Sampler::new(view.sequence, UVec2::ZERO, 0, view.seed),
            None,
        );
        Self {
            active: 0,
            paths: nowhere.splat(),
            outputs: [Output { job: 0, weight: 0.0 }; LANES],
            hits: [None; LANES],
            traced: 0,
            vertices: Vertices::new(),
        }
    }

    /// Starts new paths from the camera, in as many lanes as there are jobs for: the first of `jobs`, which are
    /// numbered from `number` on. Returns their number.
    pub fn begin(&mut self, context: &Context, jobs: &[Job], number: usize) -> usize {
        let count = jobs.len().min(LANES);
        let mut camera = CameraRays::new(context.view, &jobs[..count]);
        (context.view.sight).narrow_lanes(&context.scene.geometry, &mut camera.rays, (1 << count) - 1);
        let first = PathState::new(
            camera.rays.get(0),
            Sampler::gather_lane(&camera.samplers, 0),
            context.medium(),
        );
        self.paths = PathLanes {
            ray: camera.rays,
            sampler: camera.samplers,
            ..first.splat()
        };
        for (lane, output) in self.outputs.iter_mut().enumerate() {
            *output = Output {
                job: number + lane,
                weight: camera.weights[lane],
            };
        }
        self.active = (1 << count) - 1;
        self.traced = 0;
        count
    }

    /// Puts an unfinished path, that of a job, into a free lane.
    pub fn set(&mut self, lane: usize, path: &PathState, job: usize) {
        path.scatter_lane(&mut self.paths, lane);
        self.outputs[lane] = Output { job, weight: 1.0 };
        self.hits[lane] = None;
        self.traced &= !(1 << lane);
        self.active |= 1 << lane;
    }

    /// Whether the ray of a lane hits a surface from behind.
    pub fn meets_back(&self, lane: usize, context: &Context) -> bool {
        self.hits[lane].is_some_and(|hit| {
            let ray = self.paths.ray.get(lane);
            let point = context.scene.geometry.surface_in(&ray, &hit, Detail::Plain);
            point.geometric_normal.dot(ray.dir) > 0.0
        })
    }

    /// Moves the path that another batch has in the lane `theirs` to the free lane `lane`.
    pub fn move_lane_from(&mut self, lane: usize, other: &mut Self, theirs: usize) {
        // All fields are named, so that none is forgotten.
        let Self {
            active,
            paths,
            outputs,
            hits,
            traced,
            vertices: _,
        } = self;
        PathState::move_lane(paths, lane, &other.paths, theirs);
        outputs[lane] = other.outputs[theirs];
        hits[lane] = other.hits[theirs];
        bool::move_lane(traced, lane, &other.traced, theirs);
        *active |= 1 << lane;
        other.active &= !(1 << theirs);
    }

    /// Finishes the path of a lane with the result `sample`.
    fn finish(&mut self, lane: usize, sample: PathSample, samples: &mut Samples) {
        let Output { job, weight } = self.outputs[lane];
        samples.list[job] = (sample, weight);
        self.active &= !(1 << lane);
    }

    /// Records the light that was sampled from the vertices of `lanes`, if there are layers.
    pub(super) fn note_light(
        &self,
        lanes: u32,
        light: &[LightId; LANES],
        contribution: Vec3Lanes,
        samples: &mut Samples,
    ) {
        if samples.notes.is_some() {
            for lane in each_lane(lanes) {
                let taker = samples.observer(self.outputs[lane].job);
                taker
                    .into_iter()
                    .for_each(|mut taker| taker.add_sampled(light[lane], contribution.get(lane)));
            }
        }
    }

    /// Records that the surfaces at the vertices have scattered the paths, if there are layers.
    pub(super) fn note_scattering(&self, samples: &mut Samples) {
        if samples.notes.is_some() {
            for lane in each_lane(self.vertices.lanes) {
                let taker = samples.observer(self.outputs[lane].job);
                taker.into_iter().for_each(|mut taker| taker.add_scattering());
            }
        }
    }

    /// Finishes the path of a lane at its vertex.
    pub(super) fn finish_here(&mut self, lane: usize, samples: &mut Samples) {
        let (radiance, rays) = (self.paths.radiance.get(lane), self.paths.rays.as_array()[lane]);
        self.finish(lane, self.paths.record[lane].sample(radiance, rays), samples);
    }

    /// Traces the rays whose hits are unknown. Paths that hit nothing end; the results go to `samples`.
    #[inline(never)]
    pub fn trace(&mut self, coherence: Coherence, context: &Context, samples: &mut Samples) {
        let asked = self.active & !self.traced;
        if asked == 0 {
            return;
        }
        self.paths.rays += ones_in(asked);
        let hits = coherence.intersect(&context.scene.geometry, &self.paths.ray, asked);
        for lane in each_lane(asked) {
            self.hits[lane] = hits[lane];
            if context.settings.hide_emitters {
                self.pass_hidden_emitters(lane, context);
            }
            // A ray through a medium may still be scattered.
            if self.hits[lane].is_none() && self.medium(lane).is_none() {
                self.escape(lane, context, samples);
            }
        }
        self.traced = self.active;
    }

    /// The hits as [`PathState::behind_hidden_emitters`].
    #[inline(never)]
    fn pass_hidden_emitters(&mut self, lane: usize, context: &Context) {
        let mut path = PathState::gather_lane(&self.paths, lane);
        self.hits[lane] = path.behind_hidden_emitters(context.scene, context.settings, self.hits[lane]);
        path.scatter_lane(&mut self.paths, lane);
    }

    /// Lets the path of a lane leave the scene.
    pub(super) fn escape(&mut self, lane: usize, context: &Context, samples: &mut Samples) {
        let mut path = PathState::gather_lane(&self.paths, lane);
        let mut observer = samples.observer(self.outputs[lane].job);
        path.escape(context.scene, context.settings, &mut observer);
        self.finish(lane, path.sample(), samples);
    }

    /// Takes all paths to their next vertices and samples their next rays.
    #[inline(never)]
    pub fn step(&mut self, coherence: Coherence, context: &Context<'a>, samples: &mut Samples) {
        if self.active == 0 {
            return;
        }
        self.vertices.clear();
        let in_media = self.in_media();
        let travelled = match in_media {
            0 => Travelled::NOTHING,
            _ => self.travel(in_media, context),
        };
        self.vertices
            .find_meshes(context.scene, &self.hits, self.active & !in_media);
        for lane in each_lane(self.active) {
            match self.hits[lane] {
                hit if in_media >> lane & 1 == 1 => self.go_on(lane, hit, travelled, context, samples),
                Some(hit) => self.arrive(lane, hit, context, samples),
                None => debug_assert!(false, "a path that has left the scene has ended"),
            }
        }
        self.traced = 0;
        if self.vertices.lanes != 0 {
            self.scatter(coherence, context, samples);
        }
    }

    /// Takes the path of a lane to its hit. Its light is then handled in lanes, or else the path takes its whole step
    /// by itself.
    #[inline(always)]
    pub(super) fn arrive(&mut self, lane: usize, hit: Hit, context: &Context<'a>, samples: &mut Samples) {
        let slot = context.scene.slot(&hit);
        if MEDIA && slot.media.is_transition() {
            self.arrive_at_border(lane, hit, &slot, context, samples);
            return;
        }
        let ray = self.paths.ray.get(lane);
        match self.vertices.set_plain(lane, context.scene, &ray, &hit, &slot) {
            Some(met) => self.look(lane, &hit, &slot, &met, context, samples),
            None => self.arrive_elsewhere(lane, hit, &slot, context, samples),
        }
    }

    /// Takes a step at a surface whose model depends on more than the side seen.
    #[inline(never)]
    fn arrive_elsewhere(
        &mut self,
        lane: usize,
        hit: Hit,
        slot: &SurfaceSlot,
        context: &Context<'a>,
        samples: &mut Samples,
    ) {
        let ray = self.paths.ray.get(lane);
        if let Some(met) = self.vertices.set_other(lane, context.scene, &ray, &hit, slot) {
            self.look(lane, &hit, slot, &met, context, samples);
        } else {
            self.arrive_alone(lane, hit, context, samples);
        }
    }

    /// Takes the path of a lane through its whole step at the surface at `hit` by itself.
    #[inline(never)]
    pub(super) fn arrive_alone(&mut self, lane: usize, hit: Hit, context: &Context<'a>, samples: &mut Samples) {
        let mut path = PathState::gather_lane(&self.paths, lane);
        let mut observer = samples.observer(self.outputs[lane].job);
        let goes_on = path.advance_from(context.scene, context.settings, hit, &mut observer);
        self.set_or_finish(lane, path, goes_on, samples);
    }

    /// Takes the path of a lane through its whole step by itself, through a medium first.
    #[inline(never)]
    pub(super) fn advance_alone(
        &mut self,
        lane: usize,
        hit: Option<Hit>,
        context: &Context<'a>,
        samples: &mut Samples,
    ) {
        let mut path = PathState::gather_lane(&self.paths, lane);
        let mut observer = samples.observer(self.outputs[lane].job);
        let goes_on = path.advance(context.scene, context.settings, hit, &mut observer);
        self.set_or_finish(lane, path, goes_on, samples);
    }

    fn set_or_finish(&mut self, lane: usize, path: PathState, goes_on: bool, samples: &mut Samples) {
        if goes_on {
            path.scatter_lane(&mut self.paths, lane);
        } else {
            self.finish(lane, path.sample(), samples);
        }
    }

    /// Handles the emitters and features at the vertices. A path ends there if that was its last vertex.
    #[inline(always)]
    pub(super) fn look(
        &mut self,
        lane: usize,
        hit: &Hit,
        slot: &SurfaceSlot,
        met: &Met,
        context: &Context,
        samples: &mut Samples,
    ) {
        let (scene, settings) = (context.scene, context.settings);
        let depth = self.paths.depth.as_array()[lane];
        let is_last = settings.is_last(depth + 1 - self.paths.uncounted.as_array()[lane]);
        let mut observer = samples.observer(self.outputs[lane].job);
        observer.met(&self.paths.ray.get(lane), hit);
        if let Some(light) = slot.light {
            let mut path = PathState::gather_lane(&self.paths, lane);
            path.see_light(scene, settings, hit, light, &met.point, &mut observer);
            path.scatter_lane(&mut self.paths, lane);
        }
        let record = &mut self.paths.record[lane];
        if depth == 0 {
            record.meet(hit);
        }
        if record.wants_features(met.is_smooth, slot.light.is_some(), is_last) {
            let throughput = self.paths.throughput.get(lane);
            record.take_features(throughput, met.albedo, met.point.shading_normal, slot.light.is_some());
        }
        if is_last {
            self.vertices.lanes &= !(1 << lane);
            self.finish_here(lane, samples);
        }
    }
}
