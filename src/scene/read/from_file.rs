//! Reads the declared parameters of plugins of every family.

use std::path::PathBuf;

use super::field_of_view::read_fov;
use super::ior_names;
use super::parameters::Parameters;
use super::picture_search::PictureSearch;
use super::spectra::{is_spectrum, read_spectrum};
use super::textures::{read_texture, to_uv};
use crate::color::Rgb;
use crate::document::spectrum::Role;
use crate::document::{Category, Reader, Severity, Value};
use crate::scene::components::parameters::{ABSORPTION_SCALE, CUTOFF_ANGLE, EUMELANIN, PHEOMELANIN, SIGMA_A};
use crate::scene::components::pattern::parse_stops;
use crate::scene::components::wall_openings::parse_openings;
use crate::scene::{
    Absorption, Choice, ConductorIor, Cone, Declared, Distribution, Ior, Parameter, ParameterInfo, ParameterMut,
    PlaceAndTime, PrincipledIndex, Roughness, SunPosition,
};

/// Reads the parameters of a plugin.
pub(super) struct FromFile<'r, 'a, 'd> {
    pub reader: &'r mut Reader<'a, 'd>,
    pub pictures: &'r mut PictureSearch,
}

impl FromFile<'_, '_, '_> {
    /// Reads the parameters that the file gives.
    pub fn read_all(mut self, values: &mut impl Declared) {
        values.visit_mut(&mut |info, value| self.read(info, value));
    }

    fn read(&mut self, info: &ParameterInfo, value: ParameterMut) {
        let name = info.name;
        match value {
            ParameterMut::Reflectance(value) => {
                if let Some(given) = self.reader.reflectance(name, self.pictures) {
                    *value = given;
                }
            }
            ParameterMut::Normals(value) => self.normals(name, value),
            ParameterMut::Float(value) => {
                if let Some(given) = self.reader.float_parameter(name, info.range.clone(), self.pictures) {
                    *value = given;
                }
            }
            ParameterMut::Height(value) => self.height(value),
            ParameterMut::Number(value)
            | ParameterMut::Factor(value)
            | ParameterMut::Angle(value)
            | ParameterMut::SamplingWeight(value)
            | ParameterMut::ExtensionFactor(value) => {
                *value = self.reader.float_in(name, info.range.clone()).unwrap_or(*value);
            }
            ParameterMut::Integer(value) => {
                let range = *info.range.start() as i64..=*info.range.end() as i64;
                let given = self.reader.integer_in(name, range);
                *value = given.and_then(|given| i32::try_from(given).ok()).unwrap_or(*value);
            }
            ParameterMut::Flag(value) | ParameterMut::Extension(value) => {
                *value = self.reader.boolean(name).unwrap_or(*value);
            }
            ParameterMut::Ior(value) => self.ior(name, value),
            ParameterMut::ConductorIor(value) => self.conductor_ior(value),
            ParameterMut::Distribution(value) => self.distribution(name, value),
            ParameterMut::Roughness(value) | ParameterMut::UniformRoughness(value) => self.roughness(value),
            ParameterMut::PrincipledIndex(value) => self.principled_index(value),
            ParameterMut::Absorption(value) => self.absorption(value),
            ParameterMut::Emission(value) => self.emission(name, value),
            ParameterMut::TexturedEmission(value) => {
                if let Some(given) = self.reader.radiometric(name, self.pictures) {
                    *value = given;
                }
            }
            ParameterMut::UniformReflectance(value) => self.uniform_reflectance(name, value),
            ParameterMut::Picture(value) => self.picture(name, value),
            ParameterMut::OptionalTexture(value) => *value = self.reader.texture(name, self.pictures),
            ParameterMut::Cone(value) => self.cone(value),
            ParameterMut::FieldOfView(value) => (value.fov, value.axis) = read_fov(self.reader),
            ParameterMut::SunPosition(value) => self.sun_position(value),
            ParameterMut::Coefficients(value) => self.coefficients(value),
            ParameterMut::VolumeEmission(value) => {
                if let Some(given) = self.volume_color(info) {
                    *value = given;
                }
            }
            ParameterMut::VolumeShare(value) => self.weight(info, value),
            ParameterMut::Values(value) => self.values(name, value),
            ParameterMut::Length(value) => {
                *value = self.reader.float_in(name, info.file_range()).unwrap_or(*value);
            }
            ParameterMut::Count(value) => {
                let range = *info.range.start() as i64..=*info.range.end() as i64;
                let given = self.reader.integer_in(name, range);
                *value = given.and_then(|given| u32::try_from(given).ok()).unwrap_or(*value);
            }
            ParameterMut::Openings(value) => match self.reader.string(name).map(parse_openings) {
                Some(Ok(given)) => *value = given,
                Some(Err(reason)) => self.reader.error_at(name, format!("`{name}`: {reason}")),
                None => {}
            },
            ParameterMut::Nested(value) => {
                if let Some(given) = self.reader.unbounded_color(name, self.pictures) {
                    *value = given;
                }
            }
            ParameterMut::Placing(value) => *value = to_uv(self.reader),
            ParameterMut::Choice(value) => self.choice(name, value),
            ParameterMut::Stops(value) => match self.reader.string(name).map(parse_stops) {
                Some(Ok(given)) => *value = given,
                Some(Err(reason)) => self.reader.error_at(name, format!("`{name}`: {reason}")),
                None => {}
            },
        }
    }

    fn choice(&mut self, name: &str, value: &mut Choice) {
        let Some(given) = self.reader.string(name) else {
            return;
        };
        match value.of_name(given) {
            Some(known) => *value = known,
            None => {
                let names = value.names().join("`, `");
                let message = format!("expected one of `{names}` for `{name}`, found `{given}`");
                self.reader.error_at(name, message);
            }
        }
    }

    fn normals(&mut self, name: &str, value: &mut Parameter<Rgb>) {
        if let Some(given) = self.reader.reflectance(name, self.pictures) {
            *value = given;
        }
        let is_given = self.reader.has(name) || self.reader.child(name).is_some();
        // A reference without target has been reported.
        if !is_given && !self.reader.refers_to_nothing() {
            let span = self.reader.object().span;
            let message = "`normalmap` needs a texture of that name, its normals";
            self.reader.diagnostics().error(span, message);
        }
    }

    fn height(&mut self, value: &mut Parameter<f32>) {
        let mut textures = self.reader.children(Category::Texture).into_iter();
        let Some((_, object)) = textures.next() else {
            // A reference without target has been reported.
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
        let height = self.reader.nested(object, |reader| match is_spectrum(&object.plugin) {
            true => Some(match read_spectrum(reader, Role::Unbounded, pictures)? {
                Parameter::Constant(color) => Parameter::Constant(color.element_sum() / 3.0),
                Parameter::Texture(texture) => Parameter::Texture(texture),
            }),
            false => read_texture(reader, pictures).map(Parameter::Texture),
        });
        if let Some(height) = height {
            *value = height;
        }
    }

    fn ior(&mut self, name: &str, value: &mut Ior) {
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

    fn distribution(&mut self, name: &str, value: &mut Distribution) {
        self.reader.ignore(&["sample_visible"]);
        let Some(given) = self.reader.string(name) else {
            return;
        };
        match Distribution::of_name(&given.to_ascii_lowercase()) {
            Some(known) => *value = known,
            None => self.reader.error_at(
                name,
                format!("expected the distribution `ggx` or `beckmann`, found `{given}`"),
            ),
        }
    }

    fn roughness(&mut self, value: &mut Roughness) {
        // 0 is clamped to the smoothest roughness of the model.
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

    fn absorption(&mut self, value: &mut Absorption) {
        let mut number = |info: &ParameterInfo| self.reader.float_in(info.name, info.range.clone());
        let pigments = [&EUMELANIN, &PHEOMELANIN].map(&mut number);
        if let Some(sigma_a) = self.reader.unbounded_color(SIGMA_A.name, self.pictures) {
            if pigments != [None; 2] {
                let message = "`sigma_a` and pigments exclude each other: both say how much light is absorbed";
                self.reader.error_at(SIGMA_A.name, message);
            }
            let scale = self
                .reader
                .float_in(ABSORPTION_SCALE.name, ABSORPTION_SCALE.range.clone());
            let scale = scale.unwrap_or(ABSORPTION_SCALE.usual);
            *value = Absorption::Given { sigma_a, scale };
        } else if let Absorption::Melanin { eumelanin, pheomelanin } = value {
            *eumelanin = pigments[0].unwrap_or(*eumelanin);
            *pheomelanin = pigments[1].unwrap_or(*pheomelanin);
        }
    }

    fn emission(&mut self, name: &str, value: &mut Rgb) {
        match self.reader.radiometric(name, self.pictures) {
            Some(Parameter::Constant(given)) => *value = given,
            Some(Parameter::Texture(_)) => {
                let owner = self.reader.object().title();
                let message = format!("`{name}` of {owner} is the same everywhere: 1 takes the place of the texture");
                self.reader.warn_at(name, message);
            }
            None => {}
        }
    }

    fn uniform_reflectance(&mut self, name: &str, value: &mut Rgb) {
        if self.reader.child(name).is_none() {
            *value = self.reader.rgb_in(name, 0.0..=1.0).unwrap_or(*value);
            return;
        }
        match self.reader.spectrum_or_texture(name, self.pictures) {
            Some(Parameter::Constant(given)) if (given.cmpge(Rgb::ZERO) & given.cmple(Rgb::ONE)).all() => {
                *value = given
            }
            Some(Parameter::Constant(_)) => {
                let message = format!("`{name}` should be between 0 and 1");
                self.reader.error_at(name, message);
            }
            Some(Parameter::Texture(_)) => {
                let owner = self.reader.object().title();
                let message = format!("`{name}` of {owner} is the same everywhere: the texture has no effect");
                self.reader.warn_at(name, message);
            }
            None => {}
        }
    }

    fn picture(&mut self, name: &str, value: &mut PathBuf) {
        if let Some(file) = self.reader.string(name) {
            *value = self.pictures.find(file, self.reader);
        } else if !self.reader.has(name) {
            let message = format!("{} needs a `{name}`", self.reader.object().title());
            self.reader.error_at(name, message);
        }
    }

    fn cone(&mut self, cone: &mut Cone) {
        let cutoff = self.reader.float_in(CUTOFF_ANGLE.name, CUTOFF_ANGLE.range.clone());
        cone.cutoff_angle = cutoff.unwrap_or(cone.cutoff_angle);
        let beam = self.reader.float_in("beam_width", 0.0..=360.0);
        cone.beam_width = beam.unwrap_or(0.75 * cone.cutoff_angle);
        if cone.beam_width > cone.cutoff_angle {
            let message = "`beam_width` is above `cutoff_angle`: the beam ends there";
            self.reader.warn_at("beam_width", message);
            cone.beam_width = cone.cutoff_angle;
        }
    }

    fn sun_position(&mut self, value: &mut SunPosition) {
        let Some(direction) = self.reader.vector("sun_direction") else {
            if let SunPosition::PlaceAndTime(at) = value {
                at.visit_mut(&mut |info, value| self.read(info, value));
            }
            return;
        };
        let mut others = Vec::new();
        PlaceAndTime::default().visit(&mut |info, _| others.push(info.name));
        if let Some(other) = others.iter().find(|name| self.reader.has(name)) {
            let message = format!("`sun_direction` and `{other}` exclude each other: both say where the sun stands");
            self.reader.error_at(other, message);
            self.reader.ignore(&others);
        }
        if direction.try_normalize().is_none() {
            self.reader.error_at("sun_direction", "`sun_direction` has no length");
        }
        *value = SunPosition::Direction(direction);
    }
}

fn unknown_name(reader: &mut Reader, parameter: &str, message: String, help: String) {
    let span = reader.span_of(parameter);
    reader
        .diagnostics()
        .push(Severity::Error, Some(span), message, Some(help));
}
