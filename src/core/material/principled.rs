//! The principled models with textured parameters.

use super::lookup::Lookup;
use crate::color::Rgb;
use crate::shading::{Principled, PrincipledThin, SamplingRates, ThinSamplingRates};
use crate::texture::Parameter;

/// [`Principled`] with textured parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct TexturedPrincipled {
    /// As [`Principled::base_color`].
    pub base_color: Parameter<Rgb>,
    /// As [`Principled::roughness`].
    pub roughness: Parameter<f32>,
    /// As [`Principled::anisotropic`].
    pub anisotropic: Parameter<f32>,
    /// As [`Principled::metallic`].
    pub metallic: Parameter<f32>,
    /// As [`Principled::spec_trans`].
    pub spec_trans: Parameter<f32>,
    /// Refractive index inside over outside; not 1 if there may be glass.
    pub eta: f32,
    /// As [`Principled::spec_tint`].
    pub spec_tint: Parameter<f32>,
    /// As [`Principled::sheen`].
    pub sheen: Parameter<f32>,
    /// As [`Principled::sheen_tint`].
    pub sheen_tint: Parameter<f32>,
    /// As [`Principled::flatness`].
    pub flatness: Parameter<f32>,
    /// As [`Principled::clearcoat`].
    pub clearcoat: Parameter<f32>,
    /// As [`Principled::clearcoat_gloss`].
    pub clearcoat_gloss: Parameter<f32>,
    /// As [`Principled::rates`].
    pub rates: SamplingRates,
}

impl TexturedPrincipled {
    pub(super) fn resolve(&self, lookup: &mut impl Lookup) -> Principled {
        Principled {
            base_color: lookup.reflectance(self.base_color),
            roughness: lookup.share(self.roughness),
            anisotropic: lookup.share(self.anisotropic),
            metallic: lookup.share(self.metallic),
            spec_trans: lookup.share(self.spec_trans),
            eta: self.eta,
            spec_tint: lookup.share(self.spec_tint),
            sheen: lookup.share(self.sheen),
            sheen_tint: lookup.share(self.sheen_tint),
            flatness: lookup.share(self.flatness),
            clearcoat: lookup.share(self.clearcoat),
            clearcoat_gloss: lookup.share(self.clearcoat_gloss),
            rates: self.rates,
        }
    }
}

/// [`PrincipledThin`] with textured parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct TexturedPrincipledThin {
    /// As [`PrincipledThin::base_color`].
    pub base_color: Parameter<Rgb>,
    /// As [`PrincipledThin::roughness`].
    pub roughness: Parameter<f32>,
    /// As [`PrincipledThin::anisotropic`].
    pub anisotropic: Parameter<f32>,
    /// As [`PrincipledThin::spec_trans`].
    pub spec_trans: Parameter<f32>,
    /// As [`PrincipledThin::diff_trans`].
    pub diff_trans: Parameter<f32>,
    /// As [`PrincipledThin::eta`].
    pub eta: Parameter<f32>,
    /// As [`PrincipledThin::spec_tint`].
    pub spec_tint: Parameter<f32>,
    /// As [`PrincipledThin::sheen`].
    pub sheen: Parameter<f32>,
    /// As [`PrincipledThin::sheen_tint`].
    pub sheen_tint: Parameter<f32>,
    /// As [`PrincipledThin::flatness`].
    pub flatness: Parameter<f32>,
    /// As [`PrincipledThin::rates`].
    pub rates: ThinSamplingRates,
}

impl TexturedPrincipledThin {
    pub(super) fn resolve(&self, lookup: &mut impl Lookup) -> PrincipledThin {
        PrincipledThin {
            base_color: lookup.reflectance(self.base_color),
            roughness: lookup.share(self.roughness),
            anisotropic: lookup.share(self.anisotropic),
            spec_trans: lookup.share(self.spec_trans),
            diff_trans: lookup.float(self.diff_trans).clamp(0.0, 2.0),
            eta: lookup.float(self.eta).clamp(LOWEST_INDEX, HIGHEST_INDEX),
            spec_tint: lookup.share(self.spec_tint),
            sheen: lookup.share(self.sheen),
            sheen_tint: lookup.share(self.sheen_tint),
            flatness: lookup.share(self.flatness),
            rates: self.rates,
        }
    }
}

/// The range of refractive indices from textures.
const LOWEST_INDEX: f32 = 0.01;
const HIGHEST_INDEX: f32 = 100.0;
