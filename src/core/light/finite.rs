//! Dispatch over the kinds of finite emitters.
//!
//! An emitter has one or more parts (a mesh has one per triangle), each of which is chosen by itself. Densities here
//! are for a given part; the light table multiplies them by the probability of the part.

use glam::{Vec2, Vec3};

use super::bounds::LightBounds;
use super::hit::SurfaceHit;
use super::luminaire::LuminaireLight;
use super::point::PointLight;
use super::projector::ProjectorLight;
use super::reference::Reference;
use super::spot::SpotLight;
use super::surface::SurfaceLight;
use super::{LightReference, LightSample};
use crate::color::Rgb;
use crate::math::Real;
use crate::texture::TextureTable;

#[derive(Clone, Debug)]
pub(super) enum FiniteLight {
    Surface(SurfaceLight),
    Point(PointLight),
    Spot(SpotLight),
    Luminaire(LuminaireLight),
    Projector(ProjectorLight),
}

impl FiniteLight {
    pub fn parts(&self) -> u32 {
        match self {
            Self::Surface(light) => light.parts(),
            Self::Point(_) | Self::Spot(_) | Self::Luminaire(_) | Self::Projector(_) => 1,
        }
    }

    /// The part that `hit` is on; None for emitters that cannot be hit.
    pub fn part_of(&self, hit: &SurfaceHit) -> Option<u32> {
        match self {
            Self::Surface(light) => light.part_of(hit),
            Self::Point(_) | Self::Spot(_) | Self::Luminaire(_) | Self::Projector(_) => None,
        }
    }

    /// The bounds of a part; their intensity is zero if it does not shine.
    pub fn bounds(&self, part: u32) -> LightBounds {
        match self {
            Self::Surface(light) => light.bounds(part),
            Self::Point(light) => light.bounds(),
            Self::Spot(light) => light.bounds(),
            Self::Luminaire(light) => light.bounds(),
            Self::Projector(light) => light.bounds(),
        }
    }

    /// Samples a direction towards a part; the density is zero where the part sends no light to the reference.
    #[inline(always)]
    pub fn sample<R: Real>(
        &self,
        part: u32,
        from: &Reference<R>,
        u: [R; 2],
        textures: &TextureTable,
    ) -> LightSample<R> {
        match self {
            Self::Surface(light) => light.sample(part, from, u, textures),
            Self::Point(light) => light.sample(from.position),
            Self::Spot(light) => light.sample(from, textures),
            Self::Luminaire(light) => light.sample(from),
            Self::Projector(light) => light.sample(from, textures),
        }
    }

    /// A point on a part, or the centre of round shapes.
    pub fn sample_place(&self, part: u32, u: Vec2) -> Vec3 {
        match self {
            Self::Surface(light) => light.sample_place(part, u),
            Self::Point(light) => light.position,
            Self::Spot(light) => light.position(),
            Self::Luminaire(light) => light.position,
            Self::Projector(light) => light.position(),
        }
    }

    /// Density per solid angle with which [`Self::sample`] finds a point of the part.
    pub fn pdf(&self, part: u32, reference: &LightReference, hit: &SurfaceHit) -> f32 {
        match self {
            Self::Surface(light) => light.pdf(part, reference.position, hit),
            Self::Point(_) | Self::Spot(_) | Self::Luminaire(_) | Self::Projector(_) => 0.0,
        }
    }

    /// Radiance sent along the unit vector `wo` from a point of its surface.
    pub fn emitted(&self, hit: &SurfaceHit, wo: Vec3, textures: &TextureTable) -> Rgb {
        match self {
            Self::Surface(light) if light.shines_to(hit, wo) => light.radiance(hit, textures),
            _ => Rgb::ZERO,
        }
    }
}
