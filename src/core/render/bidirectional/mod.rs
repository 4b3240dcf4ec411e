//! Bidirectional path tracing: a camera path and a light path, joined by all techniques under one multiple importance
//! sampling (Veach 1997, chapter 10; PBR 4th ed., section 16.1). And light tracing, which keeps only the paths that
//! lead from a light to the camera.
//!
//! A path of k vertices can be found with `s` vertices by the light path and `t` by the camera path, s + t = k:
//!
//! - s = 0: the camera path hits the emitter.
//! - s = 1: a light is sampled from the camera path, as in path tracing.
//! - s > 1, t > 1: both paths are joined by a shadow ray.
//! - t = 1: the light path is joined with the lens. Its light may fall on any pixel ([`super::splats`]).
//!
//! Excluded are s = t = 1, because directly visible light is found without noise, and t = 0, because cameras cannot be
//! hit. Each technique has the weight of the power heuristic (`weights.rs`), so that a path counts once in total.
//!
//! Vertex connection and merging adds a technique for each vertex that both paths come near, if a delta lobe has sent
//! the light there ([`merge`], [`photons`]): the only techniques that find light which reaches a diffuse surface
//! through glass and is seen through glass. Merged light is slightly blurred, and less so in each round.
//!
//! Media are not supported.

mod arrivals;
mod connect;
mod finds;
mod journeys;
mod merge;
mod photons;
mod subpath;
mod weights;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{UVec2, Vec3};

pub(super) use self::arrivals::arrivals;
pub(super) use self::finds::Find;
pub(super) use self::journeys::{Journey, journeys};
pub(super) use self::photons::photon_paths;
use self::subpath::{LightPath, Vertex, Walk};
use self::weights::{Merging, Ways};
use super::dimensions::LightDraw;
use super::guide::Field;
use super::observer::PathObserver;
use super::path_state::{PathRecord, PathSample};
use super::photon_map::PhotonMap;
use super::scene::RenderScene;
use super::splats::{Splat, TileSplats};
use super::view::{Integrator, PathSettings, PhotonSettings, Shown, View};
use crate::color::Rgb;
use crate::light::emission::{EmittedRay, Reach};
use crate::sampling::Sampler;

/// The techniques in use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Techniques {
    /// Whether paths from lights are joined with the lens.
    pub splats: bool,
    /// Whether camera paths continue beyond directly visible surfaces.
    pub camera_paths: bool,
    /// Whether paths from the camera are merged with photons.
    pub merging: Option<PhotonSettings>,
}

impl Techniques {
    /// The path settings and the techniques of a view; None if it traces no light paths.
    pub fn of(view: &View) -> Option<(PathSettings, Self)> {
        // Splats belong to no light group and no layer.
        let splats = !view.film_layers().parts_light();
        let (settings, splats, camera_paths, merging) = match view.integrator {
            _ if view.shown != Shown::Radiance => return None,
            Integrator::Path(_) => return None,
            Integrator::Bidirectional(settings) => (settings, splats, true, None),
            Integrator::Merging(settings, photons) => (settings, splats, true, Some(photons)),
            Integrator::LightTracing(settings) => (settings, true, false, None),
        };
        Some((
            settings,
            Self {
                splats,
                camera_paths,
                merging,
            },
        ))
    }
}

/// Traces the samples of a tile, and reuses memory between them.
pub(super) struct Tracer<'a> {
    scene: &'a RenderScene,
    view: &'a View,
    settings: PathSettings,
    techniques: Techniques,
    /// The photons of all rounds that contain some of the samples.
    rounds: Vec<(u32, Merging, Arc<PhotonMap>)>,
    /// The start of the last sample's light path.
    start: Option<Vec3>,
    light: Vec<Vertex<'a>>,
    camera: Vec<Vertex<'a>>,
    splats: TileSplats,
    /// The finds of samples, if they are recorded.
    finds: Option<Vec<Find>>,
    /// The guide by which finds are evaluated.
    field: Option<Arc<Field>>,
}

/// The pixel whose random numbers light paths use: no film has it.
const LIGHT_PIXEL: u32 = u32::MAX;

impl<'a> Tracer<'a> {
    /// A tracer with the photons for the samples of these indices. None if cancelled.
    pub fn new(
        scene: &'a RenderScene,
        view: &'a View,
        settings: PathSettings,
        techniques: Techniques,
        indices: impl Iterator<Item = u32>,
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let mut tracer = Self {
            scene,
            view,
            settings,
            techniques: Techniques {
                // Photons require delta lobes.
                merging: techniques.merging.filter(|_| scene.materials.has_delta_lobe()),
                ..techniques
            },
            rounds: Vec::new(),
            start: None,
            light: Vec::new(),
            camera: Vec::new(),
            splats: TileSplats::default(),
            finds: None,
            field: None,
        };
        for number in indices {
            if let Some(photons) = tracer.techniques.merging
                && !tracer.rounds.iter().any(|round| round.0 == number)
            {
                let (merging, map) = tracer.photons(number, photons, cancel)?;
                tracer.rounds.push((number, merging, map));
            }
        }
        Some(tracer)
    }

    /// Traces a sample of a pixel, and collects its splats on other pixels. Returns it with the weight of its light.
    pub fn sample(&mut self, pixel: UVec2, index: u32, observer: &mut impl PathObserver) -> (PathSample, f32) {
        let camera = self.view.camera_sample(pixel, index);
        let round = self.rounds.iter().find(|round| round.0 == index);
        let ways = Ways {
            to_lens: self.techniques.splats,
            joins: true,
            merging: round.map(|round| round.1),
        };
        let [mut light, mut vertices] = [&mut self.light, &mut self.camera].map(std::mem::take);
        let mut splats = std::mem::take(&mut self.splats);
        let finds = self.finds.take();
        let mut sample = self.begin(ways, camera.sampler, self.light_sampler(pixel, index));
        sample.photons = round.map(|round| &*round.2);
        sample.finds = finds;
        light.clear();
        vertices.clear();
        let start = sample.trace_light(&mut light);
        if self.techniques.splats {
            splats.paths += 1;
            sample.join_lens(start.as_ref(), &light, &mut splats.list);
        }
        sample.trace_camera(camera.ray, &mut vertices, start.as_ref(), &light, observer);
        let traced = sample.record.sample(sample.radiance, sample.rays);
        let finds = sample.finds.take();
        drop(sample);
        self.start = start.map(|start| start.emitted.origin);
        (self.light, self.camera, self.splats, self.finds) = (light, vertices, splats, finds);
        (traced, camera.weight)
    }

    fn begin<'b>(&'b self, ways: Ways, camera_sampler: Sampler, light_sampler: Sampler) -> Sample<'a, 'b> {
        Sample {
            scene: self.scene,
            view: self.view,
            settings: self.settings,
            camera_paths: self.techniques.camera_paths,
            ways,
            photons: None,
            reach: &self.scene.reach,
            camera_sampler,
            light_sampler,
            radiance: Rgb::ZERO,
            record: PathRecord::default(),
            rays: 0,
            finds: None,
            field: self.field.as_deref(),
        }
    }

    /// The last sample's light path: its start and its vertices. Empty if the light emitted nothing.
    pub fn light_path(&self) -> impl Iterator<Item = Vec3> {
        let vertices = self.light.iter().map(|vertex| vertex.point.position);
        self.start.into_iter().chain(vertices)
    }

    /// The splats since the last call.
    pub fn take_splats(&mut self) -> TileSplats {
        std::mem::take(&mut self.splats)
    }

    /// Records the finds of the next samples, with their contributions to paths guided by `field`.
    pub fn note_finds(&mut self, field: Option<Arc<Field>>) {
        self.finds = Some(Vec::new());
        self.field = field;
    }

    /// The finds since the last call.
    pub fn take_finds(&mut self) -> Vec<Find> {
        self.finds.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// The random numbers of the light path. All light paths of a picture have points of one sequence, so that together
    /// they cover the lights evenly.
    fn light_sampler(&self, pixel: UVec2, index: u32) -> Sampler {
        let pixels = u64::from(self.view.width) * u64::from(self.view.height);
        let number = u64::from(index) * pixels + u64::from(pixel.y) * u64::from(self.view.width) + u64::from(pixel.x);
        let sequence = UVec2::new(LIGHT_PIXEL, LIGHT_PIXEL - (number >> 32) as u32);
        Sampler::new(self.view.sequence, sequence, number as u32, self.view.seed)
    }
}

/// The state of a sample.
struct Sample<'a, 'b> {
    scene: &'a RenderScene,
    view: &'b View,
    settings: PathSettings,
    camera_paths: bool,
    ways: Ways,
    photons: Option<&'b PhotonMap>,
    reach: &'a Reach,
    camera_sampler: Sampler,
    light_sampler: Sampler,
    radiance: Rgb,
    record: PathRecord,
    rays: u32,
    finds: Option<Vec<Find>>,
    field: Option<&'b Field>,
}

impl<'a> Sample<'a, '_> {
    /// Traces a light path. None where the light emits nothing.
    fn trace_light(&mut self, vertices: &mut Vec<Vertex<'a>>) -> Option<LightPath> {
        // Without splats and a second vertex of the camera path nothing is joined.
        let longest = self.settings.longest_path();
        if longest < 2 {
            return None;
        }
        let emitted = self.emit()?;
        let mut path = LightPath {
            emitted,
            pdf_reverse: 0.0,
        };
        let mut walk = Walk::from_light(&emitted);
        while walk.segments + 1 < longest && self.extend_light(&mut walk, &mut path, vertices) {}
        Some(path)
    }

    /// The start of a light path. None where the light emits nothing.
    fn emit(&self) -> Option<EmittedRay> {
        let sampler = self.light_sampler;
        let emitted = self.scene.lights.sample_emission(
            self.reach,
            sampler.at_1d(LightDraw::Lobe.at(0)),
            sampler.at_2d(LightDraw::Place.at(0)),
            sampler.at_2d(LightDraw::Direction.at(0)),
        )?;
        (emitted.power != Rgb::ZERO && emitted.power.is_finite()).then_some(emitted)
    }
}

/// Splats the light at a point of the film, in pixels, onto one of the pixels whose filter covers it, chosen by `u`.
fn splat(view: &View, film: glam::Vec2, radiance: Rgb, u: f32) -> Option<Splat> {
    let (pixel, weight) = view.filter.choose_pixel(film, u)?;
    let size = glam::IVec2::new(view.width as i32, view.height as i32);
    let is_inside = pixel.cmpge(glam::IVec2::ZERO).all() && pixel.cmplt(size).all();
    (is_inside && radiance.is_finite() && radiance != Rgb::ZERO).then(|| Splat {
        pixel: pixel.as_uvec2(),
        radiance: radiance * weight,
    })
}
