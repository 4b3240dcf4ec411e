//! Parses value tags: `<float name= value=>` to `<rgb>`, and the steps of a `<transform>`.

use std::borrow::Cow;
use std::fmt::Display;

use glam::{Mat4, Vec3};

use super::spectrum::{CLAMPED, Role, SampledSpectrum};
use super::tag::Tag;
use super::transform::{direction, left_of};
use super::value::{self, unexpected};
use super::{Diagnostics, Span, TransformOp, Value};

/// The tags of single values; a transform has children and is not one.
pub const VALUE_TAGS: [&str; 9] = [
    "float", "integer", "boolean", "string", "point", "vector", "rgb", "srgb", "spectrum",
];

pub const TRANSFORM_TAGS: [&str; 5] = ["translate", "rotate", "scale", "matrix", "lookat"];

/// The value of a value tag other than `<spectrum>`; None after an error, which has been reported.
pub fn read_value(tag: &mut Tag, diagnostics: &mut Diagnostics) -> Option<Value> {
    if matches!(tag.name, "point" | "vector") && !tag.has("value") {
        let mut axis = |name| Some(number(tag.need(name, diagnostics)?, diagnostics));
        let (x, y, z) = (axis("x"), axis("y"), axis("z"));
        let xyz = Vec3::new(x??, y??, z??);
        return Some(point_or_vector(tag, xyz));
    }
    if tag.name == "string" {
        let given = tag.has("value");
        let text = tag.take("value");
        if !given {
            diagnostics.error(tag.span, "<string> needs the attribute `value`");
        }
        return text.map(|(text, _)| Value::String(text.into_owned()));
    }
    let (text, span) = tag.need("value", diagnostics)?;
    let parsed = match tag.name {
        "float" => value::parse_float(&text).map(Value::Float),
        "integer" => value::parse_integer(&text).map(Value::Integer),
        "boolean" => value::parse_boolean(&text).map(Value::Boolean),
        "rgb" => value::parse_rgb(&text).map(Value::Rgb),
        "srgb" => value::parse_srgb(&text).map(Value::Rgb),
        _ => value::parse_vec3_or_splat(&text).map(|xyz| point_or_vector(tag, xyz)),
    };
    report(parsed, span, diagnostics)
}

fn point_or_vector(tag: &Tag, xyz: Vec3) -> Value {
    match tag.name {
        "point" => Value::Point(xyz),
        _ => Value::Vector(xyz),
    }
}

/// A spectrum given in `value`: a number, a colour like `#ff8000`, or a list of wavelengths.
pub fn read_spectrum(text: &str, span: Span, role: Role, diagnostics: &mut Diagnostics) -> Option<Value> {
    if text.trim().starts_with('#') {
        return report(value::parse_rgb(text).map(Value::Rgb), span, diagnostics);
    }
    if text.contains(':') {
        let sampled = report(SampledSpectrum::parse_list(text), span, diagnostics)?;
        return Some(color_of_spectrum(sampled.to_rgb(role), span, diagnostics));
    }
    let number = value::parse_float(text).map_err(|_| unexpected("a number or `wavelength:value` pairs", text));
    report(number.map(Value::Spectrum), span, diagnostics)
}

/// The value for a spectrum's colour. Warns if the colour was `clamped` and thus differs from that of the spectrum.
pub fn color_of_spectrum((rgb, clamped): (Vec3, bool), span: Span, diagnostics: &mut Diagnostics) -> Value {
    if clamped {
        diagnostics.warn(span, CLAMPED);
    }
    Value::Rgb(rgb)
}

/// The largest difference from 1 of the length of an axis without a warning: rounding to three digits leaves it.
const UNIT_AXIS: f32 = 1e-3;

/// One step of a transform; None after an error, which has been reported.
pub fn read_transform_op(tag: &mut Tag, diagnostics: &mut Diagnostics) -> Option<TransformOp> {
    match tag.name {
        "translate" => Some(TransformOp::Translate(xyz(tag, 0.0, diagnostics)?)),
        "scale" => Some(TransformOp::Scale(xyz(tag, 1.0, diagnostics)?)),
        "rotate" => {
            let axis = xyz(tag, 0.0, diagnostics);
            let degrees = number(tag.need("angle", diagnostics)?, diagnostics)?;
            let axis = axis?;
            if axis == Vec3::ZERO {
                diagnostics.error(tag.span, "the axis of a rotation cannot be zero");
                return None;
            }
            let length = axis.length();
            if (length - 1.0).abs() > UNIT_AXIS {
                diagnostics.warn(
                    tag.span,
                    format!("the axis of the rotation has the length {length}, not 1: it also scales, as in Mitsuba 3"),
                );
            }
            Some(TransformOp::Rotate { axis, degrees })
        }
        "matrix" => matrix(tag, diagnostics),
        _ => look_at(tag, diagnostics),
    }
}

/// Parses `value="x, y, z"`, `value="all"`, or any of `x`, `y`, `z`.
fn xyz(tag: &mut Tag, absent: f32, diagnostics: &mut Diagnostics) -> Option<Vec3> {
    if tag.has("value") {
        if ["x", "y", "z"].iter().any(|axis| tag.has(axis)) {
            diagnostics.error(tag.span, "give either `value` or `x`, `y`, `z`, not both");
        }
        let (text, span) = tag.need("value", diagnostics)?;
        return report(value::parse_vec3_or_splat(&text), span, diagnostics);
    }
    let mut axis = |name| {
        let given = tag.has(name);
        match tag.take(name) {
            Some(attribute) => number(attribute, diagnostics),
            None => (!given).then_some(absent),
        }
    };
    let (x, y, z) = (axis("x"), axis("y"), axis("z"));
    Some(Vec3::new(x?, y?, z?))
}

fn matrix(tag: &mut Tag, diagnostics: &mut Diagnostics) -> Option<TransformOp> {
    let (text, span) = tag.need("value", diagnostics)?;
    let numbers = report(value::parse_floats(&text), span, diagnostics)?;
    let matrix = match numbers.len() {
        9 => {
            let rows: Vec<[f32; 4]> = numbers
                .chunks_exact(3)
                .map(|row| [row[0], row[1], row[2], 0.0])
                .collect();
            Mat4::from_cols_array_2d(&[rows[0], rows[1], rows[2], [0.0, 0.0, 0.0, 1.0]]).transpose()
        }
        16 => Mat4::from_cols_slice(&numbers).transpose(),
        count => {
            let found = if count > 16 {
                "more".to_owned()
            } else {
                count.to_string()
            };
            diagnostics.error(span, format!("a matrix has 16 numbers, or 9, found {found}"));
            return None;
        }
    };
    // Exporters leave rounding errors in the last row; larger values are a projection.
    if !matrix.row(3).abs_diff_eq(glam::Vec4::W, 1e-4) {
        diagnostics.error(span, "the last row of the matrix should be 0 0 0 1");
        return None;
    }
    let mut affine = matrix.transpose();
    affine.w_axis = glam::Vec4::W;
    Some(TransformOp::Matrix(affine.transpose()))
}

fn look_at(tag: &mut Tag, diagnostics: &mut Diagnostics) -> Option<TransformOp> {
    let up_given = tag.has("up");
    let up = tag.take("up");
    let origin = tag.need("origin", diagnostics);
    let target = tag.need("target", diagnostics);
    let mut corner = |attribute: Option<(Cow<str>, Span)>| {
        let (text, span) = attribute?;
        report(value::parse_vec3(&text), span, diagnostics)
    };
    let (origin, target, up) = (corner(origin), corner(target), corner(up));
    let (origin, target) = (origin?, target?);
    let Some(forward) = direction(origin, target) else {
        diagnostics.error(
            tag.span,
            "`target` is where `origin` is: there is no direction to look in",
        );
        return None;
    };
    let up = match up {
        None if up_given => return None,
        None | Some(Vec3::ZERO) => any_up(forward.as_vec3()),
        Some(up) => up,
    };
    if left_of(forward, up).is_none() {
        diagnostics.error(tag.span, "`up` points along the direction from `origin` to `target`");
        return None;
    }
    Some(TransformOp::LookAt { origin, target, up })
}

/// The up direction if the file gives none: the first tangent of Duff et al., "Building an Orthonormal Basis,
/// Revisited" (2017).
fn any_up(n: Vec3) -> Vec3 {
    let sign = 1.0_f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    Vec3::new(1.0 + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x)
}

fn number((text, span): (Cow<str>, Span), diagnostics: &mut Diagnostics) -> Option<f32> {
    report(value::parse_float(&text), span, diagnostics)
}

fn report<T>(parsed: Result<T, impl Display>, span: Span, diagnostics: &mut Diagnostics) -> Option<T> {
    parsed.map_err(|error| diagnostics.error(span, error.to_string())).ok()
}
