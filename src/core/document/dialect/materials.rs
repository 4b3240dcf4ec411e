//! Reads `<Materials>`, and provides the built-in materials that objects may name.

use std::collections::HashMap;

use glam::Vec3;

use super::import::Import;
use super::tree::Node;
use crate::document::value::quote;
use crate::document::{Category, Object, Severity, Span, Value};

const COLOR: Vec3 = Vec3::splat(0.5);
/// The tint that glass gives to light at each refraction or reflection.
const GLASS_TINT: Vec3 = Vec3::new(0.95, 0.97, 1.0);
const LEAST_ROUGHNESS: f32 = 0.04;

/// The appearance of an object.
#[derive(Clone, Debug)]
pub enum Look {
    /// The id of its bsdf.
    Bsdf(String),
    /// Emitted radiance, W/(m^2 sr), of an object that reflects nothing.
    Light(Vec3),
    /// Subsurface scattering.
    Subsurface {
        /// The id of the bsdf at the boundary of closed objects.
        border: String,
        /// The id of the medium inside closed objects.
        medium: String,
        /// The id of the bsdf of objects that are not closed.
        surface: String,
    },
}

/// The appearances by name.
#[derive(Default)]
pub struct Materials(HashMap<String, Look>);

enum Recipe {
    Bsdf(Object),
    Light(Vec3),
    /// The bsdf of objects that are not closed, and the medium inside closed objects.
    Subsurface(Object, Object),
}

impl Import<'_> {
    pub fn read_materials(&mut self, root: Node, materials: &mut Materials) {
        let Some(list) = root.child(&["Materials"]) else { return };
        let nodes: Vec<Node> = list.children().collect();
        let last: HashMap<String, Span> = nodes
            .iter()
            .filter_map(|node| Some((node.text_of("name")?, node.span())))
            .collect();
        for node in nodes {
            let Some((name, span)) = node.attribute("name") else {
                self.warn(node.span(), "a material without a name is of no use");
                continue;
            };
            if last.get(&name) != Some(&node.span()) {
                self.warn(
                    span,
                    format!(
                        "the material {} is given again further down, which counts",
                        quote(&name)
                    ),
                );
                continue;
            }
            if let Some(recipe) = self.recipe(node) {
                self.keep(name, recipe, materials);
            }
        }
    }

    fn keep(&mut self, name: String, recipe: Recipe, materials: &mut Materials) -> Option<Look> {
        let look = match recipe {
            Recipe::Light(radiance) => Look::Light(radiance),
            Recipe::Bsdf(object) => Look::Bsdf(self.add_called(&name, object)?),
            Recipe::Subsurface(surface, medium) => {
                let border = Object::new(Category::Bsdf, "null").at(surface.span);
                Look::Subsurface {
                    surface: self.add_called(&name, surface)?,
                    border: self.add_called(&format!("{name}-border"), border)?,
                    medium: self.add_called(&format!("{name}-inside"), medium)?,
                }
            }
        };
        materials.0.insert(name, look.clone());
        Some(look)
    }

    /// Adds an object, and returns its id, which is derived from `name`.
    fn add_called(&mut self, name: &str, mut object: Object) -> Option<String> {
        let id = self.free_id(Some(name.to_owned()))?;
        object.id = Some(id.as_str().into());
        self.add(object);
        Some(id)
    }

    /// None if the type is unknown, which has been reported.
    fn recipe(&mut self, node: Node) -> Option<Recipe> {
        let span = node.span();
        let color = |import: &mut Self| import.color(node, &["Color"]).unwrap_or(COLOR);
        let object = match node.name() {
            "Lambertian" => {
                self.check_children(node, &["Color"]);
                diffuse(self.albedo(node), span)
            }
            "Metal" => {
                self.check_children(node, &["Color", "Fuzz"]);
                let fuzz = self.unit(node, "Fuzz", 0.0);
                metal(self.albedo(node), fuzz, span)
            }
            "Dielectric" => {
                self.check_children(node, &["Color", "IOR", "Refraction_Index"]);
                self.dielectric(node)
            }
            "Emissive" => {
                self.check_children(node, &["Color", "Strength", "Intensity"]);
                let strength = self.value(node, &["Strength"]).or_else(|| {
                    let intensity = self.value(node, &["Intensity"])?;
                    self.note(
                        span,
                        "the original passes over `Intensity` of <Emissive>; it is the strength here",
                    );
                    Some(intensity)
                });
                return Some(Recipe::Light(color(self) * strength.unwrap_or(1.0).max(0.0)));
            }
            kind @ ("PBR" | "GGX") => {
                self.check_children(node, &["Color", "Metallic", "Roughness"]);
                let metallic = self.unit(node, "Metallic", 0.0);
                let roughness = self.unit(node, "Roughness", 0.5).max(LEAST_ROUGHNESS);
                self.note(
                    span,
                    format!("<{kind}> is a `principled` bsdf with the same colour, metallic and roughness"),
                );
                let object = Object::new(Category::Bsdf, "principled").at(span);
                let object = object.with("base_color", Value::Rgb(self.albedo(node)));
                let object = object.with("metallic", Value::Float(metallic));
                object.with("roughness", Value::Float(roughness))
            }
            "SSS" => {
                self.check_children(node, &["Color", "ScatterColor", "ScatterDistance"]);
                let color = self.albedo(node);
                let surface = diffuse(color, span);
                if let Some(medium) = self.scattering_inside(node, color) {
                    return Some(Recipe::Subsurface(two_sided(surface), medium));
                }
                surface
            }
            other => {
                let known = ["Lambertian", "Metal", "Dielectric", "Emissive", "PBR", "GGX", "SSS"];
                let help = self.diagnostics.did_you_mean(other, known);
                let message = format!("<{other}> is no kind of material: objects made of it are grey");
                self.diagnostics.push(Severity::Warning, Some(span), message, help);
                return None;
            }
        };
        let is_glass = object.plugin == "dielectric";
        Some(Recipe::Bsdf(if is_glass { object } else { two_sided(object) }))
    }

    fn dielectric(&mut self, node: Node) -> Object {
        let given = self.value(node, &["IOR"]).or_else(|| {
            let index = self.value(node, &["Refraction_Index"])?;
            let message = "the original passes over <Refraction_Index>; it is the IOR here";
            self.note(node.span(), message);
            Some(index)
        });
        let ior = match given {
            Some(index) if index > 0.0 => index,
            Some(index) => {
                self.warn(node.span(), format!("an IOR of {index} is none: 1.5 takes its place"));
                1.5
            }
            None => 1.5,
        };
        let object = Object::new(Category::Bsdf, "dielectric").at(node.span());
        let object = object
            .with("int_ior", Value::Float(ior))
            .with("ext_ior", Value::Float(1.0));
        let object = object.with("specular_reflectance", Value::Rgb(GLASS_TINT));
        object.with("specular_transmittance", Value::Rgb(GLASS_TINT))
    }

    /// The `Color` of a material, limited so that it does not reflect more than it receives.
    fn albedo(&mut self, node: Node) -> Vec3 {
        let color = self.color(node, &["Color"]).unwrap_or(COLOR);
        if color.max_element() > 1.0 {
            self.warn(
                node.span(),
                "more light than comes is reflected by a colour above 1: it is cut to 1",
            );
        }
        color.min(Vec3::ONE)
    }

    /// A number clamped to [0, 1].
    fn unit(&mut self, node: Node, name: &str, default: f32) -> f32 {
        let number = self.value(node, &[name]).unwrap_or(default);
        if !(0.0..=1.0).contains(&number) {
            self.note(node.span(), format!("{name} {number} is cut to the range from 0 to 1"));
        }
        number.clamp(0.0, 1.0)
    }

    /// The appearance with this name: from the file, or else one built into the original.
    pub fn look(&mut self, name: &str, span: Span, materials: &mut Materials) -> Option<Look> {
        if let Some(look) = materials.0.get(name) {
            return Some(look.clone());
        }
        let recipe = match name {
            "ground" => Recipe::Bsdf(two_sided(diffuse(Vec3::new(0.8, 0.8, 0.0), span))),
            "mattBrown" => Recipe::Bsdf(two_sided(diffuse(Vec3::new(0.7, 0.3, 0.3), span))),
            "fuzzySilver" => Recipe::Bsdf(two_sided(metal(Vec3::splat(0.8), 0.3, span))),
            "shinyGold" => Recipe::Bsdf(two_sided(metal(Vec3::new(0.8, 0.6, 0.2), 1.0, span))),
            "emissive" => Recipe::Light(Vec3::ONE),
            _ => {
                let candidates = materials.0.keys().map(String::as_str);
                let help = self.diagnostics.did_you_mean(name, candidates);
                let message = format!("there is no material {}: grey takes its place", quote(name));
                self.diagnostics.push(Severity::Warning, Some(span), message, help);
                Recipe::Bsdf(two_sided(diffuse(COLOR, span)))
            }
        };
        self.keep(name.to_owned(), recipe, materials)
    }
}

/// The bsdf of emitters.
pub fn black(span: Span) -> Object {
    diffuse(Vec3::ZERO, span)
}

/// The bsdf of objects without a material.
pub fn grey(span: Span) -> Object {
    two_sided(diffuse(COLOR, span))
}

fn diffuse(color: Vec3, span: Span) -> Object {
    let object = Object::new(Category::Bsdf, "diffuse").at(span);
    object.with("reflectance", Value::Rgb(color))
}

fn metal(color: Vec3, fuzz: f32, span: Span) -> Object {
    let object = Object::new(Category::Bsdf, "metal").at(span);
    object
        .with("reflectance", Value::Rgb(color))
        .with("fuzz", Value::Float(fuzz))
}

fn two_sided(inner: Object) -> Object {
    let mut object = Object::new(Category::Bsdf, "twosided").at(inner.span);
    object.children.push(inner.into());
    object
}
