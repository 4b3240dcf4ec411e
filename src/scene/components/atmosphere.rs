//! The emission of a `sunsky`: sun and sky.

use bevy::math::Mat3;

use crate::light::{Atmosphere, PlaceAndTime};
use crate::scene::{SunPosition, SunSky};

impl SunSky {
    /// The atmosphere in the light's own space, which `world_from_local` rotates to the world. None if the sun has no
    /// direction.
    pub fn atmosphere(&self, world_from_local: Mat3) -> Option<Atmosphere> {
        let sun_direction = match self.sun {
            SunPosition::Direction(direction) => world_from_local.transpose() * direction.try_normalize()?,
            SunPosition::PlaceAndTime(at) => PlaceAndTime {
                latitude: at.latitude.into(),
                longitude: at.longitude.into(),
                timezone: at.timezone.into(),
                year: at.year,
                month: at.month,
                day: at.day,
                hour: at.hour.into(),
                minute: at.minute.into(),
                second: at.second.into(),
            }
            .sun_direction(),
        };
        sun_direction.is_finite().then_some(Atmosphere {
            turbidity: self.turbidity,
            albedo: self.albedo,
            sun_direction,
            sky_scale: self.sky_scale,
            sun_scale: self.sun_scale,
            sun_aperture: self.sun_aperture.to_radians(),
            limb_darkening: self.complex_sun,
        })
    }
}
