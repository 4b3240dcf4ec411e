//! Light: of a shape, a point, a direction, or all around.

use bevy_egui::egui::Ui;

use super::fields;
use crate::color::Rgb;
use crate::scene::{AreaLight, Emitter};

/// True if edited. The check box makes a shape emit, or not.
pub fn area_light(ui: &mut Ui, light: &mut Option<AreaLight>) -> bool {
    let mut emits = light.is_some();
    if fields::checkbox(ui, "Emits light", &mut emits) {
        *light = emits.then_some(AreaLight { radiance: Rgb::ONE });
        return true;
    }
    light
        .as_mut()
        .is_some_and(|light| fields::emission(ui, " W/m²sr", &mut light.radiance))
}

/// True if edited.
pub fn emitter(ui: &mut Ui, emitter: &mut Emitter) -> bool {
    match emitter {
        Emitter::Point { intensity } => {
            fields::note(ui, "Type", "point");
            fields::emission(ui, " W/sr", intensity)
        }
        Emitter::Directional { irradiance } => {
            fields::note(ui, "Type", "directional");
            fields::emission(ui, " W/m²", irradiance)
        }
        Emitter::Constant { radiance } => {
            fields::note(ui, "Type", "constant environment");
            fields::emission(ui, " W/m²sr", radiance)
        }
    }
}

/// The name of the kind, for lists.
pub fn kind_name(emitter: &Emitter) -> &'static str {
    match emitter {
        Emitter::Point { .. } => "point",
        Emitter::Directional { .. } => "directional",
        Emitter::Constant { .. } => "constant",
    }
}
