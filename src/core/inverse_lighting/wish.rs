//! The light that a stroke wants, beside the present light.

use super::observations::Wanted;
use crate::color::{Rgb, luminance};
use crate::photometry::LUMENS_PER_WATT;

/// The light that a stroke wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wish {
    /// The present light times this factor, at least 1.
    Brighter(f32),
    /// The present light divided by this factor, at least 1.
    Darker(f32),
    /// This luminance in nit, of any colour.
    Luminance(f32),
    /// This illuminance in lux, of any colour, on the side of the surface that faces the camera.
    Illuminance(f32),
    /// The present luminance with the hue and saturation of this linear Rec. 709 colour, which is not black.
    Color(Rgb),
    /// The present light.
    Keep,
}

impl Wish {
    /// All kinds of wishes with their usual numbers.
    pub const ALL: [Self; 6] = [
        Self::Brighter(2.0),
        Self::Darker(2.0),
        Self::Luminance(100.0),
        Self::Illuminance(500.0),
        Self::Color(Rgb::new(1.0, 0.8, 0.6)),
        Self::Keep,
    ];

    /// The name of its kind, in scripts and panels.
    pub fn name(self) -> &'static str {
        match self {
            Self::Brighter(_) => "brighter",
            Self::Darker(_) => "darker",
            Self::Luminance(_) => "luminance",
            Self::Illuminance(_) => "illuminance",
            Self::Color(_) => "colour",
            Self::Keep => "keep",
        }
    }

    /// The light that is wanted at a place with this radiance, or this irradiance if illuminance is wanted; None where
    /// the wish makes no sense.
    pub fn wanted(self, present: Rgb) -> Option<Wanted> {
        let of_lumens = |lumens: f32| Wanted::Luminance(lumens / LUMENS_PER_WATT);
        match self {
            Self::Brighter(factor) => Some(Wanted::Color(present * factor)),
            Self::Darker(factor) => Some(Wanted::Color(present / factor)),
            Self::Luminance(lumens) | Self::Illuminance(lumens) => Some(of_lumens(lumens)),
            Self::Color(color) => {
                let level = luminance(present) / luminance(color);
                level.is_finite().then_some(Wanted::Color(color * level))
            }
            Self::Keep => Some(Wanted::Color(present)),
        }
    }

    /// Whether its number is in range.
    pub fn is_valid(self) -> bool {
        match self {
            Self::Brighter(factor) | Self::Darker(factor) => factor.is_finite() && factor >= 1.0,
            Self::Luminance(number) | Self::Illuminance(number) => number.is_finite() && number >= 0.0,
            Self::Color(color) => color.is_finite() && color.min_element() >= 0.0 && luminance(color) > 0.0,
            Self::Keep => true,
        }
    }
}
