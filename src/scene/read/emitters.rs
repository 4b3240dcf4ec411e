//! Reads emitters, including the `area` of shapes.

use std::path::Path;

use bevy::math::{Affine3A, Vec3};

use super::from_file::FromFile;
use super::parameters::{Parameters, report_left_out};
use super::picture_search::PictureSearch;
use super::scene_reader::{SceneReader, angles_of};
use crate::document::value::quote;
use crate::document::{Category, Object, Reader};
use crate::scene::components::description::{DeclarationPlace, EmitterDescription};
use crate::scene::components::emitter::frame_along;
use crate::scene::components::marker::FORM;
use crate::scene::encode::lights;
use crate::scene::{AreaLight, Emitter, EmitterKind, SunPosition, SunSky};

impl<'a> SceneReader<'a> {
    /// Whether the emitter became part of the description.
    pub(super) fn read_emitter(&mut self, object: &'a Object) -> bool {
        // An `area` is read by the shapes that refer to it.
        if object.plugin == "area" {
            if object.id.is_none() {
                let message = "an `area` emitter has no effect outside of a shape";
                self.diagnostics.warn(object.span, message);
            }
            return false;
        }
        let reader = Reader::new(&self.index, object, &mut self.diagnostics);
        let Some((emitter, to_world, media)) = read_parameters(reader, &mut self.pictures) else {
            return false;
        };
        let place = DeclarationPlace::Emitter(self.description.emitters.len());
        let before = self.declared();
        let medium = self.read_medium_around(&media, place);
        let Some(to_world) = to_world else {
            self.forget_place(place, before);
            return false;
        };
        let as_read = |folder: &Path| lights::emitter(&emitter, &to_world, angles_of(object), folder);
        let mut identity = self.identity(object, as_read);
        if let Some(authored) = &mut identity.authored {
            authored.leave_out_media(|_, number| number == 0 && medium.is_some());
        }
        self.description.emitters.push(EmitterDescription {
            identity,
            emitter,
            to_world,
            medium,
        });
        true
    }

    /// The emission of a shape; None (reported) if the emitter is not an `area`.
    pub(super) fn read_area_light(&mut self, object: &'a Object) -> Option<AreaLight> {
        if object.plugin != "area" {
            let message = format!("{} has no effect in a shape, only `area` has", object.title());
            self.diagnostics.warn(object.span, message);
            return None;
        }
        let mut reader = Reader::new(&self.index, object, &mut self.diagnostics);
        let mut light = AreaLight::default();
        let values = FromFile {
            reader: &mut reader,
            pictures: &mut self.pictures,
        };
        values.read_all(&mut light);
        reader.finish();
        Some(light)
    }
}

/// The emitters of Mitsuba, also of old versions, that this program lacks.
const FOREIGN_EMITTERS: [&str; 6] = [
    "directionalarea",
    "timed_sunsky",
    "volumelight",
    "sky",
    "sun",
    "collimated",
];

/// The marker that a volume stands for; None (reported) if it has no known form.
fn marker(reader: &mut Reader) -> Option<Emitter> {
    reader.ignore(&["value"]);
    let form = reader.string(FORM).unwrap_or_default();
    let marker = Emitter::of_form(form);
    if marker.is_none() {
        let forms: Vec<&str> = Emitter::forms().collect();
        let message = format!(
            "expected a form of markers ({}), found {}",
            forms.join(", "),
            quote(form)
        );
        reader.error_at(FORM, message);
    }
    marker
}

/// The media nested in an object, with their parameter names.
type Media<'a> = Vec<(Option<&'a str>, &'a Object)>;

/// The emitter with its transform and the media around it. If the transform is None, the error has been reported.
fn read_parameters<'a>(
    mut reader: Reader<'a, '_>,
    pictures: &mut PictureSearch,
) -> Option<(Emitter, Option<Affine3A>, Media<'a>)> {
    let plugin = reader.object().plugin.as_str();
    if reader.object().category == Category::Volume {
        let marker = marker(&mut reader)?;
        let to_world = reader.to_world();
        reader.finish();
        return Some((marker, to_world, Media::new()));
    }
    // Markers have plugins in this program alone.
    let Some(mut emitter) = Emitter::of_plugin(plugin).filter(|emitter| !emitter.is_marker()) else {
        let lights = Emitter::PLUGINS.into_iter().filter(|name| !name.starts_with("marker"));
        let help = reader.diagnostics().did_you_mean(plugin, lights);
        report_left_out(&mut reader, FOREIGN_EMITTERS.contains(&plugin), help);
        return None;
    };
    let values = FromFile {
        reader: &mut reader,
        pictures,
    };
    values.read_all(&mut emitter);
    let to_world = match emitter.kind {
        EmitterKind::Point { .. } => place(&mut reader),
        EmitterKind::Directional { .. } => direction(&mut reader),
        _ => reader.to_world(),
    };
    if let EmitterKind::SunSky(sky) = &emitter.kind {
        warn_of_night(&mut reader, sky, to_world);
    }
    let media = reader.children(Category::Medium);
    reader.finish();
    Some((emitter, to_world, media))
}

/// Warns of a sun that is placed below the horizon, most often because the file means another axis to be up.
fn warn_of_night(reader: &mut Reader, sky: &SunSky, to_world: Option<Affine3A>) {
    let SunPosition::Direction(direction) = sky.sun else {
        return;
    };
    let up = to_world.map_or(Vec3::Z, |to_world| to_world.matrix3.z_axis.into());
    let below = -direction.normalize_or_zero().dot(up.normalize_or_zero());
    let degrees = below.min(1.0).asin().to_degrees();
    // A sun on the horizon may be below it by rounding.
    if degrees > 0.1 {
        let message = format!(
            "the sun is {degrees:.1} degrees below the horizon, so that sun and sky are black: up is the z axis of `to_world`"
        );
        reader.warn_at("sun_direction", message);
    }
}

/// The transform, from `position` or `to_world`.
fn place(reader: &mut Reader) -> Option<Affine3A> {
    let Some(position) = reader.point("position") else {
        return reader.to_world();
    };
    exclude_to_world(reader, "position");
    Some(Affine3A::from_translation(position))
}

/// A frame along the direction, from `direction` or `to_world`; None (reported) for one of zero length.
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
