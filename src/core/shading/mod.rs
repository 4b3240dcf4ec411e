//! The scattering of light at surfaces: the contract of every model, and the dispatch to them.
//!
//! Directions are unit vectors in the local shading frame, z being the shading normal. `wo` points to where the path
//! came from (the viewer), `wi` to where it continues (the light). On a path from a light both change roles: the
//! [`TransportMode`] is the quantity that a path carries, and matters to models that refract. For every model:
//!
//! - `eval(wo, wi, mode)` is f |cos wi|, without delta lobes.
//! - `pdf(wo, wi)` is the solid angle density with which `sample(wo)` returns `wi`, without delta lobes. It integrates
//!   to the probability that a sample is returned, at most 1. It is the same in both modes.
//! - `sample(wo, mode)` returns a direction with weight = f |cos wi| / pdf, or `None` where the light is absorbed. The
//!   mean of the weights is the albedo under uniform light, at most 1 (except for the eta^2 of refracted radiance, and
//!   for the layers of [`Principled`]).
//!
//! Smooth and rough metals and diffuse surfaces are black from behind. Models are independent of textures, other
//! models, emission and geometry.
//!
//! Models are flat records, and their formulas are written once for one direction and for sixteen (`Model`).
//! Tabulated data are in the scene's [`ShadingTables`], the first argument, to which the ids within the models belong.

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

use glam::{Vec2, Vec3};

use crate::color::Rgb;
use crate::math::lanes::Lanes;
use crate::math::{Held, Real, Vector, real_struct};

/// The least squared length with which a half vector is normalised.
const LEAST_HALF_VECTOR: f32 = 1e-30;

real_struct! {
    /// A sampled continuation of a path.
    pub struct BsdfSample<R> {
        /// Unit vector to the light.
        pub wi: R::Vec3,
        /// The weight f |cos wi| / pdf.
        pub weight: R::Vec3,
        /// Solid angle density of `wi`; for a delta lobe the probability of choosing it.
        pub pdf: R,
        /// Whether `wi` was the only direction of its lobe, so that `eval` and `pdf` are zero there.
        pub is_delta: R::Mask,
        /// The relative index: 1 on reflection; on refraction the index on the side of `wi` over that on the side of
        /// `wo` (Russian roulette divides radiance by its square).
        pub eta: R,
        /// Whether a direction was sampled: else the light is absorbed, and the other fields are undefined.
        pub is_returned: R::Mask,
    }
}

/// A scattering model for one direction or for lanes; the contracts are those of this module.
pub(crate) trait Model<R: Real> {
    /// Whether the model is so short that lanes evaluate it inline. Longer models would take the registers of the code
    /// around them.
    const IS_SHORT: bool = false;

    /// The value f |cos wi| and the solid angle density with which [`Self::sample`] gives `wi`, both without delta
    /// lobes. The default is for models whose lobes are all delta.
    #[inline(always)]
    fn eval_and_pdf(&self, _: &ShadingTables, _: R::Vec3, _: R::Vec3, _: TransportMode) -> (R::Vec3, R) {
        (R::Vec3::even(R::ZERO), R::ZERO)
    }

    /// Samples the path's next direction from independent uniform numbers: `u_lobe` chooses the lobe (or is a third
    /// coordinate), `u` the direction.
    fn sample(&self, tables: &ShadingTables, wo: R::Vec3, u_lobe: R, u: [R; 2], mode: TransportMode) -> BsdfSample<R>;

    /// The lobe of [`Bsdf::diffuse_lobe`].
    #[inline(always)]
    fn diffuse_lobe(&self, _: &ShadingTables, _: R::Vec3) -> DiffuseLobe<R> {
        DiffuseLobe::NONE
    }
}

/// An operation on each kind of model that some lane has.
trait Visit {
    fn model<M: Model<Lanes>>(&mut self, lanes: Lanes, model: &M);
}

/// Declares the models: those with formulas for lanes as well, with their fields in [`ModelLanes`], and those that are
/// evaluated one by one.
macro_rules! models {
    (
        in lanes { $($(#[$about:meta])* $Model:ident: $field:ident,)* }
        one by one { $($(#[$about_other:meta])* $Other:ident,)* }
    ) => {
        /// A surface's scattering model with its parameters.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Bsdf {
            $($(#[$about])* $Model($Model),)*
            $($(#[$about_other])* $Other($Other),)*
        }

        /// Dispatches to the model.
        impl Model<f32> for Bsdf {
            fn eval_and_pdf(&self, tables: &ShadingTables, wo: Vec3, wi: Vec3, mode: TransportMode) -> (Rgb, f32) {
                match self {
                    $(Self::$Model(model) => Model::<f32>::eval_and_pdf(model, tables, wo, wi, mode),)*
                    $(Self::$Other(model) => Model::<f32>::eval_and_pdf(model, tables, wo, wi, mode),)*
                }
            }

            fn sample(
                &self,
                tables: &ShadingTables,
                wo: Vec3,
                u_lobe: f32,
                u: [f32; 2],
                mode: TransportMode,
            ) -> BsdfSample {
                match self {
                    $(Self::$Model(model) => Model::<f32>::sample(model, tables, wo, u_lobe, u, mode),)*
                    $(Self::$Other(model) => Model::<f32>::sample(model, tables, wo, u_lobe, u, mode),)*
                }
            }

            fn diffuse_lobe(&self, tables: &ShadingTables, wo: Vec3) -> DiffuseLobe {
                match self {
                    $(Self::$Model(model) => Model::<f32>::diffuse_lobe(model, tables, wo),)*
                    $(Self::$Other(model) => Model::<f32>::diffuse_lobe(model, tables, wo),)*
                }
            }
        }

        /// A model per lane, each in the lanes that have it.
        #[derive(Clone, Debug, Default)]
        struct ModelLanes {
            $($field: Held<$Model<Lanes>>,)*
        }

        impl ModelLanes {
            /// Whether lanes can have the model.
            fn knows(bsdf: &Bsdf) -> bool {
                matches!(bsdf, $(Bsdf::$Model(_))|*)
            }

            /// Removes the models of all lanes.
            fn clear(&mut self) {
                $(self.$field.lanes = 0;)*
            }

            /// Sets the model of a lane that has none. It must be [known](Self::knows).
            #[inline(always)]
            fn set(&mut self, lane: usize, bsdf: &Bsdf) {
                match bsdf {
                    $(Bsdf::$Model(model) => self.$field.set(lane, *model),)*
                    other => debug_assert!(false, "no model of lanes: {other:?}"),
                }
            }

            /// Calls `visit` with each model that some lane has.
            #[inline(always)]
            fn each(&self, visit: &mut impl Visit) {
                $(
                    if let Some((lanes, model)) = self.$field.held() {
                        visit.model(lanes, model);
                    }
                )*
            }
        }
    };
}

models! {
    in lanes {
        /// Lambert's reflection.
        Diffuse: diffuse,
        /// A smooth metal.
        Conductor: conductor,
        /// A metal of microfacets.
        RoughConductor: rough_conductor,
        /// A smooth interface of two transparent media.
        Dielectric: dielectric,
        /// The fuzzy metal of the course project's format.
        Metal: metal,
        /// The principled model of a closed surface.
        Principled: principled,
        /// The principled model of a sheet without thickness.
        PrincipledThin: principled_thin,
        /// An interface of microfacets between two transparent media.
        RoughDielectric: rough_dielectric,
        /// A diffuse base below a smooth coat.
        Plastic: plastic,
        /// A diffuse base below a coat of microfacets.
        RoughPlastic: rough_plastic,
    }
    one by one {
        /// A thin pane through which light passes straight.
        ThinDielectric,
        /// A fibre that transmits light and reflects it inside.
        Hair,
    }
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
        let (value, pdf) = Model::eval_and_pdf(self, tables, wo, wi, mode);
        debug_assert!(
            value.min_element() >= 0.0 && value.is_finite() && pdf >= 0.0,
            "{self:?} is {value} with density {pdf} for {wo} and {wi}"
        );
        (value, pdf)
    }

    /// Solid angle density with which [`Self::sample`] returns `wi`, without delta lobes.
    pub fn pdf(&self, tables: &ShadingTables, wo: Vec3, wi: Vec3) -> f32 {
        self.eval_and_pdf(tables, wo, wi, TransportMode::Radiance).1
    }

    /// Samples the path's next direction from independent uniform numbers: `u_lobe` chooses the lobe (or is a third
    /// coordinate), `u` the direction. `None` if the light is absorbed.
    pub fn sample(
        &self,
        tables: &ShadingTables,
        wo: Vec3,
        u_lobe: f32,
        u: Vec2,
        mode: TransportMode,
    ) -> Option<BsdfSample> {
        debug_assert!(wo.is_normalized(), "{wo} is not of unit length");
        let sample =
            Some(Model::sample(self, tables, wo, u_lobe, u.to_array(), mode)).filter(|sample| sample.is_returned);
        debug_assert!(
            sample.is_none_or(|sample| sample.wi.is_normalized() && sample.weight.is_finite() && sample.pdf > 0.0),
            "{self:?} samples {sample:?} for {wo}"
        );
        sample
    }

    /// Whether all ids within the model are valid in `tables`.
    pub(crate) fn has_its_tables(&self, tables: &ShadingTables) -> bool {
        match self {
            Self::RoughConductor(rough) => {
                let table = rough.multiple_scattering.table();
                table.is_none_or(|table| tables.has_microalbedo(table))
            }
            Self::RoughPlastic(rough) => tables.has_coat(rough.coat),
            _ => true,
        }
    }

    /// Whether [`Self::diffuse_lobe`] may be non-empty.
    pub fn may_have_diffuse_lobe(&self) -> bool {
        matches!(
            self,
            Self::Diffuse(_) | Self::Plastic(_) | Self::RoughPlastic(_) | Self::Principled(_)
        )
    }

    /// The lobe of [`Self::sample`] whose directions follow the cosine with the normal. It is empty for models without
    /// one, and for models that transmit light.
    pub fn diffuse_lobe(&self, tables: &ShadingTables, wo: Vec3) -> DiffuseLobe {
        Model::diffuse_lobe(self, tables, wo)
    }

    /// Whether [`Self::sample`] depends on `u_lobe`.
    pub(crate) fn chooses_lobes(&self) -> bool {
        !matches!(self, Self::Diffuse(_) | Self::Conductor(_) | Self::RoughConductor(_))
    }

    /// Whether part of its light is scattered with a density, so that light sampling helps.
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

    /// Whether part of its light is scattered in a single direction.
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

    /// Whether rotating the surface about its normal does not change its look.
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

    /// The colour of the surface for denoisers and debug views: reflectance, mirror colour at normal incidence, white
    /// for glass. It is in [0, 1] for physical parameters.
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

/// The next direction of a view that ignores roughness and refraction, with the throughput.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Onward {
    /// Straight through the surface.
    Straight(Rgb),
    /// The mirror direction.
    Mirrored(Rgb),
}

impl Bsdf {
    /// The next direction of a view from `wo` that ignores roughness and refraction: straight through glass, and
    /// mirrored at the front of metals. None for other surfaces, whose gloss is ignored.
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
