//! The sun and a clear sky.

use bevy::prelude::*;

use super::emitter_parameters::{EmitterVisitor, POSITIVE, PlaceAndTime, SunPosition};
use crate::color::Rgb;

/// `sunsky`: the sky of a clear day; +z is up.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub struct SunSky {
    /// Haziness, 1 to 10.
    pub turbidity: f32,
    /// The albedo of the ground.
    pub albedo: Rgb,
    /// The direction to the sun, or a place and time that it follows from.
    pub sun: SunPosition,
    /// Factors on the radiance of each.
    pub sun_scale: f32,
    /// See `sun_scale`.
    pub sky_scale: f32,
    /// Angle in degrees under which the sun is seen; how much light it sends does not depend on it.
    pub sun_aperture: f32,
    /// Whether the sun is darker towards its rim.
    pub complex_sun: bool,
}

impl Default for SunSky {
    fn default() -> Self {
        Self {
            turbidity: 3.0,
            albedo: Rgb::splat(0.3),
            sun: SunPosition::PlaceAndTime(PlaceAndTime::default()),
            sun_scale: 1.0,
            sky_scale: 1.0,
            sun_aperture: 0.5338,
            complex_sun: false,
        }
    }
}

impl SunSky {
    pub(super) fn visit(&mut self, visitor: &mut impl EmitterVisitor) {
        visitor.number("turbidity", &mut self.turbidity, 1.0..=10.0);
        visitor.uniform_reflectance("albedo", &mut self.albedo);
        visitor.number("sun_scale", &mut self.sun_scale, POSITIVE);
        visitor.number("sky_scale", &mut self.sky_scale, POSITIVE);
        visitor.angle("sun_aperture", &mut self.sun_aperture, 0.01..=179.0);
        visitor.flag("complex_sun", &mut self.complex_sun);
        visitor.sun_position(&mut self.sun);
        if let SunPosition::PlaceAndTime(at) = &mut self.sun {
            at.visit(visitor);
        }
    }
}
