//! The coefficients of a medium: extinction, scattering and absorption.

use bevy::prelude::*;

use super::VolumeParameter;
use crate::color::Rgb;
use crate::scene::components::parameter_info::ParameterInfo;

/// The format's default.
const USUAL_ALBEDO: Rgb = Rgb::splat(0.75);

/// The extinction of a medium, and its division into scattering and absorption.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "scenes have few media")]
pub enum Coefficients {
    /// Extinction and albedo.
    Extinction {
        /// The extinction coefficient per unit of length, at least 0.
        sigma_t: VolumeParameter<Rgb>,
        /// The albedo, the scattered share of the extinction, in [0, 1]; the rest is absorbed.
        albedo: VolumeParameter<Rgb>,
    },
    /// Scattering and absorption, the same everywhere: an extension.
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
    /// The coefficients as extinction and albedo. The albedo is 0 where the extinction is.
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

impl Coefficients {
    /// The extinction per unit of length before the medium's `scale`, if it is constant where it is not zero; None for
    /// a grid.
    pub fn uniform_extinction(&self) -> Option<Rgb> {
        match self {
            Self::Extinction { sigma_t, .. } => match sigma_t {
                VolumeParameter::Constant(value) | VolumeParameter::Box { value, .. } => Some(*value),
                VolumeParameter::Grid(_) => None,
            },
            Self::Separate { sigma_s, sigma_a } => Some(*sigma_s + *sigma_a),
        }
    }

    /// Sets the extinction and keeps the albedo. Does nothing for a grid.
    pub fn set_uniform_extinction(&mut self, extinction: Rgb) {
        let (_, albedo) = self.sigma_t_and_albedo();
        match self {
            Self::Extinction { sigma_t, .. } => match sigma_t {
                VolumeParameter::Constant(value) | VolumeParameter::Box { value, .. } => *value = extinction,
                VolumeParameter::Grid(_) => {}
            },
            Self::Separate { sigma_s, sigma_a } => {
                *sigma_s = extinction * albedo.constant().unwrap_or(Rgb::ZERO);
                *sigma_a = extinction - *sigma_s;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extinction_is_set_whichever_way_it_is_given() {
        let mut separate = Coefficients::Separate {
            sigma_s: Rgb::new(1.0, 3.0, 0.0),
            sigma_a: Rgb::new(1.0, 1.0, 0.0),
        };
        assert_eq!(separate.uniform_extinction(), Some(Rgb::new(2.0, 4.0, 0.0)));
        separate.set_uniform_extinction(Rgb::new(4.0, 8.0, 1.0));
        assert_eq!(
            separate,
            Coefficients::Separate {
                sigma_s: Rgb::new(2.0, 6.0, 0.0),
                sigma_a: Rgb::new(2.0, 2.0, 1.0),
            }
        );
        let mut whole = Coefficients::default();
        whole.set_uniform_extinction(Rgb::splat(0.5));
        assert_eq!(whole.sigma_t_and_albedo().0, Rgb::splat(0.5).into());
    }
}
