//! Lights as the user knows them. Radiometric units; no photometry.

use bevy::prelude::*;

use super::{DocumentOrder, ToWorld};
use crate::color::Rgb;

/// Makes a shape emit `radiance` (W/(m^2 sr)) from its front, evenly in all directions.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, PartialEq)]
pub struct AreaLight {
    pub radiance: Rgb,
}

/// A light that is no surface; where and whereto is [`ToWorld`].
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component, PartialEq)]
#[require(ToWorld, DocumentOrder)]
pub enum Emitter {
    /// Radiant intensity, W/sr.
    Point { intensity: Rgb },
    /// Irradiance on a surface that faces the light, W/m^2.
    Directional { irradiance: Rgb },
    /// The same radiance from every direction, W/(m^2 sr).
    Constant { radiance: Rgb },
}

impl Default for Emitter {
    fn default() -> Self {
        Self::Constant { radiance: Rgb::ONE }
    }
}
