//! Writes media with standard parameters: coefficients as extinction and albedo, and colours above 1 so that they are
//! not taken for reflectances.

use super::patch::value_of;
use crate::color::Rgb;
use crate::document::{Category, Object, Value};
use crate::scene::Coefficients;
use crate::scene::components::medium::{ALBEDO, SIGMA_A, SIGMA_S, SIGMA_T};

/// `is_approximate`: emission of media is left out, since the format has no parameter for it.
pub(super) fn medium(object: &mut Object, is_approximate: bool) {
    if is_approximate {
        let is_ours = |name: &str| matches!(name, "emission" | "emission_scale");
        object.properties.retain(|property| !is_ours(&property.name));
        object.children.retain(|child| !child.name().is_some_and(is_ours));
    }
    join_coefficients(object);
    wrap_colors(object);
}

/// Turns scattering and absorption into extinction and albedo. Animated ones stay, because the quotient of two tracks
/// is not a track.
fn join_coefficients(object: &mut Object) {
    let is_joined = |name: &str| [&SIGMA_S, &SIGMA_A].iter().any(|info| info.name == name);
    let mut properties = object.properties.iter();
    if properties.any(|property| is_joined(&property.name) && property.keys.is_some()) {
        return;
    }
    let [sigma_s, sigma_a] = [SIGMA_S.name, SIGMA_A.name].map(|name| value_of(object, name).and_then(color));
    if sigma_s.is_none() && sigma_a.is_none() {
        return;
    }
    let separate = Coefficients::Separate {
        sigma_s: sigma_s.unwrap_or_default(),
        sigma_a: sigma_a.unwrap_or_default(),
    };
    object.properties.retain(|property| !is_joined(&property.name));
    let (sigma_t, albedo) = separate.sigma_t_and_albedo();
    let mut joined = object.clone();
    for (info, volume) in [(&SIGMA_T, sigma_t), (&ALBEDO, albedo)] {
        joined = joined.with(info.name, Value::Rgb(volume.constant().unwrap_or_default()));
    }
    *object = joined;
}

/// Puts coefficients above 1 into constant volumes: a colour without one is taken for a reflectance, which must not
/// exceed 1.
fn wrap_colors(object: &mut Object) {
    let is_large = |value: &Value| matches!(value, Value::Rgb(color) if color.max_element() > 1.0);
    while let Some(place) = object.properties.iter().position(|property| is_large(&property.value)) {
        let mut property = object.properties.remove(place);
        let mut volume = Object::new(Category::Volume, "constvolume");
        volume.name = Some(std::mem::replace(&mut property.name, "value".into()));
        volume.properties.push(property);
        object.children.push(volume.into());
    }
}

fn color(value: &Value) -> Option<Rgb> {
    match value {
        Value::Rgb(color) => Some(*color),
        Value::Float(number) | Value::Spectrum(number) => Some(Rgb::splat(*number)),
        Value::Integer(number) => Some(Rgb::splat(*number as f32)),
        _ => None,
    }
}
