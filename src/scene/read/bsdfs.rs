//! Bsdfs: `diffuse`, `conductor`, `roughconductor`, `dielectric`, `twosided`, and our own `metal`.

use super::parameters::Parameters;
use super::{SceneReader, address, ior_names};
use crate::document::{Category, Object, Reader, Severity, Value};
use crate::scene::description::{DeclarationPlace, MaterialDescription};
use crate::scene::write;
use crate::scene::{ConductorIor, Ior, Material};

/// Materials inside materials, followed through references too. Deeper is an error: no scene means it, and the stack is finite.
const DEEPEST: usize = 32;

impl<'a> SceneReader<'a> {
    /// The index of this bsdf in the description; read once, however often it is referred to. `place` is where it is written if that is
    /// not the top level.
    pub(super) fn read_bsdf(&mut self, object: &'a Object, place: DeclarationPlace, depth: usize) -> usize {
        if let Some(&known) = self.material_of.get(&address(object)) {
            return known;
        }
        let index = self.description.materials.len();
        self.material_of.insert(address(object), index);
        self.description.materials.push(MaterialDescription {
            identity: Default::default(),
            material: Material::default(),
            first: None,
            second: None,
            declared_in: if self.is_top_level(object) {
                DeclarationPlace::TopLevel
            } else {
                place
            },
        });

        let (material, nested) = read_parameters(self.reader(object));
        let mut inside = [None; 2];
        for (slot, inner) in inside.iter_mut().zip(nested) {
            if depth >= DEEPEST {
                let message = format!("{} is nested deeper than {DEEPEST} bsdfs", inner.title());
                self.diagnostics.error(object.span, message);
                break;
            }
            *slot = Some(self.read_bsdf(inner, DeclarationPlace::Material(index), depth + 1));
        }

        let identity = self.identity(object, write::objects::material(&material));
        let description = &mut self.description.materials[index];
        description.identity = identity;
        description.material = material;
        [description.first, description.second] = inside;
        index
    }
}

/// The material and the bsdfs nested in it.
fn read_parameters<'a>(mut reader: Reader<'a, '_>) -> (Material, Vec<&'a Object>) {
    let mut nested = Vec::new();
    let material = match reader.object().plugin.as_str() {
        "diffuse" => Material::Diffuse {
            reflectance: reader.reflectance("reflectance", 0.5),
        },
        "conductor" => Material::Conductor {
            ior: conductor_ior(&mut reader),
            specular_reflectance: reader.reflectance("specular_reflectance", 1.0),
        },
        "roughconductor" => rough_conductor(&mut reader),
        "dielectric" => Material::Dielectric {
            interior: ior(&mut reader, "int_ior", "bk7"),
            exterior: ior(&mut reader, "ext_ior", "air"),
            specular_reflectance: reader.reflectance("specular_reflectance", 1.0),
            specular_transmittance: reader.reflectance("specular_transmittance", 1.0),
        },
        "metal" => Material::Metal {
            reflectance: reader.reflectance("reflectance", 0.5),
            fuzz: reader.float_in("fuzz", 0.0..=1.0).unwrap_or(0.0),
        },
        "twosided" => {
            nested = two_sided(&mut reader);
            Material::TwoSided
        }
        other => {
            let message = format!("bsdf `{other}` is not supported: grey `diffuse` takes its place");
            let span = reader.object().span;
            reader.diagnostics().warn(span, message);
            return (Material::default(), nested);
        }
    };
    reader.finish();
    (material, nested)
}

fn conductor_ior(reader: &mut Reader) -> ConductorIor {
    let name = reader.string("material");
    let given = ["eta", "k"].map(|name| reader.has(name) || reader.child(name).is_some());
    if given.contains(&true) {
        if name.is_some_and(|name| name != "none") {
            reader.error_at("material", "`material` and `eta`, `k` exclude each other");
        }
        return ConductorIor::Given {
            eta: reader.unbounded_color("eta", 0.0),
            k: reader.unbounded_color("k", 1.0),
        };
    }
    let name = name.unwrap_or("none");
    if !ior_names::is_conductor(name) {
        let help = format!("known are {}", ior_names::CONDUCTORS.join(", "));
        unknown_name(reader, "material", format!("`{name}` is not a known metal"), help);
        return ConductorIor::Named("none".to_owned());
    }
    ConductorIor::Named(name.to_owned())
}

fn rough_conductor(reader: &mut Reader) -> Material {
    let distribution = reader.string_or("distribution", "beckmann");
    match distribution.to_ascii_lowercase().as_str() {
        "ggx" => {}
        "beckmann" if !reader.has("distribution") => reader.warn_at(
            "distribution",
            "without a `distribution` the format means `beckmann`, which is not supported: `ggx` takes its place",
        ),
        "beckmann" => reader.warn_at(
            "distribution",
            "distribution `beckmann` is not supported: `ggx` takes its place",
        ),
        other => reader.error_at(
            "distribution",
            format!("expected the distribution `ggx` or `beckmann`, found `{other}`"),
        ),
    }
    reader.ignore(&["sample_visible"]);
    let mut roughness = |name: &str| {
        let textured = reader.texture_in_place_of(name, "0.1");
        // 0 is as smooth as the model can be.
        let number = reader.float_in(name, 0.0..);
        number.or(textured.then_some(0.1))
    };
    let [alpha, along_u, along_v] = ["alpha", "alpha_u", "alpha_v"].map(&mut roughness);
    let alpha = match (along_u, along_v) {
        (None, None) => alpha.unwrap_or(0.1),
        (Some(u), Some(v)) if alpha.is_none() => {
            if u != v {
                let message = "roughness that depends on the direction is not supported: the geometric mean of `alpha_u` and `alpha_v` \
                               takes its place";
                reader.warn_at("alpha_u", message);
            }
            (u * v).sqrt()
        }
        _ => {
            let given = if along_u.is_some() { "alpha_u" } else { "alpha_v" };
            reader.error_at(given, "`alpha_u` and `alpha_v` go together, and not with `alpha`");
            0.1
        }
    };
    Material::RoughConductor {
        ior: conductor_ior(reader),
        specular_reflectance: reader.reflectance("specular_reflectance", 1.0),
        alpha,
    }
}

fn ior(reader: &mut Reader, name: &str, default: &str) -> Ior {
    let text = match reader.value(name) {
        None => default,
        Some(Value::String(text)) => text,
        Some(_) => {
            let number = reader.float_in(name, f32::MIN_POSITIVE..);
            return number.map_or_else(|| Ior::Named(default.to_owned()), Ior::Number);
        }
    };
    if !ior_names::is_dielectric(text) {
        let help = format!("a number, or one of {}", ior_names::DIELECTRICS.join(", "));
        unknown_name(reader, name, format!("`{text}` is not a known medium"), help);
        return Ior::Named(default.to_owned());
    }
    Ior::Named(text.to_owned())
}

fn unknown_name(reader: &mut Reader, parameter: &str, message: String, help: String) {
    let span = reader.span_of(parameter);
    reader
        .diagnostics()
        .push(Severity::Error, Some(span), message, Some(help));
}

fn two_sided<'a>(reader: &mut Reader<'a, '_>) -> Vec<&'a Object> {
    reader.ignore(&["allow_transmission"]);
    let inside = reader.children(Category::Bsdf);
    let span = reader.object().span;
    if !(1..=2).contains(&inside.len()) {
        let message = format!("`twosided` takes one bsdf or two, found {}", inside.len());
        reader.diagnostics().error(span, message);
    }
    for (_, object) in &inside {
        if object.plugin == "dielectric" {
            let message = "`dielectric` has two sides already: `twosided` does not take it";
            reader.diagnostics().error(object.span, message);
        }
    }
    inside.into_iter().map(|(_, object)| object).collect()
}
