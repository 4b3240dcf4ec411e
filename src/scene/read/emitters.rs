//! Emitters, and inside shapes `area`.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use bevy::math::Affine3A;

use super::bsdfs::FromFile;
use super::parameters::{Parameters, report_left_out};
use super::picture_search::PictureSearch;
use super::scene_reader::SceneReader;
use super::sensors::read_fov;
use crate::color::Rgb;
use crate::document::suggest::did_you_mean;
use crate::document::{Object, Reader};
use crate::scene::description::EmitterDescription;
use crate::scene::emitter::frame_along;
use crate::scene::encode::lights;
use crate::scene::{
    AreaLight, Emitter, EmitterKind, EmitterVisitor, FovAxis, Parameter, PlaceAndTime, SunPosition, Texture,
};

impl<'a> SceneReader<'a> {
    /// Whether the emitter became part of the description.
    pub(super) fn read_emitter(&mut self, object: &'a Object) -> bool {
        // Read by the shapes that refer to it.
        if object.plugin == "area" {
            if object.id.is_none() {
                let message = "an `area` emitter has no effect outside of a shape";
                self.diagnostics.warn(object.span, message);
            }
            return false;
        }
        let reader = Reader::new(&self.index, object, &mut self.diagnostics);
        let Some((emitter, to_world)) = read_parameters(reader, &mut self.pictures) else {
            return false;
        };
        let as_read = || lights::emitter(&emitter, &to_world, &self.folder);
        let identity = self.identity(object, as_read);
        self.description.emitters.push(EmitterDescription {
            identity,
            emitter,
            to_world,
        });
        true
    }

    /// The light of a shape; None (reported) if the emitter is not of that kind.
    pub(super) fn read_area_light(&mut self, object: &'a Object) -> Option<AreaLight> {
        if object.plugin != "area" {
            let message = format!("{} has no effect in a shape, only `area` has", object.title());
            self.diagnostics.warn(object.span, message);
            return None;
        }
        let mut reader = Reader::new(&self.index, object, &mut self.diagnostics);
        let mut light = AreaLight::default();
        light.visit(&mut FromFile {
            reader: &mut reader,
            pictures: &mut self.pictures,
        });
        reader.finish();
        Some(light)
    }
}

/// Emitters of Mitsuba, also of old versions, that this program does not have.
const FOREIGN_EMITTERS: [&str; 6] = [
    "directionalarea",
    "timed_sunsky",
    "volumelight",
    "sky",
    "sun",
    "collimated",
];

fn read_parameters(mut reader: Reader, pictures: &mut PictureSearch) -> Option<(Emitter, Affine3A)> {
    let plugin = reader.object().plugin.as_str();
    let Some(mut emitter) = Emitter::of_plugin(plugin) else {
        let help = did_you_mean(plugin, Emitter::PLUGINS);
        report_left_out(&mut reader, FOREIGN_EMITTERS.contains(&plugin), help);
        return None;
    };
    emitter.visit(&mut FromFile {
        reader: &mut reader,
        pictures,
    });
    let to_world = match emitter.kind {
        EmitterKind::Point { .. } => place(&mut reader),
        EmitterKind::Directional { .. } => direction(&mut reader),
        _ => reader.to_world(),
    };
    reader.finish();
    Some((emitter, to_world?))
}

/// `position` or `to_world`.
fn place(reader: &mut Reader) -> Option<Affine3A> {
    let Some(position) = reader.point("position") else {
        return reader.to_world();
    };
    exclude_to_world(reader, "position");
    Some(Affine3A::from_translation(position))
}

/// `direction` or `to_world`; None (reported) for one without length.
fn direction(reader: &mut Reader) -> Option<Affine3A> {
    let Some(direction) = reader.vector("direction") else {
        return reader.to_world();
    };
    exclude_to_world(reader, "direction");
    if direction.try_normalize().is_none() {
        reader.error_at("direction", "`direction` has no length");
        return None;
    }
    Some(frame_along(direction))
}

fn exclude_to_world(reader: &mut Reader, instead: &str) {
    if reader.has("to_world") {
        reader.error_at("to_world", format!("`to_world` and `{instead}` exclude each other"));
        reader.ignore(&["to_world"]);
    }
}

impl EmitterVisitor for FromFile<'_, '_, '_> {
    fn emission(&mut self, name: &'static str, value: &mut Rgb) {
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

    fn textured_emission(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        if let Some(given) = self.reader.radiometric(name, self.pictures) {
            *value = given;
        }
    }

    fn uniform_reflectance(&mut self, name: &'static str, value: &mut Rgb) {
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

    fn integer(&mut self, name: &'static str, value: &mut i32, range: RangeInclusive<i32>) {
        let range = i64::from(*range.start())..=i64::from(*range.end());
        let given = self.reader.integer_in(name, range);
        *value = given.and_then(|given| i32::try_from(given).ok()).unwrap_or(*value);
    }

    fn angle(&mut self, name: &'static str, value: &mut f32, range: RangeInclusive<f32>) {
        *value = self.reader.float_in(name, range).unwrap_or(*value);
    }

    fn picture(&mut self, name: &'static str, value: &mut PathBuf) {
        if let Some(file) = self.reader.string(name) {
            *value = self.pictures.find(file, self.reader);
        } else if !self.reader.has(name) {
            let message = format!("{} needs a `{name}`", self.reader.object().title());
            self.reader.error_at(name, message);
        }
    }

    fn optional_texture(&mut self, name: &'static str, value: &mut Option<Texture>) {
        *value = self.reader.texture(name, self.pictures);
    }

    fn cone(&mut self, cutoff_angle: &mut f32, beam_width: &mut f32) {
        let cutoff = self.reader.float_in("cutoff_angle", 0.01..=180.0);
        *cutoff_angle = cutoff.unwrap_or(*cutoff_angle);
        let beam = self.reader.float_in("beam_width", 0.0..=360.0);
        *beam_width = beam.unwrap_or(0.75 * *cutoff_angle);
        if *beam_width > *cutoff_angle {
            let message = "`beam_width` is above `cutoff_angle`: the beam ends there";
            self.reader.warn_at("beam_width", message);
            *beam_width = *cutoff_angle;
        }
    }

    fn field_of_view(&mut self, fov: &mut f32, axis: &mut FovAxis) {
        (*fov, *axis) = read_fov(self.reader);
    }

    fn sun_position(&mut self, value: &mut SunPosition) {
        let Some(direction) = self.reader.vector("sun_direction") else {
            return;
        };
        if let Some(other) = PlaceAndTime::NAMES.into_iter().find(|name| self.reader.has(name)) {
            let message = format!("`sun_direction` and `{other}` exclude each other: both say where the sun stands");
            self.reader.error_at(other, message);
            self.reader.ignore(&PlaceAndTime::NAMES);
        }
        if direction.try_normalize().is_none() {
            self.reader.error_at("sun_direction", "`sun_direction` has no length");
        }
        *value = SunPosition::Direction(direction);
    }

    fn sampling_weight(&mut self, value: &mut f32) {
        let given = self.reader.float_in("sampling_weight", 0.0..=f32::MAX);
        *value = given.unwrap_or(*value);
    }
}
