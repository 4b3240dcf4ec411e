//! Samples about to begin: the camera rays of sixteen at once.

use super::Job;
use crate::accel::RayLanes;
use crate::math::lanes::{LANES, Lanes, WordLanes};
use crate::render::filter::PixelFilter;
use crate::render::view::{CameraSample, View};
use crate::sampling::lanes::SamplerLanes;

/// Camera samples, to be taken one after the other.
pub(super) struct Ready {
    rays: RayLanes,
    weights: [f32; LANES],
    samplers: SamplerLanes,
    next: usize,
    count: usize,
}

impl Ready {
    pub fn new(view: &View) -> Self {
        Self {
            rays: RayLanes::NOWHERE,
            weights: [1.0; LANES],
            samplers: SamplerLanes::new(view.sequence),
            next: 0,
            count: 0,
        }
    }

    /// The next sample; `jobs` are those that have not been taken, itself the first.
    #[inline(always)]
    pub fn take(&mut self, view: &View, jobs: &[Job]) -> Option<CameraSample> {
        if self.next == self.count && !jobs.is_empty() {
            self.prepare(view, &jobs[..jobs.len().min(LANES)]);
        }
        let lane = self.next;
        (lane < self.count).then(|| {
            self.next += 1;
            CameraSample {
                ray: self.rays.get(lane),
                weight: self.weights[lane],
                sampler: self.samplers.get(lane),
            }
        })
    }

    /// As [`View::camera_sample`]: in lanes with the box filter and a pinhole, else one by one.
    fn prepare(&mut self, view: &View, jobs: &[Job]) {
        (self.next, self.count) = (0, jobs.len());
        let (mut x, mut y, mut index) = (WordLanes::ZERO, WordLanes::ZERO, WordLanes::ZERO);
        for (lane, job) in jobs.iter().enumerate() {
            x.as_mut_array()[lane] = job.pixel.x;
            y.as_mut_array()[lane] = job.pixel.y;
            index.as_mut_array()[lane] = job.index;
        }
        self.samplers = SamplerLanes::of_pixels(view.sequence, [x, y], index, view.seed);
        if view.filter == PixelFilter::Box {
            let half = Lanes::splat(0.5);
            let place = self.samplers.at_2d(WordLanes::ZERO).map(|u| u - half);
            let film = |pixel: WordLanes, offset: Lanes, size: u32| {
                let pixel = Lanes::from_i32x16(bytemuck::cast(pixel));
                (pixel + half + offset) / Lanes::splat(size as f32)
            };
            let film = [film(x, place[0], view.width), film(y, place[1], view.height)];
            if let Some(rays) = view.camera.pinhole_rays(film) {
                self.rays = rays;
                return;
            }
        }
        for (lane, job) in jobs.iter().enumerate() {
            let sample = view.camera_sample(job.pixel, job.index);
            self.rays.set(lane, &sample.ray);
            self.weights[lane] = sample.weight;
        }
    }
}
