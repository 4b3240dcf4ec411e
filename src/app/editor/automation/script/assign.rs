//! A parameter by its name in the file, set from a text.

use std::ops::RangeInclusive;

use bevy::math::{Affine3A, Vec3};

use crate::color::Rgb;
use crate::document::paths::settle;
use crate::document::value::{ValueError, fields, parse_boolean, parse_float, parse_integer, parse_rgb, parse_vec3};
use crate::files::ExrCompression;
use crate::scene::euler::from_rest;
use crate::scene::medium;
use crate::scene::parameters::{ABSORPTION_SCALE, ALPHA, BEAM_WIDTH, CUTOFF_ANGLE, EUMELANIN, PHEOMELANIN, SIGMA_A};
use crate::scene::wall_openings::{OpeningsError, parse_openings};
use crate::scene::{
    Absorption, AreaLight, Coefficients, ComponentFormat, ConductorIor, Cone, Declared, Distribution, Emitter,
    EulerAngles, Film, GridFile, Ior, LengthUnit, Lens, Material, Medium, ParameterInfo, ParameterMut, PhaseFunction,
    PrincipledIndex, Roughness, Sensor, Shape, ShapeKind, SunPosition, Texture, Turned, VolumeFormat, VolumeParameter,
};

/// The reason why a parameter was not set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum AssignError {
    /// There is no such parameter.
    #[error("expected {}", known.join(" or "))]
    Unknown { known: Vec<&'static str> },
    #[error(transparent)]
    Value(#[from] ValueError),
    #[error(transparent)]
    Openings(#[from] OpeningsError),
    /// The value is of the right kind, but the parameter does not take it.
    #[error("{0}")]
    Refused(String),
}

/// The parameter to set, and whether it was found.
struct Assign<'t> {
    wanted: &'t str,
    text: &'t str,
    known: Vec<&'static str>,
    outcome: Option<Result<(), AssignError>>,
}

/// Sets a parameter of a material by its name in the file from a text of the script.
pub fn material(material: &mut Material, parameter: &str, text: &str) -> Result<(), AssignError> {
    assign(parameter, text, |visitor| visitor.declared(material))
}

/// Sets a parameter of a shape's emission, as [`material`] does.
pub fn area_light(light: &mut AreaLight, parameter: &str, text: &str) -> Result<(), AssignError> {
    assign(parameter, text, |visitor| visitor.declared(light))
}

/// Sets a parameter of a light that is no shape, as [`material`] does.
pub fn emitter(emitter: &mut Emitter, parameter: &str, text: &str) -> Result<(), AssignError> {
    assign(parameter, text, |visitor| visitor.declared(emitter))
}

/// Sets a parameter of a medium, or of its phase function, as [`material`] does. `phase` is the plugin of the phase
/// function, `filename` the path of a grid in place of the extinction, and `mean_free_path` the inverse of the
/// extinction; lengths are in `unit`.
pub fn medium(medium: &mut Medium, parameter: &str, text: &str, unit: LengthUnit) -> Result<(), AssignError> {
    let (mut path, mut file) = (None, None);
    assign(parameter, text, |visitor| {
        visitor.declared(medium);
        visitor.declared(&mut medium.phase);
        visitor.value("phase", &mut medium.phase, parse_phase);
        visitor.value("mean_free_path", &mut path, |text| parse_lengths(text, unit).map(Some));
        visitor.value("filename", &mut file, |text| Ok(Some(settle(text.as_ref()))));
    })?;
    if let Some(path) = path
        && !medium.set_mean_free_path(path)
    {
        let reason = "the extinction varies in space, or the density is 0";
        return Err(AssignError::Refused(reason.to_owned()));
    }
    if let Some(path) = file {
        let (mut sigma_t, albedo) = medium.coefficients.sigma_t_and_albedo();
        let mut grid = match sigma_t {
            VolumeParameter::Grid(grid) => grid,
            VolumeParameter::Box { to_world, .. } => GridFile {
                to_world,
                ..GridFile::default()
            },
            VolumeParameter::Constant(_) => GridFile::default(),
        };
        (grid.format, grid.path) = (VolumeFormat::of_file(&path), path);
        if grid.format != VolumeFormat::Vol {
            (grid.wrap, grid.use_grid_bbox) = Default::default();
        }
        sigma_t = VolumeParameter::Grid(grid);
        medium.coefficients = Coefficients::Extinction { sigma_t, albedo };
    }
    Ok(())
}

fn parse_phase(text: &str) -> Result<PhaseFunction, AssignError> {
    let plain = PhaseFunction::PLUGINS.into_iter().filter(|name| *name != "blendphase");
    if plain.clone().any(|name| name == text) {
        return PhaseFunction::of_plugin(text).ok_or_else(|| AssignError::Refused("expected a plugin".to_owned()));
    }
    let names: Vec<&str> = plain.collect();
    let names = names.join(", ");
    Err(AssignError::Refused(format!("expected {names}; found `{text}`")))
}

/// Parses one length for all colours, or one for each, above 0.
fn parse_lengths(text: &str, unit: LengthUnit) -> Result<Rgb, AssignError> {
    let length = |text: &str| {
        unit.parse(text)
            .map(|length| length as f32)
            .filter(|length| *length > 0.0)
    };
    let lengths: Option<Vec<f32>> = match length(text) {
        Some(length) => Some(vec![length; 3]),
        None => text.split(',').map(length).collect(),
    };
    match lengths.as_deref() {
        Some(&[red, green, blue]) => Ok(Rgb::new(red, green, blue)),
        _ => Err(AssignError::Refused(format!(
            "expected a length above 0, such as 2m, or three with commas between them; found `{text}`"
        ))),
    }
}

/// Sets a parameter of a shape, as [`material`] does.
pub fn shape(shape: &mut Shape, parameter: &str, text: &str) -> Result<(), AssignError> {
    assign(parameter, text, |visitor| {
        visitor.parsed("flip_normals", &mut shape.flip_normals, parse_boolean);
        // Curves have no lightmaps.
        if !shape.is_frame() && !shape.is_of_curves() {
            visitor.bounded("lightmap_scale", &mut shape.lightmap_scale, Shape::LIGHTMAP_SCALES);
        }
        match &mut shape.kind {
            ShapeKind::Sphere { center, radius } => {
                visitor.parsed("center", center, parse_vec3);
                visitor.bounded("radius", radius, f32::MIN_POSITIVE..=f32::MAX);
            }
            ShapeKind::Cylinder { p0, p1, radius } => {
                visitor.parsed("p0", p0, parse_vec3);
                visitor.parsed("p1", p1, parse_vec3);
                visitor.bounded("radius", radius, f32::MIN_POSITIVE..=f32::MAX);
            }
            ShapeKind::Solid(solid) => visitor.declared(solid),
            ShapeKind::Mesh(mesh) if !mesh.format.is_of_curves() => {
                visitor.parsed("face_normals", &mut mesh.face_normals, parse_boolean);
            }
            ShapeKind::Rectangle => visitor.parsed("portal", &mut shape.portal, parse_boolean),
            ShapeKind::Cube
            | ShapeKind::Disk
            | ShapeKind::Triangle { .. }
            | ShapeKind::Mesh(_)
            | ShapeKind::Instance
            | ShapeKind::Frame => {}
        }
    })
}

/// Sets a parameter of a camera, as [`material`] does.
pub fn sensor(sensor: &mut Sensor, parameter: &str, text: &str) -> Result<(), AssignError> {
    assign(parameter, text, |visitor| {
        visitor.bounded("fov", &mut sensor.fov, 0.1..=179.0);
        visitor.bounded("near_clip", &mut sensor.near_clip, 1e-6..=f32::MAX);
        visitor.bounded("far_clip", &mut sensor.far_clip, 1e-6..=f32::MAX);
        if let Lens::Thin {
            aperture_radius,
            focus_distance,
            ..
        } = &mut sensor.lens
        {
            visitor.bounded("aperture_radius", aperture_radius, 0.0..=f32::MAX);
            visitor.bounded("focus_distance", focus_distance, f32::MIN_POSITIVE..=f32::MAX);
        }
    })
}

/// Sets a parameter of a camera's film, as [`material`] does.
pub fn film(film: &mut Film, parameter: &str, text: &str) -> Result<(), AssignError> {
    let pixels = |text: &str| match parse_integer(text)? {
        number @ 1..=65536 => Ok(number as u32),
        other => Err(AssignError::Refused(format!("expected 1 to 65536, found {other}"))),
    };
    assign(parameter, text, |visitor| {
        visitor.value("width", &mut film.width, pixels);
        visitor.value("height", &mut film.height, pixels);
        visitor.value("sample_count", &mut film.sample_count, pixels);
        visitor.parsed("adaptive", &mut film.adaptive, parse_boolean);
        visitor.value("component_format", &mut film.storage.components, |text| {
            one_of(text, "none", &ComponentFormat::ALL, ComponentFormat::name)
        });
        visitor.value("compression", &mut film.storage.compression, |text| {
            one_of(text, "default", &ExrCompression::ALL, ExrCompression::name)
        });
        visitor.value("noise_target", &mut film.noise_target, |text| match text {
            "none" => Ok(None),
            number => within(parse_float(number)?, &(f32::MIN_POSITIVE..=f32::MAX)).map(Some),
        });
    })
}

/// The value of this name among `all`; None for the word `unsaid`.
fn one_of<T: Copy>(text: &str, unsaid: &str, all: &[T], name: fn(T) -> &'static str) -> Result<Option<T>, AssignError> {
    if text == unsaid {
        return Ok(None);
    }
    let found = all.iter().copied().find(|&value| name(value) == text);
    found.map(Some).ok_or_else(|| {
        let names: Vec<&str> = std::iter::once(unsaid)
            .chain(all.iter().map(|&value| name(value)))
            .collect();
        AssignError::Refused(format!("expected {}; found {text}", names.join(", ")))
    })
}

/// The pose with another position, rotation (degrees about x, then y, then z, from `rest`) or scale; and the angles, if
/// these were set. `angles` are its known ones. A pose with shear loses the shear.
pub fn pose(
    pose: &Affine3A,
    parameter: &str,
    text: &str,
    angles: Option<EulerAngles>,
    rest: Vec3,
) -> Result<(Affine3A, Option<EulerAngles>), AssignError> {
    let turned = Turned::of(&pose.matrix3, angles.map(|angles| angles.0)).unwrap_or_else(|| Turned {
        scale: pose.to_scale_rotation_translation().0,
        degrees: rest,
    });
    let (mut position, mut scale, mut degrees) =
        (pose.translation.into(), turned.scale, from_rest(turned.degrees, -rest));
    assign(parameter, text, |visitor| {
        visitor.parsed("position", &mut position, parse_vec3);
        visitor.parsed("rotation", &mut degrees, parse_vec3);
        visitor.parsed("scale", &mut scale, crate::document::value::parse_vec3_or_splat);
    })?;
    let degrees = from_rest(degrees, rest);
    Ok(match parameter {
        // The other coordinates keep their bits.
        "position" => {
            let translation = position.into();
            (Affine3A { translation, ..*pose }, None)
        }
        _ => {
            let matrix3 = Turned { scale, degrees }.matrix();
            (Affine3A { matrix3, ..*pose }, Some(EulerAngles(degrees)))
        }
    })
}

fn assign(wanted: &str, text: &str, visit: impl FnOnce(&mut Assign)) -> Result<(), AssignError> {
    let mut visitor = Assign {
        wanted,
        text,
        known: Vec::new(),
        outcome: None,
    };
    visit(&mut visitor);
    let known = visitor.known;
    match visitor.outcome {
        Some(outcome) => outcome,
        None => Err(AssignError::Unknown { known }),
    }
}

impl Assign<'_> {
    fn value<T>(&mut self, name: &'static str, value: &mut T, parse: impl FnOnce(&str) -> Result<T, AssignError>) {
        self.known.push(name);
        if name == self.wanted {
            let parsed = parse(self.text).map(|parsed| *value = parsed);
            self.outcome = Some(parsed);
        }
    }

    /// Sets a value of any type that `parse` reads.
    fn parsed<T>(&mut self, name: &'static str, value: &mut T, parse: impl FnOnce(&str) -> Result<T, ValueError>) {
        self.value(name, value, |text| Ok(parse(text)?));
    }

    fn bounded(&mut self, name: &'static str, value: &mut f32, range: RangeInclusive<f32>) {
        self.value(name, value, |text| within(parse_float(text)?, &range));
    }
}

pub(super) fn within(number: f32, range: &RangeInclusive<f32>) -> Result<f32, AssignError> {
    if range.contains(&number) {
        return Ok(number);
    }
    // The smallest and the largest number of the type are not worth naming.
    let expected = match (*range.start(), *range.end()) {
        (f32::MIN_POSITIVE, f32::MAX) => "more than 0".to_owned(),
        (f32::MIN_POSITIVE, end) => format!("more than 0, up to {end}"),
        (start, f32::MAX) => format!("at least {start}"),
        (start, end) => format!("{start} to {end}"),
    };
    Err(AssignError::Refused(format!("expected {expected}, found {number}")))
}

fn color(most: f32) -> impl Fn(&str) -> Result<Rgb, AssignError> {
    move |text| {
        let color = parse_rgb(text)?;
        let fits = color.min_element() >= 0.0 && color.max_element() <= most;
        fits.then_some(color)
            .ok_or_else(|| AssignError::Refused(format!("expected a colour within 0 to {most}, found `{text}`")))
    }
}

impl Assign<'_> {
    fn declared(&mut self, values: &mut impl Declared) {
        values.visit_mut(&mut |info, value| self.parameter(info, value));
    }

    fn parameter(&mut self, info: &'static ParameterInfo, value: ParameterMut) {
        let name = info.name;
        match value {
            ParameterMut::Reflectance(value) | ParameterMut::Normals(value) => {
                self.value(name, value, |text| Ok(color(1.0)(text)?.into()));
            }
            ParameterMut::Float(value) | ParameterMut::Height(value) => {
                self.value(name, value, |text| Ok(within(parse_float(text)?, &info.range)?.into()));
            }
            ParameterMut::Number(value)
            | ParameterMut::Factor(value)
            | ParameterMut::Angle(value)
            | ParameterMut::SamplingWeight(value)
            | ParameterMut::ExtensionFactor(value) => self.bounded(name, value, info.range.clone()),
            ParameterMut::Flag(value) | ParameterMut::Extension(value) => self.parsed(name, value, parse_boolean),
            ParameterMut::Ior(value) => self.value(name, value, |text| parse_ior(text, &info.range)),
            ParameterMut::ConductorIor(value) => self.value(name, value, parse_conductor),
            ParameterMut::Distribution(value) => self.value(name, value, |text| {
                Distribution::of_name(text)
                    .ok_or_else(|| AssignError::Refused(format!("expected ggx or beckmann, found `{text}`")))
            }),
            ParameterMut::Roughness(value) | ParameterMut::UniformRoughness(value) => {
                self.value(name, value, |text| {
                    Ok(Roughness::Isotropic(within(parse_float(text)?, &ALPHA.range)?.into()))
                });
            }
            ParameterMut::PrincipledIndex(value) => self.value(name, value, |text| {
                Ok(PrincipledIndex::Specular(within(parse_float(text)?, &info.range)?))
            }),
            ParameterMut::Absorption(value) => self.absorption(value),
            ParameterMut::Emission(value) => self.value(name, value, color(f32::MAX)),
            ParameterMut::TexturedEmission(value) => {
                self.value(name, value, |text| Ok(color(f32::MAX)(text)?.into()));
            }
            ParameterMut::UniformReflectance(value) => self.value(name, value, color(1.0)),
            ParameterMut::Integer(value) => {
                self.value(name, value, |text| parse_integer_within(text, &info.range));
            }
            ParameterMut::Picture(value) => self.value(name, value, |text| Ok(settle(text.as_ref()))),
            ParameterMut::OptionalTexture(value) => self.value(name, value, |text| {
                let before = None;
                Ok(Some(Texture::of_picture(settle(text.as_ref()), before)))
            }),
            ParameterMut::Cone(Cone {
                cutoff_angle,
                beam_width,
            }) => {
                self.bounded(CUTOFF_ANGLE.name, cutoff_angle, CUTOFF_ANGLE.range.clone());
                self.bounded(BEAM_WIDTH.name, beam_width, 0.0..=*cutoff_angle);
            }
            ParameterMut::FieldOfView(value) => self.bounded(name, &mut value.fov, info.range.clone()),
            ParameterMut::SunPosition(value) => {
                self.value(name, value, |text| Ok(SunPosition::Direction(parse_vec3(text)?)));
                if let SunPosition::PlaceAndTime(at) = value {
                    self.declared(at);
                }
            }
            ParameterMut::Coefficients(value) => self.coefficients(value),
            ParameterMut::VolumeEmission(value) => {
                self.value(name, value, |text| Ok(color(f32::MAX)(text)?.into()));
            }
            ParameterMut::VolumeShare(value) => {
                self.value(name, value, |text| Ok(within(parse_float(text)?, &info.range)?.into()));
            }
            ParameterMut::Values(value) => self.value(name, value, |text| {
                let values = fields(text).map(parse_float).collect::<Result<Vec<f32>, _>>()?;
                let is_table = values.len() >= 2 && values.iter().all(|value| *value >= 0.0);
                (is_table.then_some(values))
                    .ok_or_else(|| AssignError::Refused("expected two numbers or more, not negative".to_owned()))
            }),
            ParameterMut::Length(value) => self.bounded(name, value, info.file_range()),
            ParameterMut::Count(value) => self.value(name, value, |text| {
                parse_integer_within(text, &info.range).map(|number| number as u32)
            }),
            ParameterMut::Openings(value) => self.value(name, value, |text| Ok(parse_openings(text)?)),
            // Textures are given by files.
            ParameterMut::Nested(_) | ParameterMut::Placing(_) | ParameterMut::Choice(_) | ParameterMut::Stops(_) => {}
        }
    }
}

impl Assign<'_> {
    fn coefficients(&mut self, value: &mut Coefficients) {
        match value {
            Coefficients::Extinction { sigma_t, albedo } => {
                for (info, value) in [(&medium::SIGMA_T, sigma_t), (&medium::ALBEDO, albedo)] {
                    self.value(info.name, value, |text| Ok(color(*info.range.end())(text)?.into()));
                }
            }
            Coefficients::Separate { sigma_s, sigma_a } => {
                for (info, value) in [(&medium::SIGMA_S, sigma_s), (&medium::SIGMA_A, sigma_a)] {
                    self.value(info.name, value, color(*info.range.end()));
                }
            }
        }
    }

    fn absorption(&mut self, value: &mut Absorption) {
        match value {
            Absorption::Melanin { eumelanin, pheomelanin } => {
                self.bounded(EUMELANIN.name, eumelanin, EUMELANIN.range.clone());
                self.bounded(PHEOMELANIN.name, pheomelanin, PHEOMELANIN.range.clone());
            }
            Absorption::Given { scale, .. } => {
                self.bounded(ABSORPTION_SCALE.name, scale, ABSORPTION_SCALE.range.clone())
            }
        }
        self.value(SIGMA_A.name, value, |text| {
            Ok(Absorption::Given {
                sigma_a: color(f32::MAX)(text)?.into(),
                scale: ABSORPTION_SCALE.usual,
            })
        });
    }
}

fn parse_integer_within(text: &str, range: &RangeInclusive<f32>) -> Result<i32, AssignError> {
    let number = i32::try_from(parse_integer(text)?)
        .ok()
        .filter(|number| range.contains(&(*number as f32)));
    number.ok_or_else(|| AssignError::Refused(format!("expected {} to {}, found {text}", range.start(), range.end())))
}

fn parse_ior(text: &str, range: &RangeInclusive<f32>) -> Result<Ior, AssignError> {
    match parse_float(text) {
        Ok(index) => Ok(Ior::Number(within(index, range)?)),
        Err(_) => crate::shading::ior::dielectric_ior(text)
            .map(|_| Ior::Named(text.to_owned()))
            .ok_or_else(|| AssignError::Refused(format!("`{text}` is neither a number nor a known dielectric"))),
    }
}

fn parse_conductor(text: &str) -> Result<ConductorIor, AssignError> {
    let is_known = text == "none" || crate::shading::ior::CONDUCTORS.iter().any(|metal| metal.0 == text);
    is_known
        .then(|| ConductorIor::Named(text.to_owned()))
        .ok_or_else(|| AssignError::Refused(format!("`{text}` is no known metal")))
}
