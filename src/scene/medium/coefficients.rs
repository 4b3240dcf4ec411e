//! How much light a medium takes out of a ray, and what becomes of it.

use bevy::prelude::*;

use super::VolumeParameter;
use crate::color::Rgb;
use crate::scene::parameter_info::ParameterInfo;

/// The format's default.
const USUAL_ALBEDO: Rgb = Rgb::splat(0.75);

/// How much light a medium takes out of a ray, and what becomes of it.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "scenes have few media")]
pub enum Coefficients {
    /// By the light that is taken out, and the share of it that is scattered.
    Extinction {
        /// The extinction coefficient per unit of length, at least 0.
        sigma_t: VolumeParameter<Rgb>,
        /// The share of it that is scattered, in [0, 1]; the rest is absorbed.
        albedo: VolumeParameter<Rgb>,
    },
    /// By scattering and absorption, the same everywhere: an extension.
    Separate {
        /// The scattering coefficient per unit of length, at least 0.
        sigma_s: Rgb,
        /// The absorption coefficient per unit of length, at least 0.
        sigma_a: Rgb,
    },
}

impl Default for Coefficients {
    fn default() -> Self {
        Self::Extinction {
            sigma_t: Rgb::ONE.into(),
            albedo: USUAL_ALBEDO.into(),
        }
    }
}

impl Coefficients {
    /// The coefficients as extinction and albedo. Where nothing is taken out, the albedo is 0.
    pub fn sigma_t_and_albedo(&self) -> (VolumeParameter<Rgb>, VolumeParameter<Rgb>) {
        match self {
            Self::Extinction { sigma_t, albedo } => (sigma_t.clone(), albedo.clone()),
            Self::Separate { sigma_s, sigma_a } => {
                let sigma_t = *sigma_s + *sigma_a;
                let albedo = (*sigma_s / sigma_t).to_array();
                let albedo = albedo.map(|share| if share.is_finite() { share } else { 0.0 });
                (sigma_t.into(), Rgb::from_array(albedo).into())
            }
        }
    }
}

/// The largest coefficient per unit of length: products along a path stay finite.
const MOST_EXTINCTION: f32 = 1e9;

pub(crate) const SIGMA_T: ParameterInfo = ParameterInfo::new(
    "sigma_t",
    "Extinction",
    "The light that is taken out of a ray on a unit of length, by colour: after a way of its inverse the share exp(-1) is left.",
    "0 or more per channel and unit of length, or a volume",
)
.within(0.0..=MOST_EXTINCTION)
.offering(0.0..=10.0);

pub(crate) const ALBEDO: ParameterInfo = ParameterInfo::new(
    "albedo",
    "Albedo",
    "The share of that light that is scattered, by colour; the rest is absorbed. Clouds and milk have nearly 1, smoke and glass less.",
    "0 to 1 per channel, or a volume",
)
.within(0.0..=1.0);

pub(crate) const SIGMA_S: ParameterInfo = ParameterInfo::new(
    "sigma_s",
    "Scattering",
    "The light that is scattered on a unit of length, by colour.",
    "0 or more per channel and unit of length",
)
.within(0.0..=MOST_EXTINCTION)
.offering(0.0..=10.0);

pub(crate) const SIGMA_A: ParameterInfo = ParameterInfo::new(
    "sigma_a",
    "Absorption",
    "The light that is absorbed on a unit of length, by colour.",
    "0 or more per channel and unit of length",
)
.within(0.0..=MOST_EXTINCTION)
.offering(0.0..=10.0);
