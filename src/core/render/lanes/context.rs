//! The data shared by all paths that are traced together.

use glam::UVec2;

use crate::accel::{Hit, Obstacles, RayLanes, Tlas};
use crate::light::{LightId, SoleLight};
use crate::math::lanes::LANES;
use crate::medium::MediumId;
use crate::render::guide::Field;
use crate::render::layers::{LayerNotes, NoteTaker};
use crate::render::path::PathSample;
use crate::render::scene::RenderScene;
use crate::render::view::{PathSettings, View};

/// A sample of a pixel to be traced.
#[derive(Clone, Copy, Debug)]
pub(in crate::render) struct Job {
    pub pixel: UVec2,
    pub index: u32,
}

/// The results of paths, by job.
pub(in crate::render) struct Samples<'v> {
    /// The samples and their weights.
    pub list: Vec<(PathSample, f32)>,
    /// The notes for layers; None if there are none.
    pub notes: Option<LayerNotes<'v>>,
}

impl<'v> Samples<'v> {
    /// Room for the results of `jobs` jobs.
    pub fn new(view: &'v View, jobs: usize) -> Self {
        Self {
            list: vec![(PathSample::default(), 0.0); jobs],
            notes: LayerNotes::new(view, jobs),
        }
    }

    /// The observer of the path of a job.
    pub fn observer(&mut self, job: usize) -> Option<NoteTaker<'_>> {
        self.notes.as_mut().map(|notes| notes.of(job))
    }
}

/// The number of steps between two checks whether to stop.
pub(super) const STEPS_TO_CANCEL: usize = 64;

pub(super) struct Context<'a> {
    pub scene: &'a RenderScene,
    pub view: &'a View,
    pub settings: &'a PathSettings,
    pub sole_light: Option<(LightId, SoleLight<'a>)>,
    /// The guide of paths.
    pub field: Option<&'a Field>,
}

/// Whether rays are coherent, as rays through one pixel are.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Coherence {
    Coherent,
    Incoherent,
}

impl Context<'_> {
    /// The medium in which paths begin.
    pub fn medium(&self) -> Option<MediumId> {
        self.view.medium.filter(|_| self.settings.media)
    }

    /// Whether lights are sampled at all. In scenes with several lights some can be found only by sampling, whatever
    /// the strategy.
    pub fn samples_lights(&self) -> bool {
        self.settings.strategy.samples_lights() || self.sole_light.is_none()
    }
}

impl Coherence {
    /// The hits of the rays of the lanes `asked`.
    pub fn intersect(self, geometry: &Tlas, rays: &RayLanes, asked: u32) -> [Option<Hit>; LANES] {
        match self {
            Self::Coherent => geometry.intersect_packet(rays, asked),
            Self::Incoherent => geometry.intersect_lanes(rays, asked),
        }
    }

    /// The obstacles on the rays of the lanes `asked`.
    pub fn obstacles(self, scene: &RenderScene, rays: &RayLanes, asked: u32) -> Obstacles {
        let geometry = &scene.geometry;
        let is_clear = |shape: usize| scene.is_clear(shape);
        let opaque = match (self, scene.materials.has_null_lobe()) {
            (Self::Coherent, false) => geometry.occluded_packet(rays, asked),
            (Self::Incoherent, false) => geometry.occluded_lanes(rays, asked),
            (Self::Coherent, true) => return geometry.obstacles_packet(rays, asked, is_clear),
            (Self::Incoherent, true) => return geometry.obstacles(rays, asked, is_clear),
        };
        Obstacles { opaque, clear: 0 }
    }
}

/// The paths that have gone through the commonest media, a bit each.
#[derive(Clone, Copy)]
pub(super) struct Travelled {
    pub lanes: u32,
    /// The paths among them that are scattered before the ends of their rays, at the places that are the vertices.
    pub scattered: u32,
}

impl Travelled {
    /// No path.
    pub const NOTHING: Self = Self { lanes: 0, scattered: 0 };
}
