//! Schlick's interpolation from the reflectance at normal incidence to 1 at grazing angles, and the hue of tints.

use crate::color::LUMINANCE;
use crate::math::{Real, Vector};
use crate::shading::fresnel::DielectricFresnel;

/// The interpolation's weight (1 - cos)^5: 0 at normal incidence, 1 at grazing angles.
#[inline(always)]
pub(super) fn weight<R: Real>(cos: R) -> R {
    let grazing = (R::ONE - cos).saturated();
    grazing.squared().squared() * grazing
}

/// The weight for a facet met with cosine `cos`, in the angle on the thinner side: it is continuous at total internal
/// reflection.
#[inline(always)]
pub(super) fn facet_weight<R: Real>(cos: R, fresnel: &DielectricFresnel<R>) -> R {
    weight(R::select(fresnel.eta_it.is_more(R::ONE), cos, fresnel.cos_t.abs()))
}

/// Reflectance of a facet that reflects `color` at normal incidence.
#[inline(always)]
pub(super) fn interpolated<R: Real>(color: R::Vec3, cos: R, fresnel: &DielectricFresnel<R>) -> R::Vec3 {
    color.mix(R::Vec3::even(R::ONE), facet_weight(cos, fresnel))
}

/// Reflectance of a facet that at normal incidence reflects as much as a dielectric of index `eta`, in the hue of
/// `color`.
#[inline(always)]
pub(super) fn tinted<R: Real>(color: R::Vec3, eta: R, cos: R, fresnel: &DielectricFresnel<R>) -> R::Vec3 {
    let normal = ((eta - R::ONE) / (eta + R::ONE)).squared();
    interpolated(tint::<R>(color) * normal, cos, fresnel)
}

/// The hue and saturation of a colour: the colour over its luminance; black gives white.
#[inline(always)]
pub(super) fn tint<R: Real>(color: R::Vec3) -> R::Vec3 {
    let luminance = color.dot(R::Vec3::same(LUMINANCE));
    let is_colored = R::is_above(luminance, f32::MIN_POSITIVE);
    R::Vec3::select(is_colored, color / luminance, R::Vec3::even(R::ONE))
}
