//! The quantity that a path carries, which decides how a refracting surface scatters it.

use crate::math::Real;

/// The quantity that is transported along a path (Veach 1997, sections 3.7 and 5.2; PBR 4th ed., section 9.5.2).
///
/// A path that starts at the camera finds radiance, one that starts at a light finds importance. Where light is
/// refracted, its radiance grows with the square of the refractive index, for the same power then fills a smaller solid
/// angle. Importance does not grow. The scattering of importance is the adjoint: f*(wo, wi) = f(wi, wo).
///
/// Two things are not part of a mode. Models that say that they are not reciprocal scatter importance as they scatter
/// radiance. And the correction for shading normals (Veach 1997, section 5.3) is left to who traces importance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransportMode {
    /// The path leads from the camera to the lights.
    Radiance,
    /// The path leads from the lights to the camera.
    Importance,
}

impl TransportMode {
    /// The factor on light that is refracted to an index that is `eta` times that where it comes from.
    #[inline(always)]
    pub(crate) fn refraction_factor<R: Real>(self, eta: R) -> R {
        match self {
            Self::Radiance => eta * eta,
            Self::Importance => R::splat(1.0),
        }
    }
}
