//! The diffuse base: diffuse reflection darkened at grazing angles, retro-reflection of rough surfaces, and a flatter
//! profile that imitates subsurface scattering (Burley 2012 and 2015; the profile after Hanrahan and Krueger,
//! Reflection from Layered Surfaces due to Subsurface Scattering, SIGGRAPH 1993).

use std::f32::consts::FRAC_1_PI;

use super::schlick;
use crate::math::Real;

/// The value f |cos wi| of a white base. The cosines are the viewer's, the light's, and that between either direction
/// and the half vector, all above 0.
#[inline(always)]
pub(super) fn value<R: Real>(roughness: R, flatness: R, cos_o: R, cos_i: R, cos_half: R) -> R {
    let (one, half) = (R::ONE, R::HALF);
    let (weight_o, weight_i) = (schlick::weight(cos_o), schlick::weight(cos_i));
    // Retro-reflection at grazing angles, which grows with the roughness.
    let grazing = roughness * cos_half * cos_half;
    let retro = grazing + grazing;
    let diffuse = (one - half * weight_i) * (one - half * weight_o)
        + retro * (weight_i + weight_o + weight_i * weight_o * (retro - one));

    let profile = one.mix(grazing, weight_o) * one.mix(grazing, weight_i);
    // The cosine is multiplied in here, to avoid overflow at the horizon.
    let even = half * cos_i;
    let flat = R::splat(1.25) * (profile * (cos_i / (cos_o + cos_i) - even) + even);

    R::splat(FRAC_1_PI) * (cos_i * diffuse).mix(flat, flatness)
}
