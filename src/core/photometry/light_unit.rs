//! The units in which the strength of a light can be said, and how much of each a light gives.

use super::LUMENS_PER_WATT;

declare_names! {
    /// A photometric unit of the strength of a light.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum LightUnit {
        /// The luminous flux, in all directions and of the whole surface.
        Lumen = "lm" => "lumens",
        /// The luminous intensity; of lights with a beam along its axis, of measured lamps in their brightest
        /// direction.
        Candela = "cd" => "candela",
        /// The illuminance on a surface that faces the light, or for lights from many directions on one that lies
        /// under them.
        Lux = "lx" => "lux",
        /// The luminance in cd/m²; of pictures their average.
        Nit = "nit" => "nits",
    }
}

impl LightUnit {
    /// The quantity that is measured in the unit.
    pub const fn quantity(self) -> &'static str {
        match self {
            Self::Lumen => "Flux",
            Self::Candela => "Intensity",
            Self::Lux => "Illuminance",
            Self::Nit => "Luminance",
        }
    }
}

/// How much of a unit a light gives for its strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measure {
    /// The unit.
    pub unit: LightUnit,
    /// The number in the unit for a strength of luminance 1, above 0.
    pub per_strength: f32,
}

impl Measure {
    /// The measure of a light that gives the radiometric quantity of the unit (W, W/sr, W/m² or W/(m² sr)) for a
    /// strength of luminance 1. None for a light that gives none of it.
    pub fn new(unit: LightUnit, per_strength: f64) -> Option<Self> {
        let per_strength = (f64::from(LUMENS_PER_WATT) * per_strength) as f32;
        (per_strength > 0.0 && per_strength.is_finite()).then_some(Self { unit, per_strength })
    }
}
