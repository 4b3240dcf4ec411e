//! The start of sixteen samples.

use glam::Vec2;

use super::context::Job;
use crate::accel::RayLanes;
use crate::math::lanes::{LANES, Lanes, WordLanes};
use crate::render::dimensions::{FILTER, LENS};
use crate::render::filter::PixelFilter;
use crate::render::view::View;
use crate::sampling::lanes::SamplerLanes;

/// The camera rays of [`View::camera_sample`] in lanes.
pub(super) struct CameraRays {
    pub rays: RayLanes,
    pub weights: [f32; LANES],
    pub samplers: SamplerLanes,
}

impl CameraRays {
    /// The camera rays of at most sixteen jobs.
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
        let place = camera.samplers.at_2d(WordLanes::splat(FILTER));
        let offset = match &view.filter {
            PixelFilter::Box => place.map(|u| u - Lanes::splat(0.5)),
            filter => {
                let mut offset = [Lanes::ZERO; 2];
                for lane in 0..jobs.len() {
                    let sample = filter.sample(pair(place, lane));
                    offset[0].as_mut_array()[lane] = sample.offset.x;
                    offset[1].as_mut_array()[lane] = sample.offset.y;
                    camera.weights[lane] = sample.weight;
                }
                offset
            }
        };
        let film = |pixel: WordLanes, offset: Lanes, size: u32| {
            let pixel = Lanes::from_i32x16(bytemuck::cast(pixel));
            (pixel + Lanes::splat(0.5) + offset) / Lanes::splat(size as f32)
        };
        let film = [film(x, offset[0], view.width), film(y, offset[1], view.height)];
        camera.rays = view.camera.pinhole_rays(film).unwrap_or_else(|| {
            let lens = camera.samplers.at_2d(WordLanes::splat(LENS));
            let mut rays = RayLanes::NOWHERE;
            for lane in 0..jobs.len() {
                rays.set(lane, &view.camera.ray(pair(film, lane), pair(lens, lane)));
            }
            rays
        });
        camera
    }
}

fn pair(numbers: [Lanes; 2], lane: usize) -> Vec2 {
    let [x, y] = numbers.map(|numbers| numbers.as_array()[lane]);
    Vec2::new(x, y)
}
