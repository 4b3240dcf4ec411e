//! The settings of rendering: the file's `integrator` and `sampler`, and the switches for comparing methods.

use std::ops::RangeInclusive;

use bevy::prelude::*;

use crate::layer::Layers;

declare_names! {
    /// The integrators of light paths, by their plugins.
    #[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum PathPlugin {
        /// `path`: a path tracer without media.
        #[default]
        Path = "path",
        /// `volpath`: a path tracer with scattering and absorption in media.
        VolPath = "volpath",
        /// `volpathmis`: the same as `volpath` here.
        VolPathMis = "volpathmis",
        /// `bdpt`: bidirectional path tracing, without media. Mitsuba 3 has none.
        Bdpt = "bdpt",
        /// `vcm`: `bdpt` with photon merging, which blurs caustics a little. Without media. Mitsuba 3 has none.
        Vcm = "vcm",
        /// `ptracer`: paths from the lights only, without media.
        Ptracer = "ptracer",
        /// `auto`: `path` or `bdpt`, whichever is more efficient for the scene, and `volpath` if there are media.
        /// Mitsuba 3 has none.
        Auto = "auto",
    }
}

impl PathPlugin {
    /// Whether [`Strategy`] applies. Other integrators always use all of their sampling techniques.
    pub fn has_strategy(self) -> bool {
        matches!(self, Self::Path | Self::VolPath | Self::VolPathMis | Self::Auto)
    }

    /// Whether it uses photons.
    pub fn has_photons(self) -> bool {
        self == Self::Vcm
    }

    /// Whether its paths can be guided.
    pub fn is_guidable(self) -> bool {
        matches!(self, Self::Path | Self::Auto)
    }

    /// Whether it traces media.
    pub fn traces_media(self) -> bool {
        matches!(self, Self::VolPath | Self::VolPathMis | Self::Auto)
    }
}

/// The path integrator.
#[derive(Resource, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Resource, PartialEq)]
pub struct IntegratorSettings {
    /// The plugin.
    pub plugin: PathPlugin,
    /// The most segments of a path: 1 shows emitters only, 2 adds direct light; None is unbounded.
    pub max_depth: Option<u32>,
    /// The depth from which paths may be ended by Russian roulette, see [`crate::render::view::PathSettings`].
    pub rr_depth: u32,
    /// Whether emitters are invisible to the camera.
    pub hide_emitters: bool,
    /// The strategy, for comparisons; it is not in files.
    pub strategy: Strategy,
    /// Whether Schlick's approximation is used for dielectrics instead of the exact Fresnel equations.
    pub schlick: bool,
    /// The number of light paths for one sample of all pixels, with `vcm`: the file's `photons`; None for one per four
    /// pixels.
    pub photons: Option<u32>,
    /// The radius within which photons are merged in the first samples, in pixels: the file's `merge_radius`.
    pub merge_radius: f32,
    /// The percentage of the samples with light that are not clamped, while brighter ones are; None for no clamp.
    pub clamp_percentile: Option<f32>,
    /// Whether camera paths are guided towards light, with `path` and with `auto` if that is `path`.
    pub guided: bool,
    /// The layers that are saved with the picture: the file's integrator `aov`.
    #[reflect(ignore)]
    pub layers: Layers,
}

impl IntegratorSettings {
    /// The most [`photons`](Self::photons): 32 rounds of them are in memory at a time.
    pub const MOST_PHOTONS: u32 = 1 << 18;
    /// The range of [`merge_radius`](Self::merge_radius), in pixels.
    pub const MERGE_RADII: RangeInclusive<f32> = 0.01..=1000.0;
    /// The range of [`clamp_percentile`](Self::clamp_percentile).
    pub const CLAMP_PERCENTILES: RangeInclusive<f32> = 50.0..=99.999;
}

impl Default for IntegratorSettings {
    fn default() -> Self {
        Self {
            plugin: PathPlugin::default(),
            max_depth: None,
            rr_depth: 5,
            hide_emitters: false,
            strategy: Strategy::Mis,
            schlick: false,
            photons: None,
            merge_radius: 3.0,
            clamp_percentile: None,
            guided: false,
            layers: Layers::default(),
        }
    }
}

declare_names! {
    /// The sampling strategy at each bounce. All three converge to the same picture, except that light-only sampling
    /// cannot see an emitter through a mirror or glass other than by following the path there.
    #[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Strategy {
        /// Directions are sampled from the BSDFs only.
        Bsdf = "bsdf",
        /// Directions are sampled from the lights only.
        Light = "light",
        /// Both, weighted by multiple importance sampling.
        #[default]
        Mis = "mis",
    }
}

/// The settings of the random numbers.
#[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[reflect(Resource, PartialEq)]
pub struct SamplerSettings {
    /// The kind of random numbers.
    pub sequence: Sequence,
    /// The seed. Another seed gives another pattern of noise.
    pub seed: u32,
}

declare_names! {
    /// The kinds of random numbers.
    #[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Sequence {
        /// Owen-scrambled Sobol points: less noise for the same number of samples.
        #[default]
        Sobol = "sobol",
        /// Independent random numbers, as the format's `independent` sampler.
        Independent = "independent",
    }
}

declare_names! {
    /// The build method of the acceleration structures.
    #[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
    #[reflect(Resource, PartialEq)]
    pub enum AccelMethod {
        /// No hierarchy: every ray is tested against every primitive.
        Linear = "linear",
        /// Split at the object median.
        Median = "median",
        /// Binned surface area heuristic.
        #[default]
        Sah = "sah",
    }
}
