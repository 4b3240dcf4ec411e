//! The names of old files (0.5, 0.6) in today's spelling.

use glam::Vec3;
use smol_str::SmolStr;

use super::{Category, Diagnostics, Object, Property, TransformOp, Value};

/// The name in snake_case: `toWorld` becomes `to_world`, `intIOR` becomes `int_ior`; names in snake_case stay.
pub fn snake_case(name: &str) -> SmolStr {
    if name.len() == 1 || !name.bytes().any(|byte| byte.is_ascii_uppercase()) {
        return name.into();
    }
    let mut result = String::with_capacity(name.len() + 4);
    let mut after_lower = false;
    for c in name.chars() {
        if c.is_ascii_uppercase() {
            if after_lower {
                result.push('_');
            }
            result.push(c.to_ascii_lowercase());
            after_lower = false;
        } else {
            result.push(c);
            after_lower = c.is_ascii_lowercase();
        }
    }
    result.into()
}

const OLD_REFLECTANCE: &str = "diffuse_reflectance";
const REFLECTANCE: SmolStr = SmolStr::new_static("reflectance");

/// Renames a parameter of `object` that has another name in version 0.x.
pub fn rename(object: &Object, name: &mut SmolStr) {
    if is_diffuse(object) && name.as_str() == OLD_REFLECTANCE {
        *name = REFLECTANCE;
    }
}

fn is_diffuse(object: &Object) -> bool {
    object.category == Category::Bsdf && object.plugin == "diffuse"
}

/// Modernises a finished object of version 0.x, whose properties have today's names.
pub fn modernize(object: &mut Object, diagnostics: &mut Diagnostics) {
    if is_diffuse(object) {
        for child in &mut object.children {
            if child.name() == Some(OLD_REFLECTANCE) {
                child.set_name(Some(REFLECTANCE));
            }
        }
    }
    if object.category == Category::Texture {
        texture_offset_and_scale(object, diagnostics);
    }
}

/// Turns `uoffset`, `voffset`, `uscale`, `vscale` into the transform `to_uv`, which must not be given as well.
fn texture_offset_and_scale(object: &mut Object, diagnostics: &mut Diagnostics) {
    let mut offset = Vec3::ZERO;
    let mut scale = Vec3::ONE;
    let mut span = None;
    object.properties.retain(|property| {
        let target = match property.name.as_str() {
            "uoffset" => &mut offset.x,
            "voffset" => &mut offset.y,
            "uscale" => &mut scale.x,
            "vscale" => &mut scale.y,
            _ => return true,
        };
        match property.value {
            Value::Float(number) => *target = number,
            Value::Integer(number) => *target = number as f32,
            _ => return true,
        }
        span.get_or_insert(property.span);
        false
    });
    let Some(span) = span else { return };
    if object.properties.iter().any(|property| property.name == "to_uv") {
        let message = "offset and scale of a texture are given both as `to_uv` and as numbers of their own";
        diagnostics.error(span, message);
    } else {
        let steps = vec![TransformOp::Translate(offset), TransformOp::Scale(scale)];
        object
            .properties
            .push(Property::new("to_uv", Value::Transform(steps), span));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn camel_case_becomes_snake_case() {
        for (old, new) in [
            ("toWorld", "to_world"),
            ("intIOR", "int_ior"),
            ("maxDepth", "max_depth"),
            ("to_world", "to_world"),
            ("sigmaT", "sigma_t"),
            ("fovAxis", "fov_axis"),
            ("k", "k"),
            ("Ünder", "Ünder"),
            ("bsdf_2A", "bsdf_2a"),
        ] {
            assert_eq!(snake_case(old), new);
        }
    }
}
