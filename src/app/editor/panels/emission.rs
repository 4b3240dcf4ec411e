//! Light: of a shape, or of what is no shape.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use bevy::math::Vec3;
use bevy_egui::egui::Ui;

use super::fields;
use super::material::{Edit, Rows, label};
use super::sensor::field_of_view;
use crate::color::Rgb;
use crate::scene::{AreaLight, Emitter, EmitterVisitor, FovAxis, Parameter, PlaceAndTime, SunPosition, Texture};

/// What plugins are called in lists, where not by their own name.
const KINDS: [(&str, &str); 2] = [("envmap", "environment map"), ("sunsky", "sun and sky")];

/// The check box makes a shape emit, or not.
pub fn area_light(ui: &mut Ui, light: &mut Option<AreaLight>) -> Edit {
    let mut emits = light.is_some();
    let toggled = fields::checkbox(ui, "Emits light", &mut emits);
    if toggled {
        *light = emits.then(AreaLight::default);
    }
    let mut rows = Rows::new(ui);
    if let Some(light) = light {
        light.visit(&mut rows);
    }
    Edit {
        changed: rows.edit.changed || toggled,
        ..rows.edit
    }
}

pub fn emitter(ui: &mut Ui, emitter: &mut Emitter) -> Edit {
    fields::note(ui, "Type", kind_name(emitter));
    let mut rows = Rows::new(ui);
    emitter.visit(&mut rows);
    rows.edit
}

/// The name of the kind, for lists.
pub fn kind_name(emitter: &Emitter) -> &'static str {
    let plugin = emitter.plugin();
    let known = KINDS.iter().find(|(known, _)| *known == plugin);
    known.map_or(plugin, |(_, words)| words)
}

/// Of a radiometric quantity.
fn unit(name: &str) -> &'static str {
    match name {
        "intensity" => " W/sr",
        "irradiance" => " W/m²",
        _ => " W/m²sr",
    }
}

impl EmitterVisitor for Rows<'_> {
    fn emission(&mut self, name: &'static str, value: &mut Rgb) {
        self.edit.changed |= fields::emission(self.ui, unit(name), value);
    }

    fn textured_emission(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        match value {
            Parameter::Constant(color) => {
                self.emission(name, color);
                self.choose_picture(name, "Picture", "none");
            }
            Parameter::Texture(_) => self.texture(name, value, Rgb::ONE),
        }
    }

    fn uniform_reflectance(&mut self, name: &'static str, value: &mut Rgb) {
        self.edit.changed |= fields::color(self.ui, &label(name), value);
    }

    fn integer(&mut self, name: &'static str, value: &mut i32, range: RangeInclusive<i32>) {
        self.edit.changed |= fields::integer(self.ui, &label(name), value, range);
    }

    fn angle(&mut self, name: &'static str, value: &mut f32, range: RangeInclusive<f32>) {
        self.edit.changed |= fields::quantity(self.ui, &label(name), value, 0.1, range, "°");
    }

    fn picture(&mut self, name: &'static str, value: &mut PathBuf) {
        let file = value.file_name().unwrap_or_default().to_string_lossy();
        self.choose_picture(name, "Picture", &file);
    }

    fn optional_texture(&mut self, name: &'static str, value: &mut Option<Texture>) {
        let Some(texture) = value else {
            return self.choose_picture(name, "Picture", "none");
        };
        if self.texture_row(name, texture) {
            *value = None;
        }
    }

    fn cone(&mut self, cutoff_angle: &mut f32, beam_width: &mut f32) {
        let mut angle = |name, value: &mut f32, range| {
            fields::slider_with(self.ui, name, value, range, |slider| slider.suffix("°"))
        };
        let mut changed = angle("Cutoff", cutoff_angle, 0.1..=90.0);
        // A narrower cone has a narrower beam.
        if changed {
            *beam_width = beam_width.min(*cutoff_angle);
        }
        changed |= angle("Beam", beam_width, 0.0..=*cutoff_angle);
        self.edit.changed |= changed;
    }

    fn field_of_view(&mut self, fov: &mut f32, axis: &mut FovAxis) {
        self.edit.changed |= field_of_view(self.ui, fov, axis);
    }

    fn sun_position(&mut self, value: &mut SunPosition) {
        let given = matches!(value, SunPosition::Direction(_));
        let mut wanted = given;
        let ways = [(false, "place and time"), (true, "direction")];
        if fields::choice(self.ui, "Sun by", &mut wanted, &ways) {
            *value = if wanted {
                SunPosition::Direction(Vec3::new(0.0, 1.0, 1.0))
            } else {
                SunPosition::PlaceAndTime(PlaceAndTime::default())
            };
            self.edit.changed = true;
        }
        if let SunPosition::Direction(direction) = value {
            self.edit.changed |= fields::vector(self.ui, "Towards sun", direction, 0.01, "");
        }
    }

    fn sampling_weight(&mut self, value: &mut f32) {
        self.edit.changed |= fields::number(self.ui, &label("sampling_weight"), value, 0.01, 0.0..=f32::MAX);
    }
}
