//! Bsdfs, with what is nested in them.

use std::ops::RangeInclusive;

use super::ior_names;
use super::parameters::Parameters;
use super::picture_search::PictureSearch;
use super::scene_reader::{SceneReader, address};
use super::textures::read_texture;
use crate::color::Rgb;
use crate::document::suggest::did_you_mean;
use crate::document::{Category, Object, Reader, Severity, Value};
use crate::scene::description::{DeclarationPlace, MaterialDescription};
use crate::scene::encode::objects;
use crate::scene::{
    ConductorIor, Distribution, Ior, Material, Parameter, ParameterVisitor, PrincipledIndex, Roughness,
};

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

        let reader = Reader::new(&self.index, object, &mut self.diagnostics);
        let (material, nested) = read_parameters(reader, &mut self.pictures);
        let mut inside = [None; 2];
        for (slot, inner) in inside.iter_mut().zip(nested) {
            if depth >= DEEPEST {
                let message = format!("{} is nested deeper than {DEEPEST} bsdfs", inner.title());
                self.diagnostics.error(object.span, message);
                break;
            }
            let read = self.read_bsdf(inner, DeclarationPlace::Material(index), depth + 1);
            *slot = Some(read);
            if material == Material::TwoSided && self.description.materials[read].material.refracts() {
                let message = format!("`{}` has two sides already: `twosided` does not take it", inner.plugin);
                self.diagnostics.error(inner.span, message);
            }
        }

        let identity = self.identity(object, || objects::material(&material, &self.folder));
        let description = &mut self.description.materials[index];
        description.identity = identity;
        description.material = material;
        [description.first, description.second] = inside;
        index
    }
}

/// The material and the bsdfs nested in it.
fn read_parameters<'a>(mut reader: Reader<'a, '_>, pictures: &mut PictureSearch) -> (Material, Vec<&'a Object>) {
    let plugin = reader.object().plugin.as_str();
    let Some(mut material) = Material::of_plugin(plugin) else {
        let message = format!("bsdf `{plugin}` is not supported: grey `diffuse` takes its place");
        let help = did_you_mean(plugin, Material::PLUGINS);
        let span = reader.object().span;
        reader.diagnostics().push(Severity::Warning, Some(span), message, help);
        return (Material::default(), Vec::new());
    };
    let mut values = FromFile {
        reader: &mut reader,
        pictures,
    };
    material.visit(&mut values);
    let is_given = reader.has("normalmap") || reader.child("normalmap").is_some();
    // A reference to nothing has been reported.
    let is_reported = reader.refers_to_nothing();
    if matches!(material, Material::NormalMap { .. }) && !is_given && !is_reported {
        let span = reader.object().span;
        let message = "`normalmap` needs a texture of that name, its normals";
        reader.diagnostics().error(span, message);
    }
    let nested = nested(&material, &mut reader);
    reader.finish();
    (material, nested)
}

/// The bsdfs inside; a wrong number of them is an error.
fn nested<'a>(material: &Material, reader: &mut Reader<'a, '_>) -> Vec<&'a Object> {
    let expected = material.nested_count();
    if *expected.end() == 0 {
        return Vec::new();
    }
    let inside: Vec<&Object> = reader
        .children(Category::Bsdf)
        .into_iter()
        .map(|(_, object)| object)
        .collect();
    if !expected.contains(&inside.len()) && !reader.has_lost_reference() {
        let wanted = match (expected.start(), expected.end()) {
            (1, 1) => "one bsdf",
            (2, 2) => "two bsdfs",
            _ => "one bsdf or two",
        };
        let message = format!("`{}` takes {wanted}, found {}", material.plugin(), inside.len());
        let span = reader.object().span;
        reader.diagnostics().error(span, message);
    }
    if *material == Material::TwoSided {
        reader.ignore(&["allow_transmission"]);
    }
    inside
}

/// Takes what the file gives.
pub(super) struct FromFile<'r, 'a, 'd> {
    pub reader: &'r mut Reader<'a, 'd>,
    pub pictures: &'r mut PictureSearch,
}

impl ParameterVisitor for FromFile<'_, '_, '_> {
    fn reflectance(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        if let Some(given) = self.reader.reflectance(name, self.pictures) {
            *value = given;
        }
    }

    fn color(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        if let Some(given) = self.reader.unbounded_color(name, self.pictures) {
            *value = given;
        }
    }

    fn float(&mut self, name: &'static str, value: &mut Parameter<f32>, range: RangeInclusive<f32>) {
        if let Some(given) = self.reader.float_parameter(name, range, self.pictures) {
            *value = given;
        }
    }

    fn height(&mut self, value: &mut Parameter<f32>) {
        let mut textures = self.reader.children(Category::Texture).into_iter();
        let Some((_, object)) = textures.next() else {
            // A reference to nothing has been reported.
            if self.reader.refers_to_nothing() {
                return;
            }
            let span = self.reader.object().span;
            let message = "`bumpmap` needs a texture, its height";
            self.reader.diagnostics().error(span, message);
            return;
        };
        if let Some((_, extra)) = textures.next() {
            let message = "`bumpmap` takes one texture";
            self.reader.diagnostics().error(extra.span, message);
        }
        let pictures = &mut *self.pictures;
        if let Some(texture) = self.reader.nested(object, |reader| read_texture(reader, pictures)) {
            *value = Parameter::Texture(texture);
        }
    }

    fn number(&mut self, name: &'static str, value: &mut f32, range: RangeInclusive<f32>) {
        *value = self.reader.float_in(name, range).unwrap_or(*value);
    }

    fn flag(&mut self, name: &'static str, value: &mut bool) {
        *value = self.reader.boolean(name).unwrap_or(*value);
    }

    fn ior(&mut self, name: &'static str, value: &mut Ior) {
        let text = match self.reader.value(name) {
            None => return,
            Some(Value::String(text)) => text,
            Some(_) => {
                if let Some(number) = self.reader.float_in(name, f32::MIN_POSITIVE..) {
                    *value = Ior::Number(number);
                }
                return;
            }
        };
        if ior_names::is_dielectric(text) {
            *value = Ior::Named(text.to_owned());
        } else {
            let help = format!("a number, or one of {}", ior_names::DIELECTRICS.join(", "));
            unknown_name(self.reader, name, format!("`{text}` is not a known medium"), help);
        }
    }

    fn conductor_ior(&mut self, value: &mut ConductorIor) {
        let name = self.reader.string("material");
        let given = ["eta", "k"].map(|name| self.reader.has(name) || self.reader.child(name).is_some());
        if given.contains(&true) {
            if name.is_some_and(|name| name != "none") {
                self.reader
                    .error_at("material", "`material` and `eta`, `k` exclude each other");
            }
            let mut number = |name, default: f32| {
                let given = self.reader.unbounded_color(name, self.pictures);
                given.unwrap_or(Rgb::splat(default).into())
            };
            *value = ConductorIor::Given {
                eta: number("eta", 0.0),
                k: number("k", 1.0),
            };
            return;
        }
        let Some(name) = name else { return };
        if ior_names::is_conductor(name) {
            *value = ConductorIor::Named(name.to_owned());
        } else {
            let help = ior_names::conductor_help(name);
            unknown_name(self.reader, "material", format!("`{name}` is not a known metal"), help);
        }
    }

    fn distribution(&mut self, value: &mut Distribution) {
        self.reader.ignore(&["sample_visible"]);
        let Some(name) = self.reader.string("distribution") else {
            return;
        };
        match name.to_ascii_lowercase().as_str() {
            "ggx" => *value = Distribution::Ggx,
            "beckmann" => *value = Distribution::Beckmann,
            _ => self.reader.error_at(
                "distribution",
                format!("expected the distribution `ggx` or `beckmann`, found `{name}`"),
            ),
        }
    }

    fn roughness(&mut self, value: &mut Roughness) {
        // 0 is as smooth as the model can be.
        let given = ["alpha", "alpha_u", "alpha_v"]
            .map(|name| self.reader.float_parameter(name, 0.0..=f32::MAX, self.pictures));
        match given {
            [None, None, None] => {}
            [Some(alpha), None, None] => *value = Roughness::Isotropic(alpha),
            [None, Some(u), Some(v)] => *value = Roughness::Anisotropic { u, v },
            [_, u, _] => {
                let given = if u.is_some() { "alpha_u" } else { "alpha_v" };
                self.reader
                    .error_at(given, "`alpha_u` and `alpha_v` go together, and not with `alpha`");
            }
        }
    }

    fn principled_index(&mut self, value: &mut PrincipledIndex) {
        let specular = self.reader.float_in("specular", 0.0..=1.0);
        let eta = self.reader.float_in("eta", f32::MIN_POSITIVE..);
        match (specular, eta) {
            (None, None) => {}
            (Some(specular), None) => *value = PrincipledIndex::Specular(specular),
            (None, Some(eta)) => *value = PrincipledIndex::Eta(eta),
            (Some(_), Some(_)) => self.reader.error_at(
                "eta",
                "`specular` and `eta` exclude each other: both say how strongly the surface reflects",
            ),
        }
    }
}

fn unknown_name(reader: &mut Reader, parameter: &str, message: String, help: String) {
    let span = reader.span_of(parameter);
    reader
        .diagnostics()
        .push(Severity::Error, Some(span), message, Some(help));
}
