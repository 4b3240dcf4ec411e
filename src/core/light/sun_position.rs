//! Computes the position of the sun.
//!
//! The PSA algorithm: Blanco-Muriel, Alarcon-Padilla, Lopez-Moratalla and Lara-Coira, "Computing the Solar Vector",
//! Solar Energy 70(5), 2001. Its error is half a minute of arc from 1999 to 2015, and reaches degrees only after
//! centuries.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

/// A place on earth and a local time there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceAndTime {
    /// Degrees, north and east positive.
    pub latitude: f64,
    /// Degrees, east positive.
    pub longitude: f64,
    /// The hours that local time is ahead of universal time.
    pub timezone: f64,
    /// The year of the Gregorian calendar.
    pub year: i32,
    /// The month, from 1 to 12.
    pub month: i32,
    /// The day, from 1 to 31.
    pub day: i32,
    /// The hour of local time; it may be outside of the day.
    pub hour: f64,
    /// The minutes, which are added to the hour; they may be outside of [0, 60).
    pub minute: f64,
    /// The seconds, which are added to the minute; they may be outside of [0, 60).
    pub second: f64,
}

/// Noon of 1 January 2000 as a Julian day.
const EPOCH: i64 = 2_451_545;

/// Mean radius of the earth over its distance from the sun.
const PARALLAX: f64 = 6371.01 / 149_597_890.0;

impl PlaceAndTime {
    /// The unit vector to the sun, z up. Seen from above x points south and y west, as in Mitsuba 3 (whose manual says
    /// otherwise).
    pub fn sun_direction(&self) -> Vec3 {
        let hours = self.hour - self.timezone + (self.minute + self.second / 60.0) / 60.0;
        let days = (self.julian_day() - EPOCH) as f64 - 0.5 + hours / 24.0;

        let node = 2.1429 - 0.001_039_459_4 * days;
        let mean_longitude = 4.895_063_0 + 0.017_202_791_698 * days;
        let anomaly = 6.240_060_0 + 0.017_201_969_9 * days;
        let longitude = mean_longitude + 0.033_416_07 * anomaly.sin() + 0.000_348_94 * (2.0 * anomaly).sin()
            - 0.000_113_4
            - 0.000_020_3 * node.sin();
        let obliquity = 0.409_092_8 - 6.214_0e-9 * days + 0.000_039_6 * node.cos();

        let right_ascension = (obliquity.cos() * longitude.sin()).atan2(longitude.cos());
        let declination = (obliquity.sin() * longitude.sin()).asin();

        let greenwich_sidereal = 6.697_424_324_2 + 0.065_709_828_3 * days + hours;
        let hour_angle = (greenwich_sidereal * 15.0 + self.longitude).to_radians() - right_ascension;
        let latitude = self.latitude.to_radians();
        let up = latitude.cos() * hour_angle.cos() * declination.cos() + declination.sin() * latitude.sin();
        let zenith = up.clamp(-1.0, 1.0).acos();
        let zenith = zenith + PARALLAX * zenith.sin();
        let north = declination.tan() * latitude.cos() - latitude.sin() * hour_angle.cos();
        let from_north = (-hour_angle.sin()).atan2(north).rem_euclid(TAU);
        let (sin, cos) = (from_north - PI).sin_cos();
        DVec3::new(zenith.sin() * cos, zenith.sin() * sin, zenith.cos()).as_vec3()
    }

    /// The Julian day that begins at noon of the date (Fliegel and Van Flandern 1968).
    fn julian_day(&self) -> i64 {
        let [year, month, day] = [self.year, self.month, self.day].map(i64::from);
        let early = (month - 14) / 12;
        1461 * (year + 4800 + early) / 4 + 367 * (month - 2 - 12 * early) / 12 - 3 * ((year + 4900 + early) / 100) / 4
            + day
            - 32_075
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(latitude: f64, month: i32, day: i32, universal_hour: f64) -> Vec3 {
        PlaceAndTime {
            latitude,
            longitude: 0.0,
            timezone: 0.0,
            year: 2010,
            month,
            day,
            hour: universal_hour,
            minute: 0.0,
            second: 0.0,
        }
        .sun_direction()
    }

    /// Checks the culmination at Greenwich, 2010: the equation of time gives the moment, and declination and latitude
    /// give the height.
    #[test]
    fn the_sun_culminates_in_the_south() {
        // The columns are month, day, declination in degrees, and minutes after 12:00 (Astronomical Almanac, rounded).
        for (month, day, declination, minutes) in [(3, 20, -0.09, 7.5), (6, 21, 23.44, 1.8), (11, 3, -15.1, -16.4)] {
            let sun = at(51.48, month, day, 12.0 + minutes / 60.0);
            let height = f64::from(sun.z).asin().to_degrees();
            assert!(
                (height - (90.0 - 51.48 + declination)).abs() < 0.15,
                "{month}: {height}"
            );
            assert!(sun.x > 0.0 && f64::from(sun.y).abs() < 0.01, "{month}: {sun}");
        }
    }

    #[test]
    fn the_sun_rises_in_the_east() {
        assert!(at(51.48, 6, 21, 6.0).y < -0.5);
        assert!(at(51.48, 6, 21, 18.0).y > 0.5);
        assert!(at(51.48, 6, 21, 0.0).z < 0.0);
    }

    #[test]
    fn time_zones_move_the_clock_only() {
        let tokyo = PlaceAndTime {
            latitude: 35.689,
            longitude: 139.6917,
            timezone: 9.0,
            year: 2010,
            month: 7,
            day: 10,
            hour: 3.0,
            minute: 20.0,
            second: 30.0,
        };
        let universal = PlaceAndTime {
            timezone: 0.0,
            day: 9,
            hour: 18.0,
            ..tokyo
        };
        assert!(tokyo.sun_direction().abs_diff_eq(universal.sun_direction(), 1e-6));
    }
}
