//! Writes plugins that only this program knows in words of the format, where those have the same meaning.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{Mat4, Vec3, Vec4};

use crate::document::{Category, Child, Object, TransformOp, Value};
use crate::scene::read::is_frame;

/// The triangle that all others are made from.
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// The treatment of plugins that only this program knows and that have no equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extensions {
    /// It stays: Mitsuba refuses the file.
    Keep,
    /// The nearest that Mitsuba has takes its place.
    Approximate,
}

/// Translates the scene that will be written to `target`; the further file it needs then, if it needs one.
pub fn translate(root: &mut Object, target: &Path, extensions: Extensions) -> Option<(PathBuf, &'static str)> {
    let stem = target.file_stem().unwrap_or_default().to_string_lossy();
    let file_name = format!("{stem}.triangle.obj");
    let has_triangles = translate_inside(root, &file_name, extensions);
    has_triangles.then(|| (target.with_file_name(&file_name), TRIANGLE))
}

/// Whether there are triangles.
fn translate_inside(object: &mut Object, file_name: &str, extensions: Extensions) -> bool {
    let mut has_triangles = false;
    if extensions == Extensions::Approximate {
        // What is in a group stands where it is by itself.
        let is_frame = |child: &Child| matches!(child, Child::Object(inner) if is_frame(inner));
        object.children.retain(|child| !is_frame(child));
    }
    for child in &mut object.children {
        let Child::Object(inner) = child else { continue };
        let inner = Arc::make_mut(inner);
        has_triangles |= translate_inside(inner, file_name, extensions);
        match (inner.category, inner.plugin.as_str()) {
            (Category::Bsdf, "metal") => metal(inner, extensions),
            (Category::Bsdf, "roughconductor") if extensions == Extensions::Approximate => {
                inner
                    .properties
                    .retain(|property| property.name != "multiple_scattering");
            }
            (Category::Sensor, "thinlens") if extensions == Extensions::Approximate => inner
                .properties
                .retain(|property| !matches!(property.name.as_str(), "blades" | "blade_rotation")),
            (Category::Shape, "triangle") => {
                triangle(inner, file_name);
                has_triangles = true;
            }
            _ => {}
        }
    }
    has_triangles
}

/// Without fuzz it is a perfect mirror that is tinted. With it the nearest is a rough one: a random point of a ball of radius f moves the mirrored
/// direction by f / sqrt(5) along each axis (standard deviation), a facet of Beckmann's distribution by twice its slope, whose deviation is alpha /
/// sqrt(2); so alpha = f / sqrt(10).
fn metal(object: &mut Object, extensions: Extensions) {
    let fuzz = match value(object, "fuzz") {
        Some(Value::Float(fuzz)) => *fuzz,
        Some(Value::Integer(fuzz)) => *fuzz as f32,
        _ => 0.0,
    };
    if fuzz > 0.0 && extensions == Extensions::Keep {
        return;
    }
    object.plugin = "conductor".into();
    object.properties.retain(|property| property.name != "fuzz");
    let has_color =
        value(object, "reflectance").is_some() || object.children.iter().any(|child| child.name().is_some());
    for property in &mut object.properties {
        if property.name == "reflectance" {
            property.name = "specular_reflectance".into();
        }
    }
    for child in &mut object.children {
        if child.name() == Some("reflectance") {
            child.set_name(Some("specular_reflectance".into()));
        }
    }
    let mut whole = object.clone();
    if !has_color {
        // This is the meaning of `metal` without a colour.
        whole = whole.with("specular_reflectance", Value::Rgb(Vec3::splat(0.5)));
    }
    whole = whole.with("material", Value::String("none".to_owned()));
    if fuzz > 0.0 {
        whole.plugin = "roughconductor".into();
        whole = whole.with("distribution", Value::String("beckmann".to_owned()));
        whole = whole.with("alpha", Value::Float(fuzz / 10.0f32.sqrt()));
    }
    *object = whole;
}

/// The unit triangle of a file with the transform that takes it to its corners.
fn triangle(object: &mut Object, file_name: &str) {
    let corner = |name: &str| match value(object, name) {
        Some(Value::Point(place) | Value::Vector(place)) => *place,
        _ => Vec3::ZERO,
    };
    let [a, b, c] = ["v0", "v1", "v2"].map(corner);
    let normal = (b - a).cross(c - a).normalize_or(Vec3::Z);
    let axis = |v: Vec3| Vec4::from((v, 0.0));
    let matrix = Mat4::from_cols(axis(b - a), axis(c - a), axis(normal), Vec4::from((a, 1.0)));
    let mut steps = vec![TransformOp::Matrix(matrix)];
    if let Some(Value::Transform(further)) = value(object, "to_world") {
        steps.extend(further);
    }
    object.plugin = "obj".into();
    let replaced = ["v0", "v1", "v2", "to_world"];
    object
        .properties
        .retain(|property| !replaced.contains(&property.name.as_str()));
    *object = object
        .clone()
        .with("filename", Value::String(file_name.to_owned()))
        .with("face_normals", Value::Boolean(true))
        .with("to_world", Value::Transform(steps));
}

fn value<'o>(object: &'o Object, name: &str) -> Option<&'o Value> {
    let property = object.properties.iter().find(|property| property.name == name);
    property.map(|property| &property.value)
}
