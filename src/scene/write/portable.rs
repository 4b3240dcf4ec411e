//! Translates plugins that only this program has to standard ones with the same meaning.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{Mat4, Vec3, Vec4};

use super::patch::value_of;
use super::portable_medium::medium;
use crate::document::{Category, Child, Object, TransformOp, Value};
use crate::layer::Layer;
use crate::scene::assets::solid_mesh::solid_ply;
use crate::scene::components::wall_openings::parse_openings;
use crate::scene::read::is_frame;
use crate::scene::{Declared, Emitter, ParameterMut, Solid};

/// The triangle mesh of which all single triangles are instances.
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// The treatment of plugins that only this program has and that have no equivalent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extensions {
    /// They are kept: Mitsuba refuses the file.
    Keep,
    /// The closest plugin of Mitsuba replaces them.
    Approximate,
}

/// Translates the scene for writing to `target`; returns the further files it then needs.
pub fn translate(root: &mut Object, target: &Path, extensions: Extensions) -> Vec<(PathBuf, String)> {
    let stem = target.file_stem().unwrap_or_default().to_string_lossy();
    let mut files = BesideFiles {
        stem: &stem,
        list: Vec::new(),
        materials: Vec::new(),
    };
    if extensions == Extensions::Approximate {
        // The members of a group have poses in the world, so that they do not move without the transform of the folder.
        let is_frame = |child: &Child| matches!(child, Child::Object(inner) if is_frame(inner));
        root.children.retain(|child| !is_frame(child));
        keep_one_sky(root);
        let plugin = if has_media(root) { "volpath" } else { "path" };
        replace_auto(root, plugin);
    }
    translate_inside(root, &mut files, extensions);
    root.children.splice(0..0, std::mem::take(&mut files.materials));
    let files = files.list.into_iter();
    files.map(|(name, text)| (target.with_file_name(name), text)).collect()
}

/// The mesh files written beside the scene, each with different content, and the materials that move to the top level.
struct BesideFiles<'s> {
    /// The name of the scene's file, the prefix of all mesh file names.
    stem: &'s str,
    list: Vec<(String, String)>,
    /// The materials with ids in parts that are left out: others may refer to them.
    materials: Vec<Child>,
}

impl BesideFiles<'_> {
    /// The name of the file with this text. A new file is added, and `kind` makes a part of its name from its number.
    fn name_of(&mut self, text: String, kind: impl FnOnce(usize) -> String) -> String {
        if let Some((name, _)) = self.list.iter().find(|(_, known)| *known == text) {
            return name.clone();
        }
        let name = format!("{}.{}", self.stem, kind(self.list.len() + 1));
        self.list.push((name.clone(), text));
        name
    }
}

/// Removes all lights around the scene but the first.
fn keep_one_sky(root: &mut Object) {
    let is_sky = |child: &Child| {
        let Child::Object(object) = child else { return false };
        let emitter = Emitter::of_plugin(&object.plugin).filter(|_| object.category == Category::Emitter);
        emitter.is_some_and(|emitter| emitter.is_sky())
    };
    let mut has_one = false;
    root.children
        .retain(|child| !is_sky(child) || !std::mem::replace(&mut has_one, true));
}

fn has_media(object: &Object) -> bool {
    let is_medium = |child: &Child| matches!(child, Child::Object(inner) if has_media(inner));
    object.category == Category::Medium || object.children.iter().any(is_medium)
}

/// Replaces integrators `auto` by this plugin.
fn replace_auto(object: &mut Object, plugin: &str) {
    if object.category == Category::Integrator && object.plugin == "auto" {
        object.plugin = plugin.into();
    }
    for child in &mut object.children {
        if let Child::Object(inner) = child
            && inner.category == Category::Integrator
        {
            replace_auto(Arc::make_mut(inner), plugin);
        }
    }
}

/// Removes the layers that only this program has.
fn keep_layers_of_mitsuba(integrator: &mut Object) {
    for property in &mut integrator.properties {
        if let ("aovs", Value::String(list)) = (property.name.as_str(), &mut property.value) {
            let is_ours_alone = |entry: &&str| {
                let layer = entry
                    .rsplit(':')
                    .next()
                    .and_then(|kind| Layer::from_name_in_file(kind.trim()));
                layer.is_some_and(|layer| layer.name_in_mitsuba().is_none())
            };
            let kept: Vec<&str> = list.split(',').filter(|entry| !is_ours_alone(entry)).collect();
            *list = kept.join(",");
        }
    }
}

fn translate_inside(object: &mut Object, files: &mut BesideFiles, extensions: Extensions) {
    object.children.retain_mut(|child| {
        let Child::Object(inner) = child else { return true };
        let inner = Arc::make_mut(inner);
        translate_inside(inner, files, extensions);
        if inner.category == Category::Shape && extensions == Extensions::Approximate {
            let is_ours = |name: &str| ["lightmap_scale", "portal"].contains(&name);
            inner.properties.retain(|property| !is_ours(&property.name));
        }
        match (inner.category, inner.plugin.as_str()) {
            (Category::Bsdf, "metal") => metal(inner, extensions),
            (Category::Medium, _) => medium(inner, extensions == Extensions::Approximate),
            (Category::Bsdf, "normalmap") if extensions == Extensions::Approximate => {
                inner.properties.retain(|property| property.name != "gltf_tangents");
            }
            (Category::Texture, "bitmap") if extensions == Extensions::Approximate => {
                inner.properties.retain(|property| property.name != "wrap_mode_v");
            }
            (Category::Texture, "mesh_attribute") if extensions == Extensions::Approximate => {
                inner.children.retain(|child| child.name() != Some("times"));
            }
            (Category::Emitter, "area") if extensions == Extensions::Approximate => {
                inner.properties.retain(|property| property.name != "two_sided");
            }
            (Category::Bsdf, "roughconductor") if extensions == Extensions::Approximate => {
                inner
                    .properties
                    .retain(|property| property.name != "multiple_scattering");
            }
            (Category::Integrator, plugin) if extensions == Extensions::Approximate => {
                match plugin {
                    "bdpt" | "vcm" => inner.plugin = "path".into(),
                    "aov" => keep_layers_of_mitsuba(inner),
                    _ => {}
                }
                let is_ours = |name: &str| matches!(name, "photons" | "merge_radius" | "clamp_percentile" | "guided");
                inner.properties.retain(|property| !is_ours(&property.name));
            }
            (Category::Sensor, "thinlens") if extensions == Extensions::Approximate => inner
                .properties
                .retain(|property| !matches!(property.name.as_str(), "blades" | "blade_rotation")),
            (Category::Sampler, _) if extensions == Extensions::Approximate => {
                inner
                    .properties
                    .retain(|property| !matches!(property.name.as_str(), "noise_target" | "adaptive"));
            }
            (Category::Emitter, "reflectionprobe" | "irradiancevolume" | "illuminancemeter" | "illuminancegrid")
                if extensions == Extensions::Approximate =>
            {
                return false;
            }
            (Category::Film, _) if extensions == Extensions::Approximate => {
                inner.properties.retain(|property| property.name != "compression");
            }
            (Category::Shape, "triangle") => {
                let name = files.name_of(TRIANGLE.to_owned(), |_| "triangle.obj".to_owned());
                triangle(inner, &name);
            }
            (Category::Shape, plugin) => {
                if let Some(part) = Solid::of_plugin(plugin) {
                    return solid(inner, part, files);
                }
            }
            _ => {}
        }
        true
    });
}

/// Replaces a building part by its mesh. False if it has no triangles, such as a wall that openings cover entirely: the
/// part has to be left out then, because files without triangles are refused.
fn solid(object: &mut Object, mut part: Solid, files: &mut BesideFiles) -> bool {
    let mut names = Vec::new();
    part.visit_mut(&mut |info, given| {
        names.push(info.name);
        match (given, value_of(object, info.name)) {
            (ParameterMut::Length(length), Some(Value::Float(number))) => *length = *number,
            (ParameterMut::Length(length), Some(Value::Integer(number))) => *length = *number as f32,
            (ParameterMut::Count(count), Some(Value::Integer(number))) => *count = *number as u32,
            (ParameterMut::Openings(openings), Some(Value::String(text))) => {
                *openings = parse_openings(text).unwrap_or_default();
            }
            _ => {}
        }
    });
    let plugin = part.plugin();
    let Some(ply) = solid_ply(&part) else {
        let has_id = |child: &Child| matches!(child, Child::Object(inner) if inner.id.is_some());
        let children = std::mem::take(&mut object.children);
        files.materials.extend(children.into_iter().filter(has_id));
        return false;
    };
    let name = files.name_of(ply, |number| format!("{plugin}-{number}.ply"));
    object.plugin = "ply".into();
    object
        .properties
        .retain(|property| !names.contains(&property.name.as_str()));
    *object = object.clone().with("filename", Value::String(name));
    true
}

/// Without fuzz it is a tinted perfect mirror. With it the closest is a rough one: a random point of a ball of radius f
/// moves the mirrored direction by f / sqrt(5) along each axis (standard deviation), a facet of Beckmann's distribution
/// by twice its slope, whose deviation is alpha / sqrt(2); so alpha = f / sqrt(10).
fn metal(object: &mut Object, extensions: Extensions) {
    let fuzz = match value_of(object, "fuzz") {
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
        value_of(object, "reflectance").is_some() || object.children.iter().any(|child| child.name().is_some());
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
        // This is the default colour of `metal`.
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

/// Replaces a triangle by the unit triangle of a file with a transform to its corners.
fn triangle(object: &mut Object, file_name: &str) {
    let corner = |name: &str| match value_of(object, name) {
        Some(Value::Point(place) | Value::Vector(place)) => *place,
        _ => Vec3::ZERO,
    };
    let [a, b, c] = ["v0", "v1", "v2"].map(corner);
    let normal = (b - a).cross(c - a).normalize_or(Vec3::Z);
    let axis = |v: Vec3| Vec4::from((v, 0.0));
    let matrix = Mat4::from_cols(axis(b - a), axis(c - a), axis(normal), Vec4::from((a, 1.0)));
    let mut steps = vec![TransformOp::Matrix(matrix)];
    if let Some(Value::Transform(further)) = value_of(object, "to_world") {
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
