//! The view of a scene: camera, film, integrator, and the quantity shown. A different view means a new picture.

use glam::{UVec2, Vec2};

use super::camera::Camera;
use super::clamp::Clamp;
use super::dimensions::{FILTER, LENS};
use super::filter::PixelFilter;
use super::guide::Guide;
use super::layers::{FilmLayers, Layers};
use super::light_layers::LightGroups;
use super::motion::FrameBefore;
use super::photon_rounds::PhotonRounds;
use crate::math::Ray;
use crate::medium::MediumId;
use crate::render::visibility::sight::Sight;
use crate::sampling::{Sampler, SequenceKind};

/// All inputs of a picture besides the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The camera, which maps points of the film to rays.
    pub camera: Camera,
    /// The camera of the film, if the picture has another frame: a free view shows the surroundings of the film as
    /// well. None if the picture is the film.
    pub film_camera: Option<Camera>,
    /// The width in pixels.
    pub width: u32,
    /// The height in pixels.
    pub height: u32,
    /// The medium around the camera; None in empty space.
    pub medium: Option<MediumId>,
    /// The reconstruction filter around the centre of each pixel.
    pub filter: PixelFilter,
    /// The light transport method.
    pub integrator: Integrator,
    /// The meaning of a pixel's value.
    pub shown: Shown,
    /// The parts of the scene that are invisible to camera rays; by default none.
    pub sight: Sight,
    /// The groups of lights with separate layers in the film; none by default.
    pub light_groups: LightGroups,
    /// The layers that the film keeps beside the picture; none by default.
    pub layers: Layers,
    /// The previous frame, from which motion is measured; None without motion.
    pub before: Option<FrameBefore>,
    /// The kind of random numbers.
    pub sequence: SequenceKind,
    /// The seed. Another seed gives other noise.
    pub seed: u32,
    /// The photons of [`Integrator::Merging`], which are traced when they are needed.
    pub photons: PhotonRounds,
    /// The clamp on the brightness of samples; None for no limit.
    pub clamp: Option<Clamp>,
    /// The guide of camera paths; None for none.
    pub guide: Option<Guide>,
}

/// The light transport method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Integrator {
    /// Path tracing.
    Path(PathSettings),
    /// Bidirectional path tracing. Media are ignored.
    Bidirectional(PathSettings),
    /// Bidirectional path tracing with photons, which find caustics seen through glass and in mirrors: vertex
    /// connection and merging. It blurs light a little, less with each round of samples.
    Merging(PathSettings, PhotonSettings),
    /// Light paths alone. Surfaces seen in mirrors and through glass are black. Media are ignored.
    LightTracing(PathSettings),
}

impl Integrator {
    /// The settings of its paths.
    pub fn settings(&self) -> PathSettings {
        match *self {
            Self::Path(settings)
            | Self::Bidirectional(settings)
            | Self::Merging(settings, _)
            | Self::LightTracing(settings) => settings,
        }
    }

    /// The settings of its paths, for changes.
    pub fn settings_mut(&mut self) -> &mut PathSettings {
        match self {
            Self::Path(settings)
            | Self::Bidirectional(settings)
            | Self::Merging(settings, _)
            | Self::LightTracing(settings) => settings,
        }
    }

    /// Whether light paths may splat light onto any pixel.
    pub fn splats(&self) -> bool {
        !matches!(self, Self::Path(_))
    }
}

/// The quantity shown: the integrator's result, or a diagnostic of the renderer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shown {
    /// The result of the integrator.
    #[default]
    Radiance,
    /// The radiance in three thirds, from left to right with [`Strategy::Bsdf`], [`Strategy::Light`] and
    /// [`Strategy::Mis`].
    StrategyThirds,
    /// The work of the camera ray in the acceleration structure: boxes and primitives tested, as a grey value.
    BvhSteps,
    /// The optical depth of the media before the first surface, per channel.
    OpticalDepth,
    /// The irradiance on the first surface, on the side that faces the camera.
    Illuminance,
    /// The first surface in its own colour, lit from the camera alone.
    Headlight,
    /// The first surface in one grey for all, lit from the camera alone.
    Clay,
}

/// The most segments of a path, and surfaces that a shadow ray passes, where the scene sets no limit.
///
/// It keeps a fault of the geometry from holding a thread for ever. Pictures do not depend on it: Russian roulette with
/// its default depth lets a path of this length go on with a probability below 0.95^65000, and rays through dense
/// foliage pass some hundreds of surfaces, so that the bound leaves two orders of magnitude.
pub const LONGEST_PATH: u32 = 1 << 16;

/// The parameters of the path tracer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathSettings {
    /// The longest path in segments; 0 leaves the picture black. Values above [`LONGEST_PATH`], such as `u32::MAX` for
    /// an unbounded path, mean that bound.
    pub max_depth: u32,
    /// The depth from which on Russian roulette may end a path; it waits sixteen more vertices after specular bounces.
    pub rr_depth: u32,
    /// Whether emitters are invisible to the camera: its rays pass shapes that emit, and find no light at infinity.
    pub hide_emitters: bool,
    /// The strategy for direct light at each vertex.
    pub strategy: Strategy,
    /// Whether participating media are traced. Surfaces that let light pass straight then do not count as depth, as in
    /// Mitsuba's `volpath`.
    pub media: bool,
}

impl PathSettings {
    /// The longest path in segments, never above [`LONGEST_PATH`].
    #[inline(always)]
    pub(crate) fn longest_path(&self) -> u32 {
        self.max_depth.min(LONGEST_PATH)
    }

    /// Whether a path ends at its surface number `depth`, counted from 1.
    #[inline(always)]
    pub(super) fn is_last(&self, depth: u32) -> bool {
        depth >= self.longest_path()
    }

    /// The most surfaces that a shadow ray from vertex number `depth` of a path may pass; that vertex is not the last
    /// one.
    #[inline(always)]
    pub(super) fn crossings(&self, depth: u32) -> u32 {
        match self.media {
            true => LONGEST_PATH,
            false => self.longest_path() - depth - 1,
        }
    }
}

/// The parameters of photons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotonSettings {
    /// The number of light paths for one sample of all pixels; None for one per four pixels, within bounds.
    pub paths: Option<u32>,
    /// The radius within which photons are merged in the first samples, in pixels as seen by the camera; above 0.
    pub radius: f32,
}

/// The technique for finding light at a bounce.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// BSDF sampling alone (lights that cannot be hit are still sampled).
    Bsdf,
    /// Light sampling alone; emitters that are hit count only where lights cannot be sampled, after a specular bounce.
    Light,
    /// Both, weighted by the power heuristic.
    Mis,
}

/// The start of one sample of a pixel.
#[derive(Clone, Debug)]
pub struct CameraSample {
    /// The ray in world space.
    pub ray: Ray,
    /// The weight of the light along the ray, by the filter; 1 on average.
    pub weight: f32,
    /// The random numbers of the sample, of which those for filter and lens are already used.
    pub sampler: Sampler,
}

impl View {
    /// The camera of the film.
    pub fn of_film(&self) -> Camera {
        self.film_camera.unwrap_or(self.camera)
    }

    /// The place in the film, (0, 0) top left, (1, 1) bottom right, of a place in the picture. It may be outside of the
    /// film, if the picture shows the surroundings as well.
    pub fn film_of_picture(&self, place: Vec2) -> Vec2 {
        self.film_camera.map_or(place, |film| self.camera.film_of(place, &film))
    }

    /// The inverse of [`Self::film_of_picture`].
    pub fn picture_of_film(&self, place: Vec2) -> Vec2 {
        self.film_camera.map_or(place, |film| film.film_of(place, &self.camera))
    }

    /// The [corners of the film](Self::film_corners) in a picture that is the film.
    pub const WHOLE_FILM: [Vec2; 2] = [Vec2::ZERO, Vec2::ONE];

    /// The upper left and lower right corner of the film in the picture's coordinates.
    pub fn film_corners(&self) -> [Vec2; 2] {
        Self::WHOLE_FILM.map(|corner| self.picture_of_film(corner))
    }

    /// The layers of the picture's film.
    pub fn film_layers(&self) -> FilmLayers {
        FilmLayers {
            groups: self.light_groups.count(),
            layers: self.layers,
            splats: self.shown == Shown::Radiance && self.integrator.splats(),
        }
    }

    /// The settings for the paths of a pixel; None if no paths are traced.
    pub(crate) fn path_settings(&self, pixel: UVec2) -> Option<PathSettings> {
        let settings = self.integrator.settings();
        match self.shown {
            Shown::Radiance => Some(settings),
            Shown::StrategyThirds => Some(PathSettings {
                strategy: match 3 * pixel.x / self.width {
                    0 => Strategy::Bsdf,
                    1 => Strategy::Light,
                    _ => Strategy::Mis,
                },
                ..settings
            }),
            Shown::BvhSteps | Shown::OpticalDepth | Shown::Illuminance | Shown::Headlight | Shown::Clay => None,
        }
    }

    /// The camera ray of sample number `sample_index` of a pixel, before [`Self::sight`] shortens it. The same
    /// arguments always give the same ray.
    pub fn camera_sample(&self, pixel: UVec2, sample_index: u32) -> CameraSample {
        let sampler = Sampler::new(self.sequence, pixel, sample_index, self.seed);
        let place = self.filter.sample(sampler.at_2d(FILTER));
        let film = (pixel.as_vec2() + 0.5 + place.offset) / Vec2::new(self.width as f32, self.height as f32);
        CameraSample {
            ray: self.camera.ray(film, sampler.at_2d(LENS)),
            weight: place.weight,
            sampler,
        }
    }
}
