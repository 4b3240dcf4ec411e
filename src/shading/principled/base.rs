//! The diffuse base: diffuse reflection darkened at grazing angles, retro-reflection of rough surfaces, and a flatter profile that
//! imitates subsurface scattering (Burley 2012 and 2015; the profile after Hanrahan and Krueger, Reflection from Layered Surfaces due to
//! Subsurface Scattering, SIGGRAPH 1993).

use glam::FloatExt;
use std::f32::consts::FRAC_1_PI;

use super::schlick;

/// The value f |cos wi| of a white base. It takes the cosines of viewer, light, and of the angle from either to their half vector, all above 0.
pub(super) fn value(roughness: f32, flatness: f32, cos_o: f32, cos_i: f32, cos_half: f32) -> f32 {
    let (weight_o, weight_i) = (schlick::weight(cos_o), schlick::weight(cos_i));
    // Light that leaves at grazing angles where it came in: more, the rougher the surface.
    let retro = 2.0 * roughness * cos_half * cos_half;
    let diffuse = (1.0 - 0.5 * weight_i) * (1.0 - 0.5 * weight_o)
        + retro * (weight_i + weight_o + weight_i * weight_o * (retro - 1.0));

    let grazing = 0.5 * retro;
    let profile = 1f32.lerp(grazing, weight_o) * 1f32.lerp(grazing, weight_i);
    // The cosine is multiplied in here, so that nothing overflows at the horizon.
    let flat = 1.25 * (profile * (cos_i / (cos_o + cos_i) - 0.5 * cos_i) + 0.5 * cos_i);

    FRAC_1_PI * (cos_i * diffuse).lerp(flat, flatness)
}
