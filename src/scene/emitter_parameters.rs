//! The kinds of parameters that lights have, and the visitor that meets them.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use bevy::prelude::*;

use super::{FovAxis, Parameter, ParameterVisitor, Texture};
use crate::color::Rgb;

/// Meets the parameters of a light in turn; names are those of the file. What a visitor leaves alone keeps its value, which in a fresh
/// light is the format's default.
pub(crate) trait EmitterVisitor: ParameterVisitor {
    /// What is sent out: not negative, without upper bound.
    fn emission(&mut self, name: &'static str, value: &mut Rgb);
    fn textured_emission(&mut self, name: &'static str, value: &mut Parameter<Rgb>);
    /// A share of the light, 0 to 1, the same everywhere.
    fn uniform_reflectance(&mut self, name: &'static str, value: &mut Rgb);
    fn integer(&mut self, name: &'static str, value: &mut i32, range: RangeInclusive<i32>);
    /// Degrees.
    fn angle(&mut self, name: &'static str, value: &mut f32, range: RangeInclusive<f32>);
    /// A file.
    fn picture(&mut self, name: &'static str, value: &mut PathBuf);
    fn optional_texture(&mut self, name: &'static str, value: &mut Option<Texture>);
    /// `cutoff_angle` and `beam_width`.
    fn cone(&mut self, cutoff_angle: &mut f32, beam_width: &mut f32);
    /// `fov` and `fov_axis`.
    fn field_of_view(&mut self, fov: &mut f32, axis: &mut FovAxis);
    /// Which of the two it is, and `sun_direction`.
    fn sun_position(&mut self, value: &mut SunPosition);
    fn sampling_weight(&mut self, value: &mut f32);
}

/// For factors.
pub(super) const POSITIVE: RangeInclusive<f32> = 0.0..=f32::MAX;

/// Where the sun stands, or what that follows from.
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
    /// Degrees, east positive.
    pub longitude: f32,
    /// Hours that local time is ahead of universal time.
    pub timezone: f32,
    /// In the Gregorian calendar.
    pub year: i32,
    /// From 1.
    pub month: i32,
    /// From 1.
    pub day: i32,
    /// Local time.
    pub hour: f32,
    /// Added to the hour.
    pub minute: f32,
    /// Added to the minute.
    pub second: f32,
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

impl PlaceAndTime {
    /// The parameters.
    pub(crate) const NAMES: [&'static str; 9] = [
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

    pub(super) fn visit(&mut self, visitor: &mut impl EmitterVisitor) {
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
