//! Light: of a shape, or of what is no shape.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use bevy::math::Vec3;
use bevy_egui::egui::Ui;

use super::material::{Edit, Rows};
use super::sensor::field_of_view;
use super::texture_slot::picture_row;
use super::{color_field, fields};
use crate::app::editor::command::conversion::emitter_turned_into;
use crate::app::editor::model::panel_textures::PanelTextures;
use crate::app::editor::words::kinds::{EMITTER_KINDS, in_words};
use crate::color::Rgb;
use crate::scene::{
    AreaLight, Emitter, EmitterVisitor, FovAxis, Parameter, PlaceAndTime, SquarePath, SunPosition, Texture,
};

/// The check box makes a shape emit, or not.
pub fn area_light(ui: &mut Ui, light: &mut Option<AreaLight>, textures: &PanelTextures) -> Edit {
    let mut emits = light.is_some();
    let toggled = fields::checkbox(ui, "Emits light", &mut emits);
    if toggled {
        *light = emits.then(AreaLight::default);
    }
    let mut rows = Rows::new(ui, "area", textures);
    if let Some(light) = light {
        light.visit(&mut rows);
    }
    Edit {
        changed: rows.edit.changed || toggled,
        ..rows.edit
    }
}

/// The rows of a light that is no surface. Another kind of light is chosen in the first of them.
pub fn emitter(ui: &mut Ui, emitter: &mut Emitter, textures: &PanelTextures) -> Edit {
    let plugin = emitter.plugin();
    let mut wanted = plugin;
    let options = Emitter::PLUGINS.map(|plugin| (plugin, in_words(&EMITTER_KINDS, plugin)));
    if fields::choice(ui, "Type", &mut wanted, &options) {
        *emitter = emitter_turned_into(emitter, wanted);
        // An environment is nothing without one.
        let wants_picture = (wanted == "envmap").then_some(("filename", SquarePath::WHOLE));
        return Edit {
            changed: true,
            wants_picture,
        };
    }
    let mut rows = Rows::new(ui, plugin, textures);
    emitter.visit(&mut rows);
    rows.edit
}

impl EmitterVisitor for Rows<'_> {
    fn emission(&mut self, name: &'static str, value: &mut Rgb) {
        self.edit.changed |= color_field::emission(self.ui, self.caption(name), self.unit(name), value);
    }

    fn textured_emission(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        let unit = self.unit(name);
        self.slot(name, "colour", value, Rgb::ONE, |ui, caption, color| {
            color_field::emission(ui, caption, unit, color)
        });
    }

    fn uniform_reflectance(&mut self, name: &'static str, value: &mut Rgb) {
        self.edit.changed |= color_field::color(self.ui, self.caption(name), value);
    }

    fn integer(&mut self, name: &'static str, value: &mut i32, range: RangeInclusive<i32>) {
        self.edit.changed |= fields::integer(self.ui, self.caption(name), value, range);
    }

    fn angle(&mut self, name: &'static str, value: &mut f32, range: RangeInclusive<f32>) {
        self.edit.changed |= fields::quantity(self.ui, self.caption(name), value, 0.1, range, "°");
    }

    fn picture(&mut self, name: &'static str, value: &mut PathBuf) {
        if picture_row(self.ui, self.caption(name), value, self.textures()) {
            self.edit.wants_picture = Some((name, SquarePath::WHOLE));
        }
    }

    fn optional_texture(&mut self, name: &'static str, value: &mut Option<Texture>) {
        let mut parameter = match value {
            Some(texture) => Parameter::Texture(texture.clone()),
            None => Parameter::Constant(Rgb::ONE),
        };
        let before = self.edit.changed;
        self.slot(name, "none", &mut parameter, Rgb::ONE, |ui, caption, _| {
            fields::note(ui, caption, "none");
            false
        });
        if self.edit.changed && !before {
            *value = match parameter {
                Parameter::Texture(texture) => Some(texture),
                Parameter::Constant(_) => None,
            };
        }
    }

    fn cone(&mut self, cutoff_angle: &mut f32, beam_width: &mut f32) {
        let captions = ["cutoff_angle", "beam_width"].map(|name| self.caption(name));
        let mut angle = |caption, value: &mut f32, range| {
            fields::slider_with(self.ui, caption, value, range, |slider| slider.suffix("°"))
        };
        let mut changed = angle(captions[0], cutoff_angle, 0.1..=90.0);
        // A narrower cone has a narrower beam.
        if changed {
            *beam_width = beam_width.min(*cutoff_angle);
        }
        changed |= angle(captions[1], beam_width, 0.0..=*cutoff_angle);
        self.edit.changed |= changed;
    }

    fn field_of_view(&mut self, fov: &mut f32, axis: &mut FovAxis) {
        self.edit.changed |= field_of_view(self.ui, fov, axis);
    }

    fn sun_position(&mut self, value: &mut SunPosition) {
        let given = matches!(value, SunPosition::Direction(_));
        let mut wanted = given;
        let ways = [(false, "place and time"), (true, "direction")];
        if fields::choice(
            self.ui,
            self.caption("sun_direction").titled("Sun by"),
            &mut wanted,
            &ways,
        ) {
            *value = if wanted {
                SunPosition::Direction(Vec3::new(0.0, 1.0, 1.0))
            } else {
                SunPosition::PlaceAndTime(PlaceAndTime::default())
            };
            self.edit.changed = true;
        }
        if let SunPosition::Direction(direction) = value {
            self.edit.changed |= fields::vector(self.ui, self.caption("sun_direction"), direction, 0.01, "");
        }
    }

    fn sampling_weight(&mut self, value: &mut f32) {
        self.edit.changed |= fields::number(self.ui, self.caption("sampling_weight"), value, 0.01, 0.0..=f32::MAX);
    }
}
