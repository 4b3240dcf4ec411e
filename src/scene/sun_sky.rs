//! The sun and a clear sky, and where the sun stands.

use std::ops::RangeInclusive;

use bevy::prelude::*;

use super::emitter::{EmitterVisitor, POSITIVE};
use crate::color::Rgb;

/// `sunsky`: a clear day; +z is up.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub struct SunSky {
    /// Haziness, 1 to 10.
    pub turbidity: f32,
    /// Of the ground.
    pub albedo: Rgb,
    pub sun: SunPosition,
    /// Factors on the radiance of each.
    pub sun_scale: f32,
    pub sky_scale: f32,
    /// Angle in degrees under which the sun is seen; how much light it sends does not depend on it.
    pub sun_aperture: f32,
    /// Whether the sun is darker towards its rim.
    pub complex_sun: bool,
}

#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum SunPosition {
    /// Towards the sun, in the world; of any length.
    Direction(Vec3),
    /// In the light's own space x is south then and y west.
    PlaceAndTime(PlaceAndTime),
}

/// A place on earth and a moment at it.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub struct PlaceAndTime {
    /// Degrees, north and east positive.
    pub latitude: f32,
    pub longitude: f32,
    /// Hours that local time is ahead of universal time.
    pub timezone: f32,
    pub year: i32,
    /// From 1.
    pub month: i32,
    pub day: i32,
    /// Local time.
    pub hour: f32,
    pub minute: f32,
    pub second: f32,
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

impl Default for PlaceAndTime {
    /// An afternoon in Tokyo, as the format has it.
    fn default() -> Self {
        Self {
            latitude: 35.6894,
            longitude: 139.6917,
            timezone: 9.0,
            year: 2010,
            month: 7,
            day: 10,
            hour: 15.0,
            minute: 0.0,
            second: 0.0,
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

impl PlaceAndTime {
    /// The parameters.
    pub const NAMES: [&'static str; 9] = [
        "latitude",
        "longitude",
        "timezone",
        "year",
        "month",
        "day",
        "hour",
        "minute",
        "second",
    ];

    fn visit(&mut self, visitor: &mut impl EmitterVisitor) {
        // Times may lie outside of the day; what is far from all reason is a slip.
        const TIME: RangeInclusive<f32> = -1e5..=1e5;
        visitor.angle("latitude", &mut self.latitude, -90.0..=90.0);
        visitor.angle("longitude", &mut self.longitude, -360.0..=360.0);
        visitor.number("timezone", &mut self.timezone, -24.0..=24.0);
        visitor.integer("year", &mut self.year, -4000..=9999);
        visitor.integer("month", &mut self.month, 1..=12);
        visitor.integer("day", &mut self.day, 1..=31);
        visitor.number("hour", &mut self.hour, TIME);
        visitor.number("minute", &mut self.minute, TIME);
        visitor.number("second", &mut self.second, TIME);
    }
}
