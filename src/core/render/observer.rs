//! Observers of a path while it is traced. They cannot change the path, and unused ones cost nothing, because every
//! kind of observer has its own [`trace_path`](super::path::trace_path).

use glam::Vec3;

use crate::accel::Hit;
use crate::color::Rgb;
use crate::light::{LightId, LightSample};
use crate::material::{Lobe, MaterialId};
use crate::math::Ray;
use crate::medium::MediumId;

/// Receives the events along a path in this order: at each vertex, the hit, the surface, an emitter hit there, a light
/// sampled from there, and the bounce to the next; emitters at infinity after the last; then the reason for the end.
pub trait PathObserver {
    /// A ray of the path has hit a surface, the next vertex unless a medium scatters the path before.
    fn met(&mut self, _ray: &Ray, _hit: &Hit) {}
    /// A medium along the path's last ray has added its own light.
    fn emitted(&mut self, _glow: &Glow) {}
    /// The path has reached its next vertex.
    fn vertex(&mut self, _vertex: &PathVertex) {}
    /// The path has hit an emitter at its last vertex or at infinity.
    fn emitter_met(&mut self, _met: &MetEmitter) {}
    /// A light was sampled from the last vertex.
    fn light_sampled(&mut self, _sampled: &SampledLight) {}
    /// The last vertex was joined with a light path, or merged with its photon.
    fn joined(&mut self, _joined: &Joined) {}
    /// The path continues from its last vertex.
    fn bounced(&mut self, _bounce: &Bounce) {}
    /// The path has ended.
    fn ended(&mut self, _end: PathEnd) {}
}

/// No observer.
impl PathObserver for () {}

/// An observer that may be missing.
impl<O: PathObserver> PathObserver for Option<O> {
    fn met(&mut self, ray: &Ray, hit: &Hit) {
        self.iter_mut().for_each(|observer| observer.met(ray, hit));
    }

    fn emitted(&mut self, glow: &Glow) {
        self.iter_mut().for_each(|observer| observer.emitted(glow));
    }

    fn vertex(&mut self, vertex: &PathVertex) {
        self.iter_mut().for_each(|observer| observer.vertex(vertex));
    }

    fn emitter_met(&mut self, met: &MetEmitter) {
        self.iter_mut().for_each(|observer| observer.emitter_met(met));
    }

    fn light_sampled(&mut self, sampled: &SampledLight) {
        self.iter_mut().for_each(|observer| observer.light_sampled(sampled));
    }

    fn joined(&mut self, joined: &Joined) {
        self.iter_mut().for_each(|observer| observer.joined(joined));
    }

    fn bounced(&mut self, bounce: &Bounce) {
        self.iter_mut().for_each(|observer| observer.bounced(bounce));
    }

    fn ended(&mut self, end: PathEnd) {
        self.iter_mut().for_each(|observer| observer.ended(end));
    }
}

/// A vertex of the path, at which light is scattered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathVertex {
    /// A point on a surface.
    Surface(SurfaceVertex),
    /// A point in a medium.
    Medium(MediumVertex),
}

impl PathVertex {
    /// The position in world space.
    pub fn position(&self) -> Vec3 {
        match self {
            Self::Surface(surface) => surface.position,
            Self::Medium(place) => place.position,
        }
    }
}

/// A point in a medium that has scattered the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MediumVertex {
    /// The point in world space.
    pub position: Vec3,
    /// The medium.
    pub medium: MediumId,
}

/// A surface that the path has reached, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceVertex {
    /// The point on the surface.
    pub position: Vec3,
    /// Unit shading normal.
    pub normal: Vec3,
    /// The instance as [`crate::accel::Hit::instance`] counts them.
    pub instance: u32,
    /// The material of the slot that was hit.
    pub material: MaterialId,
}

/// The light of a medium that the path has gone through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glow {
    /// The medium.
    pub medium: MediumId,
    /// The contribution to the path's radiance.
    pub contribution: Rgb,
}

/// An emitter that the path has hit: at its last vertex, or at infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetEmitter {
    /// The light.
    pub light: LightId,
    /// The radiance emitted to the previous vertex.
    pub radiance: Rgb,
    /// Density per solid angle with which the bsdf chose the direction; None from the camera or after a specular
    /// bounce.
    pub bsdf_pdf: Option<f32>,
    /// The density with which light sampling would have found the emitter. None where the weight does not depend on it.
    pub light_pdf: Option<f32>,
    /// The weight of multiple importance sampling.
    pub weight: f32,
    /// The contribution to the path's radiance.
    pub contribution: Rgb,
}

/// A light that was sampled from the last vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledLight {
    /// The light that was chosen.
    pub light: LightId,
    /// The direction towards it, with radiance and density.
    pub sample: LightSample,
    /// Density per solid angle with which the BSDF would have sampled the direction.
    pub bsdf_pdf: f32,
    /// The probability with which media would have let the path reach the light in that direction, from 0 to 1.
    pub passed: f32,
    /// The weight of multiple importance sampling.
    pub weight: f32,
    /// The share of the light that reaches the vertex; zero if occluded, None if the surface would not have reflected
    /// it anyway.
    pub arriving: Option<Rgb>,
    /// The first surface, seen from the vertex, that has let the light pass straight on, by its instance as
    /// [`crate::accel::Hit::instance`] counts them. Invisible borders of media are left out.
    pub through: Option<u32>,
    /// The contribution to the path's radiance.
    pub contribution: Rgb,
}

/// The light of a light path at the last vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joined {
    /// The light at which that path begins.
    pub light: LightId,
    /// The vertex of that path, in world space.
    pub position: Vec3,
    /// The weight of multiple importance sampling.
    pub weight: f32,
    /// The contribution to the path's radiance.
    pub contribution: Rgb,
}

/// The continuation of the path from its last vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounce {
    /// Unit vector, world space.
    pub wi: Vec3,
    /// Whether the direction was sampled by a density or is the only one of its lobe.
    pub lobe: Lobe,
    /// Density per solid angle; of delta and null lobes the probability of choosing them.
    pub pdf: f32,
    /// Probability of having survived Russian roulette here; 1 where it was not played.
    pub survival: f32,
    /// The throughput after the bounce.
    pub throughput: Rgb,
}

/// The reason why a path has no further vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PathEnd {
    /// The ray hit nothing.
    #[default]
    Escaped,
    /// The path has its maximum length.
    DepthLimit,
    /// The surface absorbed the light.
    Absorbed,
    /// Russian roulette has ended it.
    Roulette,
}
