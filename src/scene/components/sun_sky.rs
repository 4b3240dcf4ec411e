//! The sun and a clear sky.

use bevy::prelude::*;

use super::declare::declare_parameters;
use super::parameter_info::ParameterInfo;
use super::parameters::{Declared, ParameterMut, ParameterRef, PlaceAndTime, SUN_DIRECTION, SunPosition};
use crate::color::Rgb;

declare_parameters! {
    /// `sunsky`: the sky of a clear day; +z is up.
    #[derive(Reflect, Clone, Copy, Debug, PartialEq)]
    pub struct SunSky {
        /// Haziness, 1 to 10.
        turbidity: f32 = 3.0 => Number(ParameterInfo::new(
            "turbidity",
            "Turbidity",
            "Haze: how much light dust and vapour scatter, relative to clear air.",
            "1 to 10; 2 is a clear day, 3 usual, 10 hazy",
        )
        .within(1.0..=10.0)),
        /// The albedo of the ground.
        albedo: Rgb = Rgb::splat(0.3) => UniformReflectance(ParameterInfo::new(
            "albedo",
            "Ground",
            "Reflectance of the ground, which lights the sky from below.",
            "0 to 1 per channel",
        )),
        /// The factor on the radiance of the sun.
        sun_scale: f32 = 1.0 => Factor(ParameterInfo::factor("sun_scale", "Sun", "Factor on the light of the sun.")),
        /// The factor on the radiance of the sky.
        sky_scale: f32 = 1.0 => Factor(ParameterInfo::factor("sky_scale", "Sky", "Factor on the light of the sky.")),
        /// The apparent diameter of the sun in degrees; its irradiance does not depend on it.
        sun_aperture: f32 = 0.5338 => Angle(ParameterInfo::degrees(
            "sun_aperture",
            "Sun size",
            "Angle under which the sun is seen. A larger one has softer shadows and the same light.",
            "degrees, 0.01 to 179; the true one is 0.5338",
        )
        .within(0.01..=179.0)),
        /// Whether the sun is darker towards its rim.
        complex_sun: bool = false => Flag(ParameterInfo::switch(
            "complex_sun",
            "Rim darkening",
            "Lets the sun be darker and redder towards its rim, as it is.",
        )),
        /// The direction to the sun, or the place and time that determine it.
        sun: SunPosition = SunPosition::PlaceAndTime(PlaceAndTime::default()) => SunPosition(SUN_DIRECTION),
    }
}
