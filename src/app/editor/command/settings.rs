//! Edits of the settings of the whole scene.

use super::traits::Traits;
use crate::scene::{AccelMethod, IntegratorSettings, LengthUnit, LightUnits, SamplerSettings};

/// An edit of the settings of the whole scene.
#[derive(Clone, Debug, PartialEq)]
pub enum SettingsEdit {
    /// Sets the integrator and the lengths of its paths.
    SetIntegrator(IntegratorSettings),
    /// Sets the kind and seed of random numbers.
    SetSampler(SamplerSettings),
    /// Sets the unit of length of the scene. No length changes.
    SetUnit(LengthUnit),
    /// Sets the units in which lights are shown and typed. No light changes.
    SetLightUnits(LightUnits),
    /// Sets the construction of acceleration structures.
    SetAccel(AccelMethod),
    /// Multiplies the lights by their strengths and colours in the mix, and makes the mix neutral.
    BakeLights,
    /// Gives lamps the places, aims, times and strengths that were found for the light that is wanted.
    AcceptLamps,
}

impl SettingsEdit {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::SetIntegrator(_) => Traits::drag("Edit light transport"),
            Self::SetSampler(_) => Traits::drag("Edit sampler"),
            Self::SetUnit(_) => Traits::edit("Set unit of length").keeping_picture(),
            Self::SetLightUnits(_) => Traits::edit("Set units of light").keeping_picture(),
            Self::SetAccel(_) => Traits::edit("Edit hierarchy"),
            Self::BakeLights => Traits::edit("Bake light mix"),
            Self::AcceptLamps => Traits::edit("Place lamps for the wanted light"),
        }
    }
}
