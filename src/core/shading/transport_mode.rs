//! The quantity that a path carries, which decides how a refracting surface scatters it.

use crate::math::Real;

/// The quantity that is transported along a path (Veach 1997, sections 3.7 and 5.2; PBR 4th ed., section 9.5.2).
///
/// A path from the camera gathers radiance, one from a light carries importance. Refraction scales radiance with the
/// square of the relative index, because the same power then fills a smaller solid angle. Importance is not scaled. The
/// scattering of importance is the adjoint: f*(wo, wi) = f(wi, wo).
///
/// A mode has two exceptions. Models that are documented as not reciprocal scatter importance as they scatter radiance.
/// And the correction for shading normals (Veach 1997, section 5.3) is left to the caller that traces importance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransportMode {
    /// The path leads from the camera to the lights.
    Radiance,
    /// The path leads from the lights to the camera.
    Importance,
}

impl TransportMode {
    /// The factor on light that is refracted to an index `eta` times that of its origin.
    #[inline(always)]
    pub(crate) fn refraction_factor<R: Real>(self, eta: R) -> R {
        match self {
            Self::Radiance => eta * eta,
            Self::Importance => R::splat(1.0),
        }
    }
}
