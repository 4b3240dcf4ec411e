//! Shows the parameters of light: of a shape, or of a light that is no shape.

use std::path::Path;

use bevy::math::Vec3;
use bevy_egui::egui::{Label, RichText, Ui};

use super::caption::Caption;
use super::light_strength::StrengthUnits;
use super::material::{Edit, Rows, TYPE};
use super::texture_slot::{BESIDE, picture_row};
use super::{color_field, fields};
use crate::app::editor::command::conversion::emitter_turned_into;
use crate::app::editor::model::light_figures::LightFigures;
use crate::app::editor::model::panel_textures::PanelTextures;
use crate::color::Rgb;
use crate::scene::parameters::{BEAM_WIDTH, CUTOFF_ANGLE};
use crate::scene::{
    AreaLight, Cone, Declared, Emitter, EmitterKind, FLUX, Parameter, ParameterInfo, PlaceAndTime, SquarePath,
    SunPosition, Texture,
};

/// Shows the check box that makes a shape emit, and its rows. `is_flat`: the shape has two visible sides.
pub fn area_light(
    ui: &mut Ui,
    light: &mut Option<AreaLight>,
    is_flat: bool,
    figures: &LightFigures,
    textures: &PanelTextures,
) -> Edit {
    let mut emits = light.is_some();
    let toggled = fields::checkbox(ui, ("Emits light", "area_light"), &mut emits);
    if toggled {
        *light = emits.then(AreaLight::default);
    }
    if is_flat && light.as_ref().is_some_and(|light| !light.two_sided) {
        let text =
            "It shines on the side of its normals only, and is black from the other. Flip normals turns it round.";
        ui.add(Label::new(RichText::new(text).weak()).wrap());
    }
    let mut rows = Rows {
        figures,
        ..Rows::new(ui, textures)
    };
    if let Some(light) = light {
        light.visit_mut(&mut |info, value| rows.parameter(info, value));
    }
    Edit {
        changed: rows.edit.changed || toggled,
        ..rows.edit
    }
}

/// Shows the rows of a light that is no shape. The first row chooses its kind.
pub fn emitter(ui: &mut Ui, emitter: &mut Emitter, figures: &LightFigures, textures: &PanelTextures) -> Edit {
    let plugin = emitter.plugin();
    let mut wanted = plugin;
    let options: Vec<_> = EmitterKind::DECLARED
        .iter()
        // A marker is no light, and no light is a marker.
        .filter(|other| Emitter::usual(other.name).is_some_and(|other| other.is_marker() == emitter.is_marker()))
        .map(|plugin| (plugin.name, plugin.label))
        .collect();
    if fields::choice(ui, TYPE, &mut wanted, &options) {
        *emitter = emitter_turned_into(emitter, wanted);
        // An environment needs a picture, and a lamp the file of its intensities.
        let wants_picture = matches!(wanted, "envmap" | "ies").then_some(("filename", SquarePath::WHOLE));
        return Edit {
            changed: true,
            wants_picture,
        };
    }
    let mut rows = Rows {
        figures,
        ..Rows::new(ui, textures)
    };
    emitter.visit_mut(&mut |info, value| rows.parameter(info, value));
    rows.edit
}

impl Rows<'_> {
    pub(super) fn textured_emission(&mut self, info: &'static ParameterInfo, value: &mut Parameter<Rgb>) {
        let units = self.units(info);
        self.texturable(info, "colour", value, Rgb::ONE, |ui, caption, color| {
            color_field::emission(ui, caption, units, BESIDE, color)
        });
    }

    /// Shows the flux of a lamp with measured intensities. Where it is left to the file, that of the file is shown.
    /// The row is left out where the strength is shown in photometric units already.
    pub(super) fn flux(&mut self, flux: &mut f32) {
        let of_scale = StrengthUnits {
            radiometric: "",
            parameter: "scale",
            measures: &self.figures.measures,
        };
        if of_scale.chosen(self.ui).is_some() {
            return;
        }
        let own = self.figures.own_flux.filter(|_| *flux == 0.0);
        let mut shown = own.unwrap_or(*flux);
        let unit = if own.is_some() { " lm of the file" } else { " lm" };
        let speed = 0.01 * shown.max(1.0);
        if fields::quantity(self.ui, &FLUX, &mut shown, speed, FLUX.range.clone(), unit) {
            *flux = shown;
            self.edit.changed = true;
        }
    }

    pub(super) fn picture(&mut self, info: &'static ParameterInfo, value: &Path) {
        if picture_row(self.ui, info.into(), value, self.textures) {
            self.edit.wants_picture = Some((info.name, SquarePath::WHOLE));
        }
    }

    pub(super) fn optional_texture(&mut self, info: &'static ParameterInfo, value: &mut Option<Texture>) {
        let mut parameter = match value {
            Some(texture) => Parameter::Texture(texture.clone()),
            None => Parameter::Constant(Rgb::ONE),
        };
        let before = self.edit.changed;
        self.texturable(info, "none", &mut parameter, Rgb::ONE, |ui, caption, _| {
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

    pub(super) fn cone(&mut self, cone: &mut Cone) {
        let mut angle =
            |info: &'static ParameterInfo, value: &mut f32, range| fields::angle_slider(self.ui, info, value, range);
        let mut changed = angle(&CUTOFF_ANGLE, &mut cone.cutoff_angle, CUTOFF_ANGLE.slider_range());
        // A narrower cone has a narrower beam.
        if changed {
            cone.beam_width = cone.beam_width.min(cone.cutoff_angle);
        }
        changed |= angle(&BEAM_WIDTH, &mut cone.beam_width, 0.0..=cone.cutoff_angle);
        self.edit.changed |= changed;
    }

    pub(super) fn sun_position(&mut self, info: &'static ParameterInfo, value: &mut SunPosition) {
        let mut is_given = matches!(value, SunPosition::Direction(_));
        let ways = [(false, "place and time"), (true, "direction")];
        if fields::choice(self.ui, Caption::from(info).titled("Sun by"), &mut is_given, &ways) {
            *value = if is_given {
                SunPosition::Direction(Vec3::new(0.0, 1.0, 1.0))
            } else {
                SunPosition::PlaceAndTime(PlaceAndTime::default())
            };
            self.edit.changed = true;
        }
        match value {
            SunPosition::Direction(direction) => {
                self.edit.changed |= fields::vector(self.ui, info, direction, 0.01, "");
            }
            SunPosition::PlaceAndTime(at) => at.visit_mut(&mut |info, value| self.parameter(info, value)),
        }
    }
}
