//! Where sixteen samples begin.

use super::Job;
use crate::accel::RayLanes;
use crate::math::lanes::{LANES, Lanes, WordLanes};
use crate::render::filter::PixelFilter;
use crate::render::view::View;
use crate::sampling::lanes::SamplerLanes;

/// [`View::camera_sample`] in lanes.
pub(super) struct CameraRays {
    pub rays: RayLanes,
    pub weights: [f32; LANES],
    pub samplers: SamplerLanes,
}

impl CameraRays {
    /// Of at most sixteen jobs: in lanes with the box filter and a pinhole, else one by one.
    pub fn new(view: &View, jobs: &[Job]) -> Self {
        let (mut x, mut y, mut index) = (WordLanes::ZERO, WordLanes::ZERO, WordLanes::ZERO);
        for (lane, job) in jobs.iter().enumerate() {
            x.as_mut_array()[lane] = job.pixel.x;
            y.as_mut_array()[lane] = job.pixel.y;
            index.as_mut_array()[lane] = job.index;
        }
        let samplers = SamplerLanes::of_pixels(view.sequence, [x, y], index, view.seed);
        let mut camera = Self {
            rays: RayLanes::NOWHERE,
            weights: [1.0; LANES],
            samplers,
        };
        if view.filter == PixelFilter::Box {
            let half = Lanes::splat(0.5);
            let place = camera.samplers.at_2d(WordLanes::ZERO).map(|u| u - half);
            let film = |pixel: WordLanes, offset: Lanes, size: u32| {
                let pixel = Lanes::from_i32x16(bytemuck::cast(pixel));
                (pixel + half + offset) / Lanes::splat(size as f32)
            };
            let film = [film(x, place[0], view.width), film(y, place[1], view.height)];
            if let Some(rays) = view.camera.pinhole_rays(film) {
                camera.rays = rays;
                return camera;
            }
        }
        for (lane, job) in jobs.iter().enumerate() {
            let sample = view.camera_sample(job.pixel, job.index);
            camera.rays.set(lane, &sample.ray);
            camera.weights[lane] = sample.weight;
        }
        camera
    }
}
