//! Bidirectional path tracing: a path from the camera and a path from a light, joined in all ways under one multiple importance sampling (Veach 1997,
//! chapter 10; PBR 4th ed., section 16.1). And light tracing, which keeps only the paths that lead from a light to the camera.
//!
//! A path of k vertices can be found with `s` vertices by the path from the light and `t` by that from the camera, s + t = k:
//!
//! - s = 0: the path from the camera comes upon the emitter.
//! - s = 1: a light is sampled from the camera's path, as path tracing does.
//! - s > 1, t > 1: both paths are joined by a shadow ray.
//! - t = 1: the path from the light is joined with the lens. What it brings may fall on any pixel ([`super::splats`]).
//!
//! Left out are s = t = 1, because what the camera sees directly is found without noise, and t = 0, because cameras are not hit. Each way has the weight of the
//! power heuristic (`weights.rs`), so that a path counts once in all.
//!
//! Media are not traced by it.

mod connect;
mod subpath;
mod weights;

use glam::UVec2;

use self::subpath::{LightPath, Vertex, Walk};
use super::dimensions::LightDraw;
use super::observer::PathObserver;
use super::path_state::{PathRecord, PathSample};
use super::scene::RenderScene;
use super::splats::{Splat, TileSplats};
use super::view::{PathSettings, View};
use crate::color::Rgb;
use crate::light::emission::SceneSphere;
use crate::sampling::Sampler;

/// The ways of joining paths that are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Techniques {
    /// Whether paths from lights are joined with the lens.
    pub splats: bool,
    /// Whether anything else is found but what the camera sees directly.
    pub camera_paths: bool,
}

/// Traces the samples of a tile, and keeps the memory for them.
pub(super) struct Tracer<'a> {
    scene: &'a RenderScene,
    view: &'a View,
    settings: PathSettings,
    techniques: Techniques,
    sphere: SceneSphere,
    light: Vec<Vertex<'a>>,
    camera: Vec<Vertex<'a>>,
    splats: TileSplats,
}

/// The pixel whose random numbers paths from the lights have: one that no film has.
const LIGHT_PIXEL: u32 = u32::MAX;

impl<'a> Tracer<'a> {
    pub fn new(scene: &'a RenderScene, view: &'a View, settings: PathSettings, techniques: Techniques) -> Self {
        Self {
            scene,
            view,
            settings,
            techniques,
            sphere: SceneSphere::around(&scene.geometry.bounds()),
            light: Vec::new(),
            camera: Vec::new(),
            splats: TileSplats::default(),
        }
    }

    /// Traces a sample of a pixel, and keeps the light that it brings to others. Returns it with what its light counts.
    pub fn sample(&mut self, pixel: UVec2, index: u32, observer: &mut impl PathObserver) -> (PathSample, f32) {
        let camera = self.view.camera_sample(pixel, index);
        let mut sample = Sample {
            scene: self.scene,
            view: self.view,
            settings: self.settings,
            techniques: self.techniques,
            sphere: &self.sphere,
            camera_sampler: camera.sampler,
            light_sampler: self.light_sampler(pixel, index),
            radiance: Rgb::ZERO,
            record: PathRecord::default(),
            rays: 0,
        };
        self.light.clear();
        self.camera.clear();
        let start = sample.trace_light(&mut self.light);
        if self.techniques.splats {
            self.splats.paths += 1;
            sample.join_lens(start.as_ref(), &self.light, &mut self.splats.list);
        }
        sample.trace_camera(camera.ray, &mut self.camera, start.as_ref(), &self.light, observer);
        (sample.record.sample(sample.radiance, sample.rays), camera.weight)
    }

    /// The splats since the last call.
    pub fn take_splats(&mut self) -> TileSplats {
        std::mem::take(&mut self.splats)
    }

    /// The random numbers of the path from a light. All paths of a picture have points of one sequence, so that together they cover the lights evenly.
    fn light_sampler(&self, pixel: UVec2, index: u32) -> Sampler {
        let pixels = u64::from(self.view.width) * u64::from(self.view.height);
        let number = u64::from(index) * pixels + u64::from(pixel.y) * u64::from(self.view.width) + u64::from(pixel.x);
        let sequence = UVec2::new(LIGHT_PIXEL, LIGHT_PIXEL - (number >> 32) as u32);
        Sampler::new(self.view.sequence, sequence, number as u32, self.view.seed)
    }
}

/// A sample under way.
struct Sample<'a, 'b> {
    scene: &'a RenderScene,
    view: &'b View,
    settings: PathSettings,
    techniques: Techniques,
    sphere: &'b SceneSphere,
    camera_sampler: Sampler,
    light_sampler: Sampler,
    radiance: Rgb,
    record: PathRecord,
    rays: u32,
}

impl<'a> Sample<'a, '_> {
    /// Traces a path from a light. None where nothing is emitted.
    fn trace_light(&mut self, vertices: &mut Vec<Vertex<'a>>) -> Option<LightPath> {
        // Without splats and a second vertex of the camera's path nothing is joined.
        let longest = self.settings.longest_path();
        if longest < 2 {
            return None;
        }
        let sampler = self.light_sampler;
        let emitted = self.scene.lights.sample_emission(
            self.sphere,
            sampler.at_1d(LightDraw::Lobe.at(0)),
            sampler.at_2d(LightDraw::Place.at(0)),
            sampler.at_2d(LightDraw::Direction.at(0)),
        )?;
        if emitted.power == Rgb::ZERO || !emitted.power.is_finite() {
            return None;
        }
        let mut path = LightPath {
            emitted,
            pdf_reverse: 0.0,
        };
        let mut walk = Walk::from_light(&emitted);
        while walk.segments + 1 < longest && self.extend_light(&mut walk, &mut path, vertices) {}
        Some(path)
    }
}

/// Puts the light of a place of the film, in pixels, into one of the pixels whose filter has a part in it, chosen by `u`.
fn splat(view: &View, film: glam::Vec2, radiance: Rgb, u: f32) -> Option<Splat> {
    let (pixel, weight) = view.filter.choose_pixel(film, u)?;
    let size = glam::IVec2::new(view.width as i32, view.height as i32);
    let is_inside = pixel.cmpge(glam::IVec2::ZERO).all() && pixel.cmplt(size).all();
    (is_inside && radiance.is_finite() && radiance != Rgb::ZERO).then(|| Splat {
        pixel: pixel.as_uvec2(),
        radiance: radiance * weight,
    })
}
