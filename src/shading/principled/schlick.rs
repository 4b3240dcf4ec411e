//! Schlick's interpolation from the reflectance at normal incidence to 1 at grazing angles, and the hue that tints pull towards.

use crate::color::{Rgb, luminance};
use crate::shading::fresnel::DielectricFresnel;

/// The interpolation's weight (1 - cos)^5: 0 at normal incidence, 1 at grazing angles.
pub(super) fn weight(cos: f32) -> f32 {
    (1.0 - cos).clamp(0.0, 1.0).powi(5)
}

/// The weight of a facet met with cosine `cos`, in the angle on the thinner side: it meets total internal reflection without a jump.
pub(super) fn facet_weight(cos: f32, fresnel: &DielectricFresnel) -> f32 {
    weight(if fresnel.eta_it > 1.0 { cos } else { fresnel.cos_t.abs() })
}

/// Reflectance of a facet that reflects `color` at normal incidence.
pub(super) fn interpolated(color: Rgb, cos: f32, fresnel: &DielectricFresnel) -> Rgb {
    color.lerp(Rgb::ONE, facet_weight(cos, fresnel))
}

/// Reflectance of a facet that at normal incidence reflects as much as a dielectric of index `eta`, in the hue of `color`.
pub(super) fn tinted(color: Rgb, eta: f32, cos: f32, fresnel: &DielectricFresnel) -> Rgb {
    let normal = ((eta - 1.0) / (eta + 1.0)).powi(2);
    interpolated(normal * tint(color), cos, fresnel)
}

/// The hue and saturation of a colour: the colour over its luminance; white for black.
pub(super) fn tint(color: Rgb) -> Rgb {
    let luminance = luminance(color);
    if luminance > 0.0 { color / luminance } else { Rgb::ONE }
}
