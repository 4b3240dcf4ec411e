//! Sheen: the light that cloth adds at grazing angles (Burley 2012).

use super::schlick;
use crate::color::Rgb;

/// The value f |cos wi|. `tint` takes it from white to the hue of `base_color`; the cosines are of the light and of its angle to the half vector,
/// above 0.
pub(super) fn value(base_color: Rgb, tint: f32, cos_i: f32, cos_half: f32) -> Rgb {
    Rgb::ONE.lerp(schlick::tint(base_color), tint) * (schlick::weight(cos_half) * cos_i)
}
