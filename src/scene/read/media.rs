//! Reads participating media: their coefficients, phase functions and volumes.

use std::ops::RangeInclusive;

use bevy::math::Affine3A;

use super::from_file::FromFile;
use super::parameters::{Parameters, report_left_out};
use super::picture_search::PictureSearch;
use super::scene_reader::{SceneReader, address};
use super::spectra::{is_spectrum, read_spectrum};
use crate::color::Rgb;
use crate::document::spectrum::Role;
use crate::document::value::{fields, parse_float};
use crate::document::{Category, Object, Reader, Severity};
use crate::scene::components::description::{DeclarationPlace, MediumDescription};
use crate::scene::components::medium::{ALBEDO, EXTERIOR, GRID, INTERIOR, SIGMA_A, SIGMA_S, SIGMA_T, USE_GRID_BBOX};
use crate::scene::encode::objects;
use crate::scene::{
    Coefficients, GridFile, Medium, Parameter, ParameterInfo, PhaseFunction, VolumeFilter, VolumeFormat,
    VolumeParameter, VolumeWrap,
};

impl<'a> SceneReader<'a> {
    /// The index of this medium in the description; it is read once for all references. `place` is where it is declared
    /// if that is not the top level. None (reported) if there is no such plugin.
    pub(super) fn read_medium(&mut self, object: &'a Object, place: DeclarationPlace) -> Option<usize> {
        if let Some(&known) = self.medium_of.get(&address(object)) {
            return known;
        }
        let reader = Reader::new(&self.index, object, &mut self.diagnostics);
        let read = read_parameters(reader, &mut self.pictures).map(|medium| {
            let identity = self.identity(object, |folder| objects::medium(&medium, folder));
            let is_top_level = self.is_top_level(object);
            self.description.media.push(MediumDescription {
                identity,
                medium,
                declared_in: if is_top_level {
                    DeclarationPlace::TopLevel
                } else {
                    place
                },
            });
            self.description.media.len() - 1
        });
        self.medium_of.insert(address(object), read);
        read
    }

    /// The medium of a sensor or an emitter, among those nested in it.
    pub(super) fn read_medium_around(
        &mut self,
        media: &[(Option<&str>, &'a Object)],
        place: DeclarationPlace,
    ) -> Option<usize> {
        if let Some((_, second)) = media.get(1) {
            let message = "a second medium: only one can be around a camera or a light";
            self.diagnostics.error(second.span, message);
        }
        let (_, medium) = media.first()?;
        self.read_medium(medium, place)
    }
}

/// The interior and exterior media of a shape. Others stay unread.
pub(super) fn media_of_shape<'a>(reader: &mut Reader<'a, '_>) -> [Option<&'a Object>; 2] {
    [INTERIOR, EXTERIOR].map(|side| {
        let medium = reader.child(side)?;
        if medium.category != Category::Medium {
            let message = format!("`{side}` should be a medium, found {}", medium.title());
            reader.error_at(side, message);
            return None;
        }
        Some(medium)
    })
}

fn read_parameters(mut reader: Reader, files: &mut PictureSearch) -> Option<Medium> {
    let plugin = reader.object().plugin.as_str();
    let Some(mut medium) = Medium::of_plugin(plugin) else {
        let help = reader.diagnostics().did_you_mean(plugin, Medium::PLUGINS);
        report_left_out(&mut reader, false, help);
        return None;
    };
    let values = FromFile {
        reader: &mut reader,
        pictures: files,
    };
    values.read_all(&mut medium);
    if let Some(phase) = phase_inside(&mut reader, files) {
        medium.phase = phase;
    }
    // This program chooses the positions of the samples.
    reader.ignore(&["sample_emitters"]);
    reader.finish();
    Some(medium)
}

impl FromFile<'_, '_, '_> {
    pub(super) fn coefficients(&mut self, value: &mut Coefficients) {
        let is_heterogeneous =
            matches!(value, Coefficients::Extinction { sigma_t, .. } if sigma_t.constant().is_none());
        let separate = [&SIGMA_S, &SIGMA_A].map(|info| self.reader.rgb_in(info.name, info.range.clone()));
        let [sigma_t, albedo] = [&SIGMA_T, &ALBEDO].map(|info| self.volume_color(info));
        if separate == [None; 2] {
            if let Coefficients::Extinction {
                sigma_t: usual_sigma_t,
                albedo: usual_albedo,
            } = value
            {
                *usual_sigma_t = self.density(sigma_t, usual_sigma_t);
                *usual_albedo = albedo.unwrap_or(usual_albedo.clone());
            }
            return;
        }
        let given = [SIGMA_S.name, SIGMA_A.name]
            .into_iter()
            .find(|name| self.reader.has(name));
        let given = given.unwrap_or(SIGMA_S.name);
        if sigma_t.is_some() || albedo.is_some() {
            let message =
                "`sigma_t`, `albedo` and `sigma_s`, `sigma_a` exclude each other: both say how dense the medium is";
            self.reader.error_at(given, message);
        }
        if is_heterogeneous {
            let message =
                format!("`{given}` is for a `homogeneous` medium: `heterogeneous` takes `sigma_t` and `albedo`");
            self.reader.error_at(given, message);
        }
        let [sigma_s, sigma_a] = separate.map(Option::unwrap_or_default);
        *value = Coefficients::Separate { sigma_s, sigma_a };
    }

    /// The given density in the form of its plugin, or the default.
    fn density(&mut self, given: Option<VolumeParameter<Rgb>>, usual: &VolumeParameter<Rgb>) -> VolumeParameter<Rgb> {
        match (given, usual) {
            (None, usual) => usual.clone(),
            // The format bounds a heterogeneous medium by the box of its density.
            (Some(VolumeParameter::Constant(value)), VolumeParameter::Box { .. }) => VolumeParameter::Box {
                value,
                to_world: Affine3A::IDENTITY,
            },
            (Some(VolumeParameter::Box { value, .. }), VolumeParameter::Constant(_)) => value.into(),
            (Some(grid @ VolumeParameter::Grid(_)), VolumeParameter::Constant(_)) => {
                let message = "`homogeneous` is the same everywhere: with a grid it is read as `heterogeneous`";
                self.reader.warn_at(SIGMA_T.name, message);
                grid
            }
            (Some(other), _) => other,
        }
    }

    /// A colour that may vary in space. None if the file does not give it, or if it is unusable, which has been
    /// reported.
    pub(super) fn volume_color(&mut self, info: &ParameterInfo) -> Option<VolumeParameter<Rgb>> {
        let role = Role::of(self.reader.object().category, info.name);
        read_volume(self.reader, info.name, role, &info.range, self.pictures)
    }

    /// Reads a number that may vary in space, like [`Self::volume_color`]. A colour counts as its mean.
    pub(super) fn volume_number(&mut self, info: &ParameterInfo) -> Option<VolumeParameter<f32>> {
        let mean = |color: Rgb| color.element_sum() / 3.0;
        Some(match self.volume_color(info)? {
            VolumeParameter::Constant(color) => mean(color).into(),
            VolumeParameter::Box { value, to_world } => VolumeParameter::Box {
                value: mean(value),
                to_world,
            },
            VolumeParameter::Grid(grid) => VolumeParameter::Grid(grid),
        })
    }

    pub(super) fn weight(&mut self, info: &ParameterInfo, value: &mut VolumeParameter<f32>) {
        let is_given = self.reader.has(info.name) || self.reader.child(info.name).is_some();
        if let Some(given) = self.volume_number(info) {
            *value = given;
        } else if !is_given && !self.reader.refers_to_nothing() {
            let message = format!("{} needs a `{}`", self.reader.object().title(), info.name);
            self.reader.error_at(info.name, message);
        }
    }

    pub(super) fn values(&mut self, name: &str, values: &mut Vec<f32>) {
        let Some(text) = self.reader.string(name) else {
            if !self.reader.has(name) {
                let message = format!("{} needs `{name}`, a list of numbers", self.reader.object().title());
                self.reader.error_at(name, message);
            }
            return;
        };
        let most = PhaseFunction::MOST_VALUES;
        let numbers: Result<Vec<f32>, _> = fields(text).take(most + 1).map(parse_float).collect();
        let problem = match numbers {
            Err(error) => error.to_string(),
            Ok(numbers) if numbers.len() < 2 => format!("a table needs at least two numbers, found {}", numbers.len()),
            Ok(numbers) if numbers.len() > most => format!("a table has at most {most} numbers"),
            Ok(numbers) if numbers.iter().any(|number| *number < 0.0) => "a number of the table is negative".to_owned(),
            Ok(numbers) if numbers.iter().all(|number| *number == 0.0) => {
                "all numbers of the table are 0: light would go nowhere".to_owned()
            }
            Ok(numbers) => {
                *values = numbers;
                return;
            }
        };
        self.reader.error_at(name, problem);
    }
}

/// The phase function of a medium.
fn phase_inside(reader: &mut Reader, files: &mut PictureSearch) -> Option<PhaseFunction> {
    let inside = reader.children(Category::Phase);
    if let Some((_, second)) = inside.get(1) {
        let message = format!("{} has a phase function already", reader.object().title());
        reader.diagnostics().error(second.span, message);
    }
    let &(_, phase) = inside.first()?;
    let most = PhaseFunction::MOST;
    if reader.count_inside(phase, Category::Phase, most) > most {
        let message = format!("this phase function consists of more than {most}");
        reader.diagnostics().error(phase.span, message);
        return None;
    }
    Some(reader.apart(phase, |reader| read_phase(reader, files)))
}

fn read_phase(mut reader: Reader, files: &mut PictureSearch) -> PhaseFunction {
    let plugin = reader.object().plugin.as_str();
    let Some(mut phase) = PhaseFunction::of_plugin(plugin) else {
        let message = format!("phase `{plugin}` is not supported: `isotropic` takes its place");
        let help = reader.diagnostics().did_you_mean(plugin, PhaseFunction::PLUGINS);
        let span = reader.object().span;
        reader.diagnostics().push(Severity::Warning, Some(span), message, help);
        return PhaseFunction::default();
    };
    let values = FromFile {
        reader: &mut reader,
        pictures: files,
    };
    values.read_all(&mut phase);
    if let PhaseFunction::Blend(blend) = &mut phase {
        let inside = reader.children(Category::Phase);
        match inside[..] {
            [(_, first), (_, second)] => {
                blend.of = [first, second].map(|part| reader.apart(part, |reader| read_phase(reader, files)));
            }
            _ if reader.refers_to_nothing() => {}
            _ => {
                let message = format!("`blendphase` takes two phase functions, found {}", inside.len());
                let span = reader.object().span;
                reader.diagnostics().error(span, message);
            }
        }
    }
    reader.finish();
    phase
}

/// A colour or a volume; None if the file does not give it, or if it is unusable, which has been reported.
fn read_volume(
    reader: &mut Reader,
    name: &str,
    role: Role,
    range: &RangeInclusive<f32>,
    files: &mut PictureSearch,
) -> Option<VolumeParameter<Rgb>> {
    let Some(object) = reader.child(name) else {
        // The range has already been checked.
        let color = reader.rgb_in(name, range.clone())?;
        let color = match role {
            Role::Emission => reader.emission(name).unwrap_or(color),
            _ => color,
        };
        return Some(color.into());
    };
    match (object.category, object.plugin.as_str()) {
        (Category::Texture, plugin) if is_spectrum(plugin) => {
            let color = reader.nested(object, |reader| read_spectrum(reader, role, files))?;
            match color {
                Parameter::Constant(color) if color.to_array().iter().all(|channel| range.contains(channel)) => {
                    Some(color.into())
                }
                Parameter::Constant(color) => {
                    let (low, high) = (range.start(), range.end());
                    reader.error_at(name, format!("`{name}` is {color}, but should be from {low} to {high}"));
                    None
                }
                Parameter::Texture(_) => {
                    reader.error_at(
                        name,
                        format!("`{name}` should be a colour or a volume, found a texture"),
                    );
                    None
                }
            }
        }
        (Category::Volume, "constvolume") => {
            reader.nested(object, |reader| constant_volume(reader, role, range, files))
        }
        (Category::Volume, "gridvolume") => reader.nested(object, |reader| grid_volume(reader, files)),
        (Category::Volume, "vdbvolume") => reader.nested(object, |reader| vdb_volume(reader, files)),
        (Category::Volume, plugin) => {
            let message = format!("volume `{plugin}` is not supported");
            let help = reader
                .diagnostics()
                .did_you_mean(plugin, ["constvolume", "gridvolume", "vdbvolume"]);
            reader
                .diagnostics()
                .push(Severity::Error, Some(object.span), message, help);
            None
        }
        _ => {
            let message = format!("`{name}` should be a colour or a volume, found {}", object.title());
            reader.diagnostics().error(object.span, message);
            None
        }
    }
}

fn constant_volume(
    reader: &mut Reader,
    role: Role,
    range: &RangeInclusive<f32>,
    files: &mut PictureSearch,
) -> Option<VolumeParameter<Rgb>> {
    let to_world = reader.to_world();
    if !reader.has("value") && reader.child("value").is_none() {
        // The format's default.
        return Some(boxed(Rgb::ONE, to_world?));
    }
    let value = read_volume(reader, "value", role, range, files)?;
    match value.constant() {
        Some(value) => Some(boxed(value, to_world?)),
        None => {
            reader.error_at(
                "value",
                "the `value` of `constvolume` should be a colour, found a volume",
            );
            None
        }
    }
}

fn boxed(value: Rgb, to_world: Affine3A) -> VolumeParameter<Rgb> {
    match to_world == Affine3A::IDENTITY {
        true => value.into(),
        false => VolumeParameter::Box { value, to_world },
    }
}

fn grid_volume(reader: &mut Reader, files: &mut PictureSearch) -> Option<VolumeParameter<Rgb>> {
    // This program decides how the grid is stored in memory, and uses its values unchanged.
    reader.ignore(&["accel", "raw"]);
    let filter = named(reader, "filter_type", &VolumeFilter::ALL, VolumeFilter::name).unwrap_or_default();
    let wrap = named(reader, "wrap_mode", &VolumeWrap::ALL, VolumeWrap::name).unwrap_or_default();
    let use_grid_bbox = reader.boolean_or(USE_GRID_BBOX, false);
    placed_file(reader, VolumeFormat::Vol, files).map(|placed| {
        VolumeParameter::Grid(GridFile {
            filter,
            wrap,
            use_grid_bbox,
            ..placed
        })
    })
}

fn vdb_volume(reader: &mut Reader, files: &mut PictureSearch) -> Option<VolumeParameter<Rgb>> {
    let filter = named(reader, "filter_type", &VolumeFilter::ALL, VolumeFilter::name).unwrap_or_default();
    let grid = reader.string(GRID).filter(|name| !name.is_empty()).map(str::to_owned);
    let placed = placed_file(reader, VolumeFormat::Vdb { grid }, files);
    placed.map(|placed| VolumeParameter::Grid(GridFile { filter, ..placed }))
}

/// A file with its transform.
fn placed_file(reader: &mut Reader, format: VolumeFormat, files: &mut PictureSearch) -> Option<GridFile> {
    let to_world = reader.to_world();
    let Some(name) = reader.string("filename") else {
        if !reader.has("filename") {
            let message = format!("a `{}` needs a `filename`", format.plugin());
            reader.error_at("filename", message);
        }
        return None;
    };
    Some(GridFile {
        path: files.find_volume(name, &format, reader)?,
        format,
        to_world: to_world?,
        ..GridFile::default()
    })
}

/// The value of this name; an unknown one is an error, as in Mitsuba.
fn named<T: Copy>(reader: &mut Reader, parameter: &str, all: &[T], name: fn(T) -> &'static str) -> Option<T> {
    let text = reader.string(parameter)?;
    let found = all.iter().copied().find(|&value| name(value) == text);
    if found.is_none() {
        let names: Vec<String> = all.iter().map(|&value| format!("`{}`", name(value))).collect();
        let message = format!("expected {} for `{parameter}`, found `{text}`", names.join(" or "));
        reader.error_at(parameter, message);
    }
    found
}
