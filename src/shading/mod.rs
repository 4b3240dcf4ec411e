//! The scattering of light at surfaces: the contract of every model, and the dispatch to them.
//!
//! Directions are unit vectors in the local shading frame, z being the shading normal. `wo` points to the viewer (where the path came
//! from), `wi` to the light (where it goes on). Along a path from a light the two change places: a [`TransportMode`] says what a path
//! carries, and matters to models that refract. For every model:
//!
//! - `eval(wo, wi, mode)` is f |cos wi|, without delta lobes.
//! - `pdf(wo, wi)` is the solid angle density with which `sample(wo)` returns `wi`, without delta lobes. It integrates to the
//!   probability that a sample is returned, at most 1. It is the same in both modes.
//! - `sample(wo, mode)` returns a direction with weight = f |cos wi| / pdf, or `None` where the light is absorbed. The mean of the weights is
//!   the albedo for light from everywhere, at most 1 (but for the eta^2 of refracted radiance, and for the layers of [`Principled`]).
//!
//! Smooth and rough metals and diffuse surfaces are black from behind. No model knows textures, other models, emission or geometry.
//!
//! Models are flat records. What some have tabulated is in the [`ShadingTables`] of the scene, which are the first argument: those that the ids
//! within the model are of.

mod beckmann;
mod compensation;
mod conductor;
mod dielectric;
mod diffuse;
mod diffuse_lobe;
pub mod fresnel;
mod ggx;
mod hair;
pub mod ior;
pub mod lanes;
mod metal;
mod microalbedo;
mod microfacet;
mod plastic;
mod principled;
mod rough_coat;
mod rough_conductor;
mod rough_dielectric;
mod rough_plastic;
mod tables;
mod thin_dielectric;
mod transport_mode;

pub use beckmann::Beckmann;
pub use compensation::Compensation;
pub use conductor::{Conductor, ConductorSpecular};
pub use dielectric::Dielectric;
pub use diffuse::Diffuse;
pub use diffuse_lobe::DiffuseLobe;
pub use fresnel::DielectricModel;
pub use ggx::Ggx;
pub use hair::{Fiber, Hair, melanin_absorption};
pub use metal::Metal;
pub use microfacet::{Microfacet, MicrofacetKind};
pub use plastic::{CoatedBase, Plastic, SmoothCoat};
pub use principled::{Principled, PrincipledThin, SamplingRates, ThinSamplingRates, eta_from_specular};
pub use rough_conductor::RoughConductor;
pub use rough_dielectric::RoughDielectric;
pub use rough_plastic::RoughPlastic;
pub use tables::{CoatId, MicroalbedoId, ShadingTables};
pub use thin_dielectric::ThinDielectric;
pub use transport_mode::TransportMode;

use crate::color::Rgb;
use glam::{Vec2, Vec3};

/// A surface's scattering model with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Lambert's reflection.
    Diffuse(Diffuse),
    /// A smooth metal.
    Conductor(Conductor),
    /// A metal of microfacets.
    RoughConductor(RoughConductor),
    /// A smooth interface of two transparent media.
    Dielectric(Dielectric),
    /// The fuzzy metal of the course project's format.
    Metal(Metal),
    /// The principled model of a closed surface.
    Principled(Principled),
    /// The principled model of a sheet without thickness.
    PrincipledThin(PrincipledThin),
    /// An interface of microfacets between two transparent media.
    RoughDielectric(RoughDielectric),
    /// A pane through which light goes straight.
    ThinDielectric(ThinDielectric),
    /// A diffuse base below a smooth coat.
    Plastic(Plastic),
    /// A diffuse base below a coat of microfacets.
    RoughPlastic(RoughPlastic),
    /// A fibre that light passes through and is reflected inside of.
    Hair(Hair),
}

/// A sampled continuation of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Unit vector to the light.
    pub wi: Vec3,
    /// The weight f |cos wi| / pdf.
    pub weight: Rgb,
    /// Solid angle density of `wi`; for a delta lobe the probability of choosing it.
    pub pdf: f32,
    /// Whether `wi` was the only direction of its lobe, so that `eval` and `pdf` are zero there.
    pub is_delta: bool,
    /// The relative index: 1 on reflection; on refraction the index behind the surface over that before it, as the path sees it (Russian roulette
    /// divides radiance by its square).
    pub eta: f32,
}

impl Bsdf {
    /// The value f |cos wi|, without delta lobes.
    pub fn eval(&self, tables: &ShadingTables, wo: Vec3, wi: Vec3, mode: TransportMode) -> Rgb {
        self.eval_and_pdf(tables, wo, wi, mode).0
    }

    /// [`Self::eval`] and [`Self::pdf`] in one call, at the cost of one.
    pub fn eval_and_pdf(&self, tables: &ShadingTables, wo: Vec3, wi: Vec3, mode: TransportMode) -> (Rgb, f32) {
        debug_assert!(
            wo.is_normalized() && wi.is_normalized(),
            "{wo} or {wi} is not of unit length"
        );
        let (value, pdf) = match self {
            Self::Diffuse(diffuse) => diffuse.eval_and_pdf(wo, wi),
            Self::RoughConductor(rough) => rough.eval_and_pdf(tables, wo, wi),
            Self::Metal(metal) => metal.eval_and_pdf(wo, wi),
            Self::Principled(principled) => principled.eval_and_pdf(wo, wi, mode),
            Self::PrincipledThin(thin) => thin.eval_and_pdf(wo, wi),
            Self::RoughDielectric(rough) => rough.eval_and_pdf(wo, wi, mode),
            Self::Plastic(plastic) => plastic.eval_and_pdf(wo, wi),
            Self::RoughPlastic(rough) => rough.eval_and_pdf(tables, wo, wi),
            Self::Hair(hair) => hair.eval_and_pdf(wo, wi),
            Self::Conductor(_) | Self::Dielectric(_) | Self::ThinDielectric(_) => (Rgb::ZERO, 0.0),
        };
        debug_assert!(
            value.min_element() >= 0.0 && value.is_finite() && pdf >= 0.0,
            "{self:?} is {value} with density {pdf} for {wo} and {wi}"
        );
        (value, pdf)
    }

    /// Solid angle density with which [`Self::sample`] returns `wi`, without delta lobes.
    pub fn pdf(&self, tables: &ShadingTables, wo: Vec3, wi: Vec3) -> f32 {
        debug_assert!(
            wo.is_normalized() && wi.is_normalized(),
            "{wo} or {wi} is not of unit length"
        );
        match self {
            // It is much less than the value.
            Self::RoughConductor(rough) => rough.pdf(wo, wi),
            _ => self.eval_and_pdf(tables, wo, wi, TransportMode::Radiance).1,
        }
    }

    /// Samples a direction for the path, from independent uniform numbers: `u_lobe` chooses (or is a third coordinate), `u` places. `None` if the
    /// light is absorbed.
    pub fn sample(
        &self,
        tables: &ShadingTables,
        wo: Vec3,
        u_lobe: f32,
        u: Vec2,
        mode: TransportMode,
    ) -> Option<BsdfSample> {
        debug_assert!(wo.is_normalized(), "{wo} is not of unit length");
        let sample = match self {
            Self::Diffuse(diffuse) => diffuse.sample(wo, u),
            Self::Conductor(conductor) => conductor.sample(wo),
            Self::RoughConductor(rough) => rough.sample(tables, wo, u),
            Self::Dielectric(dielectric) => dielectric.sample(wo, u_lobe, mode),
            Self::Metal(metal) => metal.sample(wo, u_lobe, u),
            Self::Principled(principled) => principled.sample(wo, u_lobe, u, mode),
            Self::PrincipledThin(thin) => thin.sample(wo, u_lobe, u),
            Self::RoughDielectric(rough) => rough.sample(wo, u_lobe, u, mode),
            Self::ThinDielectric(thin) => Some(thin.sample(wo, u_lobe)),
            Self::Plastic(plastic) => plastic.sample(wo, u_lobe, u),
            Self::RoughPlastic(rough) => rough.sample(tables, wo, u_lobe, u),
            Self::Hair(hair) => hair.sample(wo, u_lobe, u),
        };
        debug_assert!(
            sample.is_none_or(|sample| sample.wi.is_normalized() && sample.weight.is_finite() && sample.pdf > 0.0),
            "{self:?} samples {sample:?} for {wo}"
        );
        sample
    }

    /// Whether `tables` has all tables to whose ids the model refers.
    pub(crate) fn has_its_tables(&self, tables: &ShadingTables) -> bool {
        match self {
            Self::RoughConductor(rough) => {
                let table = rough.multiple_scattering.map(|compensation| compensation.table());
                table.is_none_or(|table| tables.has_microalbedo(table))
            }
            Self::RoughPlastic(rough) => tables.has_coat(rough.coat),
            _ => true,
        }
    }

    /// Whether there may be a [`Self::diffuse_lobe`].
    pub fn may_have_diffuse_lobe(&self) -> bool {
        matches!(
            self,
            Self::Diffuse(_) | Self::Plastic(_) | Self::RoughPlastic(_) | Self::Principled(_)
        )
    }

    /// The lobe of [`Self::sample`] whose directions have the density of the cosine with the normal. It is empty where there is none, and for what
    /// lets light through.
    pub fn diffuse_lobe(&self, tables: &ShadingTables, wo: Vec3) -> DiffuseLobe {
        match self {
            Self::Diffuse(_) => DiffuseLobe::ALL,
            Self::Plastic(plastic) => plastic.diffuse_lobe(wo),
            Self::RoughPlastic(plastic) => plastic.diffuse_lobe(tables, wo),
            Self::Principled(principled) => principled.diffuse_lobe(wo),
            _ => DiffuseLobe::NONE,
        }
    }

    /// Whether some of its light is scattered with a density, so that light sources are worth sampling from here.
    pub fn has_smooth_lobe(&self) -> bool {
        match self {
            Self::Diffuse(_)
            | Self::RoughConductor(_)
            | Self::RoughDielectric(_)
            | Self::Plastic(_)
            | Self::RoughPlastic(_)
            | Self::Principled(_)
            | Self::PrincipledThin(_)
            | Self::Hair(_) => true,
            Self::Conductor(_) | Self::Dielectric(_) | Self::ThinDielectric(_) => false,
            Self::Metal(metal) => !metal.is_delta(),
        }
    }

    /// Whether some of its light goes in the only direction of its lobe.
    pub fn has_delta_lobe(&self) -> bool {
        match self {
            Self::Conductor(_) | Self::Dielectric(_) | Self::ThinDielectric(_) | Self::Plastic(_) => true,
            Self::Metal(metal) => metal.is_delta(),
            Self::Diffuse(_)
            | Self::RoughConductor(_)
            | Self::RoughDielectric(_)
            | Self::RoughPlastic(_)
            | Self::Principled(_)
            | Self::PrincipledThin(_)
            | Self::Hair(_) => false,
        }
    }

    /// Whether it looks the same when the surface is turned about its normal.
    pub fn is_isotropic(&self) -> bool {
        match self {
            Self::RoughConductor(rough) => rough.distribution.is_isotropic(),
            Self::RoughDielectric(rough) => rough.distribution.is_isotropic(),
            Self::Principled(principled) => principled.anisotropic == 0.0,
            Self::PrincipledThin(thin) => thin.anisotropic == 0.0,
            Self::Hair(_) => false,
            Self::Diffuse(_)
            | Self::Conductor(_)
            | Self::Dielectric(_)
            | Self::Metal(_)
            | Self::ThinDielectric(_)
            | Self::Plastic(_)
            | Self::RoughPlastic(_) => true,
        }
    }

    /// Whether light from behind the surface can reach the viewer.
    pub(crate) fn transmits(&self) -> bool {
        match self {
            Self::Diffuse(_)
            | Self::Conductor(_)
            | Self::RoughConductor(_)
            | Self::Metal(_)
            | Self::Plastic(_)
            | Self::RoughPlastic(_) => false,
            Self::Dielectric(_)
            | Self::RoughDielectric(_)
            | Self::ThinDielectric(_)
            | Self::Principled(_)
            | Self::PrincipledThin(_)
            | Self::Hair(_) => true,
        }
    }

    /// Whether light can pass through it without changing its direction.
    pub fn has_null_lobe(&self) -> bool {
        matches!(self, Self::ThinDielectric(_) | Self::Hair(_))
    }

    /// The share of the light that passes through to `wo` without changing its direction.
    pub fn transmittance(&self, wo: Vec3) -> Rgb {
        match self {
            Self::ThinDielectric(thin) => thin.transmittance(wo),
            Self::Hair(hair) => hair.transmittance(wo),
            _ => Rgb::ZERO,
        }
    }

    /// The colour of the surface for denoisers and debug views: reflectance, mirror colour at normal incidence, white for glass. It is in [0, 1]
    /// for physical parameters.
    pub fn albedo(&self) -> Rgb {
        match self {
            Self::Diffuse(diffuse) => diffuse.reflectance,
            Self::Conductor(conductor) => conductor.specular.reflectance(1.0),
            Self::RoughConductor(rough) => rough.specular.reflectance(1.0),
            Self::Dielectric(_) | Self::RoughDielectric(_) | Self::ThinDielectric(_) => Rgb::ONE,
            Self::Plastic(plastic) => plastic.base.diffuse_reflectance,
            Self::RoughPlastic(rough) => rough.base.diffuse_reflectance,
            Self::Metal(metal) => metal.color,
            Self::Principled(principled) => principled.base_color,
            Self::PrincipledThin(thin) => thin.base_color,
            Self::Hair(hair) => hair.albedo(),
        }
    }
}

/// Where a view goes on at a surface if it knows neither roughness nor refraction, with the share of the light from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Onward {
    /// Behind the surface, in the same direction.
    Straight(Rgb),
    /// In the mirror.
    Mirrored(Rgb),
}

impl Bsdf {
    /// Where a view from `wo` goes on without roughness and refraction: glass is passed, and metals are mirrors on their front. None for other surfaces, whose
    /// gloss does not count.
    pub fn onward(&self, wo: Vec3) -> Option<Onward> {
        let is_front = wo.z > 0.0;
        let mirror = |share: Rgb| is_front.then_some(Onward::Mirrored(share));
        match self {
            Self::Conductor(conductor) => mirror(conductor.specular.reflectance(wo.z.abs())),
            Self::RoughConductor(rough) => mirror(rough.specular.reflectance(wo.z.abs())),
            Self::Metal(metal) => mirror(metal.color),
            Self::Dielectric(glass) => Some(Onward::Straight(glass.specular_transmittance)),
            Self::RoughDielectric(glass) => Some(Onward::Straight(glass.specular_transmittance)),
            Self::ThinDielectric(thin) => Some(Onward::Straight(thin.specular_transmittance)),
            Self::Principled(principled) => {
                let glass = (1.0 - principled.metallic) * principled.spec_trans;
                match principled.metallic >= glass && (is_front || glass == 0.0) {
                    true => mirror(principled.metallic * principled.base_color),
                    false => Some(Onward::Straight(glass * principled.base_color.map(f32::sqrt))),
                }
            }
            Self::PrincipledThin(thin) => Some(Onward::Straight(thin.spec_trans * thin.base_color)),
            Self::Diffuse(_) | Self::Plastic(_) | Self::RoughPlastic(_) | Self::Hair(_) => None,
        }
    }
}

/// The mirror image of `wo` about the normal.
pub(crate) fn mirrored(wo: Vec3) -> Vec3 {
    Vec3::new(-wo.x, -wo.y, wo.z)
}
