//! The position of the sun, as the sky's plugins take it.

use std::ops::RangeInclusive;

use bevy::prelude::*;

use super::declare::declare_parameters;
use super::parameter_info::ParameterInfo;
use super::parameters::{ParameterMut, ParameterRef};

/// The position of the sun, or the data from which it follows.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum SunPosition {
    /// Towards the sun, in the world; of any length.
    Direction(Vec3),
    /// The sun's place follows from place and time. In the light's own space x is south then and y west.
    PlaceAndTime(PlaceAndTime),
}

declare_parameters! {
    /// A place on earth and a moment at it: by default an afternoon in Tokyo, as the format has it.
    #[derive(Reflect, Clone, Copy, Debug, PartialEq)]
    pub struct PlaceAndTime {
        /// Degrees, north positive.
        latitude: f32 = 35.6894 => Angle(
            ParameterInfo::degrees("latitude", "Latitude", "Of the place, north positive.", "degrees").within(-90.0..=90.0)
        ),
        /// Degrees, east positive.
        longitude: f32 = 139.6917 => Angle(
            ParameterInfo::degrees("longitude", "Longitude", "Of the place, east positive.", "degrees").within(-360.0..=360.0)
        ),
        /// The hours that local time is ahead of universal time.
        timezone: f32 = 9.0 => Number(ParameterInfo::new(
            "timezone",
            "Time zone",
            "How far local time is ahead of universal time.",
            "hours, -24 to 24",
        )
        .within(-24.0..=24.0)
        .in_units(" h")),
        /// The year of the Gregorian calendar.
        year: i32 = 2010 => Integer(
            ParameterInfo::new("year", "Year", "Of the date.", "-4000 to 9999").within(-4000.0..=9999.0)
        ),
        /// The month, from 1.
        month: i32 = 7 => Integer(ParameterInfo::new("month", "Month", "Of the date.", "1 to 12").within(1.0..=12.0)),
        /// The day, from 1.
        day: i32 = 10 => Integer(ParameterInfo::new("day", "Day", "Of the date.", "1 to 31").within(1.0..=31.0)),
        /// The hour of local time.
        hour: f32 = 15.0 => Number(
            ParameterInfo::new("hour", "Hour", "Local time.", "hours").within(TIME).in_units(" h")
        ),
        /// The minutes, which are added to the hour.
        minute: f32 = 0.0 => Number(
            ParameterInfo::new("minute", "Minute", "Local time.", "minutes").within(TIME).in_units(" min")
        ),
        /// The seconds, which are added to the minute.
        second: f32 = 0.0 => Number(
            ParameterInfo::new("second", "Second", "Local time.", "seconds").within(TIME).in_units(" s")
        ),
    }
}

/// The range of times, which may be outside of the day; larger ones are mistakes.
const TIME: RangeInclusive<f32> = -1e5..=1e5;

pub(crate) const SUN_DIRECTION: ParameterInfo = ParameterInfo::new(
    "sun_direction",
    "Towards sun",
    "Direction in which the sun stands, in the space of the light: z is up.",
    "a vector of any length",
);
