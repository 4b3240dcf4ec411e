//! Rays of light as emitters send them: where paths from the lights start (Veach 1997, section 10.2; PBR 4th ed., section 16.1).

use glam::Vec3;

use super::{LightId, SurfaceHit};
use crate::color::Rgb;
use crate::math::Aabb;

/// A ray of light that leaves an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmittedRay {
    /// The light that it comes from.
    pub light: LightId,
    /// The start of the ray, off the surface if there is one; before the scene for lights at infinity.
    pub origin: Vec3,
    /// Unit vector, where the light goes.
    pub dir: Vec3,
    /// The power of the ray: what is emitted, with the cosine at the emitter, over the densities.
    pub power: Rgb,
    /// The densities by which the ray was sampled.
    pub pdf: EmissionPdf,
    /// The place on the emitter.
    pub start: Start,
}

/// The densities of a ray in the measures of its emitter, which depend on its kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmissionPdf {
    /// Density of the start, with the probability of the light: per area on surfaces; per solid angle of the direction that light comes from for lights at
    /// infinity. For points, and for lights of one direction, it is the probability of the light.
    pub start: f32,
    /// Density of what follows: per solid angle of the direction; for lights at infinity per area perpendicular to it.
    pub next: f32,
}

/// The first vertex of a path from a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// A point of a surface.
    Surface(SurfaceHit),
    /// A point without extent.
    Point(Vec3),
    /// Infinitely far away. `is_delta`: in one direction alone.
    Infinity {
        /// Whether the light comes from this direction alone.
        is_delta: bool,
    },
}

impl Start {
    /// Whether no path from the camera can come upon the place by itself.
    pub fn is_delta(&self) -> bool {
        match *self {
            Self::Surface(_) => false,
            Self::Point(_) => true,
            Self::Infinity { is_delta } => is_delta,
        }
    }

    /// A density per solid angle of directions from `reference` to the place, in the measure of [`EmissionPdf::start`].
    pub fn density(&self, reference: Vec3, pdf_solid_angle: f32) -> f32 {
        match self {
            Self::Surface(hit) => {
                let way = hit.position - reference;
                let distance_squared = way.length_squared();
                pdf_solid_angle * (way.dot(hit.normal) / distance_squared.sqrt()).abs() / distance_squared
            }
            Self::Point(_) | Self::Infinity { .. } => pdf_solid_angle,
        }
    }
}

/// A direction in which a point shines.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam {
    /// Unit vector.
    pub dir: Vec3,
    /// Radiant intensity in W/sr.
    pub intensity: Rgb,
    pub pdf_solid_angle: f32,
}

/// A sphere around everything that light from infinity can meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneSphere {
    /// World space.
    pub center: Vec3,
    /// Above zero.
    pub radius: f32,
}

impl SceneSphere {
    /// The sphere around a box, a little larger for rounding.
    pub fn around(bounds: &Aabb) -> Self {
        if !bounds.min.cmple(bounds.max).all() {
            return Self {
                center: Vec3::ZERO,
                radius: 1.0,
            };
        }
        let radius = 0.5 * bounds.extent().length() * (1.0 + 1e-4);
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        Self {
            center: bounds.center(),
            radius: radius.max(1e-6 * reach).max(f32::MIN_POSITIVE.sqrt()),
        }
    }

    /// The area of its disk.
    pub(super) fn cross_section(&self) -> f32 {
        std::f32::consts::PI * self.radius * self.radius
    }
}
