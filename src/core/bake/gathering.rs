//! What light is gathered from, and the places that it is gathered at.

use std::sync::atomic::AtomicBool;

use glam::Vec3;

use crate::color::Rgb;
use crate::render::irradiance::{IrradianceJob, ReceivedLight, Receiver, trace_irradiance};
use crate::render::probe_radiance::{RadianceJob, Window, trace_radiance};
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::sampling::Sampler;

/// Everything that the light at a place depends on besides the place.
#[derive(Clone, Debug)]
pub struct Gathering<'a> {
    /// The scene that sends the light.
    pub scene: &'a RenderScene,
    /// The settings of paths, the medium that all surfaces are in, and the random numbers with their seed.
    pub view: &'a View,
    /// The light that counts at a side of a surface.
    pub light: ReceivedLight,
}

/// One sample of the light at a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arrived {
    /// Irradiance or radiance, linear Rec. 709.
    pub light: Rgb,
    /// Whether the path first meets the back of a surface.
    pub meets_back: bool,
    /// Rays traced, shadow rays included.
    pub rays: u32,
}

/// A place that light is gathered at.
pub trait Site: Copy + Send + Sync {
    /// A sample for each of the sites with its random numbers, in their order. None if `cancel` was set in the
    /// meantime.
    fn trace(gathering: &Gathering, sites: &[(Self, Sampler)], cancel: &AtomicBool) -> Option<Vec<Arrived>>;

    /// The same at another place beside it.
    fn at(self, place: Vec3) -> Self;
}

/// Irradiance.
impl Site for Receiver {
    fn at(self, position: Vec3) -> Self {
        Self { position, ..self }
    }

    fn trace(gathering: &Gathering, sites: &[(Self, Sampler)], cancel: &AtomicBool) -> Option<Vec<Arrived>> {
        let Gathering { scene, view, light } = gathering;
        let job = |&(receiver, sampler): &(Self, Sampler)| IrradianceJob { receiver, sampler };
        let jobs: Vec<IrradianceJob> = sites.iter().map(job).collect();
        let samples = trace_irradiance(scene, view, *light, &jobs, cancel)?.into_iter();
        let arrived = samples.map(|sample| Arrived {
            light: sample.irradiance,
            meets_back: sample.meets_back,
            rays: sample.rays,
        });
        Some(arrived.collect())
    }
}

/// Radiance, the mean over the window.
impl Site for Window {
    fn at(self, _: Vec3) -> Self {
        self
    }

    fn trace(gathering: &Gathering, sites: &[(Self, Sampler)], cancel: &AtomicBool) -> Option<Vec<Arrived>> {
        let job = |&(window, sampler): &(Self, Sampler)| RadianceJob { window, sampler };
        let jobs: Vec<RadianceJob> = sites.iter().map(job).collect();
        let samples = trace_radiance(gathering.scene, gathering.view, &jobs, cancel)?.into_iter();
        let arrived = samples.map(|sample| Arrived {
            light: sample.radiance,
            meets_back: sample.meets_back,
            rays: sample.rays,
        });
        Some(arrived.collect())
    }
}
