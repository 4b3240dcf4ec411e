//! Sheen: the light that cloth adds at grazing angles (Burley 2012).

use super::schlick;
use crate::math::{Real, Vector};

/// The value f |cos wi|. `tint` takes it from white to the hue of `base_color`; the cosines are of the light and of its
/// angle to the half vector, above 0.
#[inline(always)]
pub(super) fn value<R: Real>(base_color: R::Vec3, tint: R, cos_i: R, cos_half: R) -> R::Vec3 {
    R::Vec3::even(R::ONE).mix(schlick::tint::<R>(base_color), tint) * (schlick::weight(cos_half) * cos_i)
}
