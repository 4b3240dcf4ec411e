//! How surfaces scatter light: the contract of every model, and the dispatch to them.
//!
//! Directions are unit vectors in the local shading frame, z being the shading normal. `wo` points to the viewer (where the path came
//! from), `wi` to the light (where it goes on); models describe the transport of radiance along such a path. For every model:
//!
//! - `eval(wo, wi)` is f |cos wi|, without delta lobes.
//! - `pdf(wo, wi)` is the solid angle density with which `sample(wo)` returns `wi`, without delta lobes. It integrates to the
//!   probability that a sample is returned, at most 1.
//! - `sample(wo)` returns a direction with weight = f |cos wi| / pdf, or `None` where the light is absorbed. The mean of the weights is
//!   the albedo for light from everywhere, at most 1 (but for the eta^2 of refracted radiance, and for the layers of [`Principled`]).
//!
//! Smooth and rough metals and diffuse surfaces are black from behind; [`Bsdf::TwoSided`] gives them another side. No model knows
//! textures, emission or geometry.

mod beckmann;
mod conductor;
mod dielectric;
mod diffuse;
pub mod fresnel;
mod ggx;
pub mod ior;
mod metal;
mod microalbedo;
mod microfacet;
mod plastic;
mod principled;
mod rough_coat;
mod rough_conductor;
mod rough_dielectric;
mod rough_plastic;
mod thin_dielectric;

pub use beckmann::Beckmann;
pub use conductor::{Conductor, ConductorSpecular};
pub use dielectric::Dielectric;
pub use diffuse::Diffuse;
pub use fresnel::DielectricModel;
pub use ggx::Ggx;
pub use metal::Metal;
pub use microalbedo::Microalbedo;
pub use microfacet::{Microfacet, MicrofacetKind};
pub use plastic::{CoatedBase, Plastic, SmoothCoat};
pub use principled::{Principled, PrincipledThin, SamplingRates, ThinSamplingRates, eta_from_specular};
pub use rough_coat::RoughCoat;
pub use rough_conductor::RoughConductor;
pub use rough_dielectric::RoughDielectric;
pub use rough_plastic::RoughPlastic;
pub use thin_dielectric::ThinDielectric;

use crate::color::Rgb;
use glam::{Vec2, Vec3};

/// An index into a [`BsdfTable`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BsdfId(pub u32);

/// A surface's scattering model with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    Diffuse(Diffuse),
    Conductor(Conductor),
    RoughConductor(RoughConductor),
    Dielectric(Dielectric),
    Metal(Metal),
    Principled(Principled),
    PrincipledThin(PrincipledThin),
    RoughDielectric(RoughDielectric),
    ThinDielectric(ThinDielectric),
    Plastic(Plastic),
    RoughPlastic(RoughPlastic),
    /// One model seen from the normal's side and another (or the same, mirrored) from behind; neither is two-sided itself.
    TwoSided {
        front: BsdfId,
        back: BsdfId,
    },
}

/// A sampled continuation of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Unit vector to the light.
    pub wi: Vec3,
    /// f |cos wi| / pdf.
    pub weight: Rgb,
    /// Solid angle density of `wi`; for a delta lobe the probability of choosing it.
    pub pdf: f32,
    /// Whether `wi` was the only direction of its lobe, so that `eval` and `pdf` are zero there.
    pub is_delta: bool,
    /// 1 on reflection; on refraction the index behind the surface over that before it, as the path sees it (Russian roulette takes
    /// the radiance's eta^2 out again with it).
    pub eta: f32,
}

/// Why a list of models is no table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BsdfTableError {
    #[error("the two-sided bsdf {0} refers to number {1}, but there are only {2}")]
    OutOfRange(u32, u32, usize),
    #[error("the two-sided bsdf {0} holds number {1}, which is two-sided itself")]
    NestedTwoSided(u32, u32),
}

/// All scattering models of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BsdfTable {
    bsdfs: Vec<Bsdf>,
}

impl BsdfTable {
    /// A table whose [`BsdfId`]s are the positions in `bsdfs`. Two-sided models must refer to one-sided ones of the same list.
    pub fn new(bsdfs: Vec<Bsdf>) -> Result<Self, BsdfTableError> {
        for (index, bsdf) in bsdfs.iter().enumerate() {
            let Bsdf::TwoSided { front, back } = *bsdf else {
                continue;
            };
            for side in [front, back] {
                match bsdfs.get(side.0 as usize) {
                    None => return Err(BsdfTableError::OutOfRange(index as u32, side.0, bsdfs.len())),
                    Some(Bsdf::TwoSided { .. }) => return Err(BsdfTableError::NestedTwoSided(index as u32, side.0)),
                    Some(_) => {}
                }
            }
        }
        Ok(Self { bsdfs })
    }

    pub fn len(&self) -> usize {
        self.bsdfs.len()
    }

    pub fn is_empty(&self) -> bool {
        self.bsdfs.is_empty()
    }

    /// The model as it was put in, two-sided or not.
    pub fn get(&self, id: BsdfId) -> Option<&Bsdf> {
        self.bsdfs.get(id.0 as usize)
    }

    /// The one-sided model that `wo` meets, and the sign that takes z into its frame.
    fn facing(&self, id: BsdfId, wo: Vec3) -> (&Bsdf, f32) {
        match self.bsdfs[id.0 as usize] {
            Bsdf::TwoSided { front, .. } if wo.z > 0.0 => (&self.bsdfs[front.0 as usize], 1.0),
            Bsdf::TwoSided { back, .. } => (&self.bsdfs[back.0 as usize], -1.0),
            _ => (&self.bsdfs[id.0 as usize], 1.0),
        }
    }

    /// f |cos wi|, without delta lobes.
    pub fn eval(&self, id: BsdfId, wo: Vec3, wi: Vec3) -> Rgb {
        let (bsdf, side) = self.facing(id, wo);
        let (wo, wi) = (flipped(wo, side), flipped(wi, side));
        match bsdf {
            Bsdf::Diffuse(diffuse) => diffuse.eval(wo, wi),
            Bsdf::RoughConductor(rough) => rough.eval(wo, wi),
            Bsdf::Metal(metal) => metal.eval(wo, wi),
            Bsdf::Principled(principled) => principled.eval(wo, wi),
            Bsdf::PrincipledThin(thin) => thin.eval(wo, wi),
            Bsdf::RoughDielectric(rough) => rough.eval(wo, wi),
            Bsdf::Plastic(plastic) => plastic.eval(wo, wi),
            Bsdf::RoughPlastic(rough) => rough.eval(wo, wi),
            Bsdf::Conductor(_) | Bsdf::Dielectric(_) | Bsdf::ThinDielectric(_) | Bsdf::TwoSided { .. } => Rgb::ZERO,
        }
    }

    /// Solid angle density with which [`Self::sample`] returns `wi`, without delta lobes.
    pub fn pdf(&self, id: BsdfId, wo: Vec3, wi: Vec3) -> f32 {
        let (bsdf, side) = self.facing(id, wo);
        let (wo, wi) = (flipped(wo, side), flipped(wi, side));
        match bsdf {
            Bsdf::Diffuse(diffuse) => diffuse.pdf(wo, wi),
            Bsdf::RoughConductor(rough) => rough.pdf(wo, wi),
            Bsdf::Metal(metal) => metal.pdf(wo, wi),
            Bsdf::Principled(principled) => principled.pdf(wo, wi),
            Bsdf::PrincipledThin(thin) => thin.pdf(wo, wi),
            Bsdf::RoughDielectric(rough) => rough.pdf(wo, wi),
            Bsdf::Plastic(plastic) => plastic.pdf(wo, wi),
            Bsdf::RoughPlastic(rough) => rough.pdf(wo, wi),
            Bsdf::Conductor(_) | Bsdf::Dielectric(_) | Bsdf::ThinDielectric(_) | Bsdf::TwoSided { .. } => 0.0,
        }
    }

    /// A direction for the path to go on, from independent uniform numbers: `u_lobe` chooses (or is a third coordinate), `u` places.
    /// `None` if the light is absorbed.
    pub fn sample(&self, id: BsdfId, wo: Vec3, u_lobe: f32, u: Vec2) -> Option<BsdfSample> {
        let (bsdf, side) = self.facing(id, wo);
        let wo = flipped(wo, side);
        let sample = match bsdf {
            Bsdf::Diffuse(diffuse) => diffuse.sample(wo, u),
            Bsdf::Conductor(conductor) => conductor.sample(wo),
            Bsdf::RoughConductor(rough) => rough.sample(wo, u),
            Bsdf::Dielectric(dielectric) => dielectric.sample(wo, u_lobe),
            Bsdf::Metal(metal) => metal.sample(wo, u_lobe, u),
            Bsdf::Principled(principled) => principled.sample(wo, u_lobe, u),
            Bsdf::PrincipledThin(thin) => thin.sample(wo, u_lobe, u),
            Bsdf::RoughDielectric(rough) => rough.sample(wo, u_lobe, u),
            Bsdf::ThinDielectric(thin) => Some(thin.sample(wo, u_lobe)),
            Bsdf::Plastic(plastic) => plastic.sample(wo, u_lobe, u),
            Bsdf::RoughPlastic(rough) => rough.sample(wo, u_lobe, u),
            Bsdf::TwoSided { .. } => None,
        };
        sample.map(|sample| BsdfSample {
            wi: flipped(sample.wi, side),
            ..sample
        })
    }

    /// Whether some of its light is scattered with a density, so that light sources are worth sampling from here.
    pub fn has_smooth_lobe(&self, id: BsdfId) -> bool {
        match &self.bsdfs[id.0 as usize] {
            Bsdf::Diffuse(_)
            | Bsdf::RoughConductor(_)
            | Bsdf::RoughDielectric(_)
            | Bsdf::Plastic(_)
            | Bsdf::RoughPlastic(_)
            | Bsdf::Principled(_)
            | Bsdf::PrincipledThin(_) => true,
            Bsdf::Conductor(_) | Bsdf::Dielectric(_) | Bsdf::ThinDielectric(_) => false,
            Bsdf::Metal(metal) => !metal.is_delta(),
            Bsdf::TwoSided { front, back } => self.has_smooth_lobe(*front) || self.has_smooth_lobe(*back),
        }
    }

    /// Whether it has delta lobes only (a mirror, clear glass).
    pub fn is_perfectly_specular(&self, id: BsdfId) -> bool {
        !self.has_smooth_lobe(id)
    }

    /// A colour that stands for the surface where a denoiser or a debug view wants one: reflectance, mirror colour at normal
    /// incidence, white for glass. In [0, 1] for physical parameters.
    pub fn albedo(&self, id: BsdfId) -> Rgb {
        match &self.bsdfs[id.0 as usize] {
            Bsdf::Diffuse(diffuse) => diffuse.reflectance,
            Bsdf::Conductor(conductor) => conductor.specular.reflectance(1.0),
            Bsdf::RoughConductor(rough) => rough.specular.reflectance(1.0),
            Bsdf::Dielectric(_) | Bsdf::RoughDielectric(_) | Bsdf::ThinDielectric(_) => Rgb::ONE,
            Bsdf::Plastic(plastic) => plastic.base.diffuse_reflectance,
            Bsdf::RoughPlastic(rough) => rough.base.diffuse_reflectance,
            Bsdf::Metal(metal) => metal.color,
            Bsdf::Principled(principled) => principled.base_color,
            Bsdf::PrincipledThin(thin) => thin.base_color,
            Bsdf::TwoSided { front, .. } => self.albedo(*front),
        }
    }
}

fn flipped(v: Vec3, side: f32) -> Vec3 {
    Vec3::new(v.x, v.y, v.z * side)
}

/// The mirror image of `wo` about the normal.
fn mirrored(wo: Vec3) -> Vec3 {
    Vec3::new(-wo.x, -wo.y, wo.z)
}
