//! The sections of the inspector about light: of a shape, and of a light that is no shape.

use std::path::PathBuf;

use bevy::prelude::Entity;
use bevy_egui::egui::Ui;

use super::key_marks::moving;
use super::lamps::lamps_menu;
use super::material::Edit;
use super::polar_curve::polar_curve;
use super::{emission, fields};
use crate::app::editor::command::lamps::{PhotometricValue, strength_of};
use crate::app::editor::command::{Command, FileCommand, FileDialogKind, SceneEdit, ValueEdit};
use crate::app::editor::model::light_figures::LightFigures;
use crate::app::editor::model::{Inspected, Model};
use crate::photometry::lamps::{LAMPS, Lamp};
use crate::scene::{Declared, Emitter};

/// Shows the light of a shape.
pub(super) fn emission_rows(ui: &mut Ui, inspected: &Inspected, model: &Model, commands: &mut Vec<Command>) {
    let mut edited = inspected.area_light.clone();
    let is_flat = inspected.shape.as_ref().is_some_and(|shape| shape.kind.is_flat());
    let edit = moving(ui, &model.timeline, (inspected.entity, "emitter."), |ui| {
        ui.push_id(inspected.entity, |ui| {
            emission::area_light(ui, &mut edited, is_flat, &inspected.light_figures, &model.textures)
        })
        .inner
    });
    let is_lamp = (edited.as_mut()).is_some_and(|light| real_lamp(ui, light, &inspected.light_figures));
    if edit.changed || is_lamp {
        commands.push(ValueEdit::SetAreaLight(inspected.entity, edited).into());
    }
    choose_picture(inspected.entity, edit, commands);
}

/// Shows a light that is no shape.
pub(super) fn light_rows(
    ui: &mut Ui,
    inspected: &Inspected,
    emitter: &Emitter,
    model: &Model,
    commands: &mut Vec<Command>,
) {
    let mut edited = emitter.clone();
    let edit = ui
        .push_id(inspected.entity, |ui| {
            emission::emitter(ui, &mut edited, &inspected.light_figures, &model.textures)
        })
        .inner;
    if let Some([c0, _, c90, _]) = inspected.light_figures.curves.as_deref() {
        polar_curve(ui, [c0, c90]);
    }
    let is_lamp = real_lamp(ui, &mut edited, &inspected.light_figures);
    if edit.changed || is_lamp {
        commands.push(ValueEdit::SetEmitter(inspected.entity, edited).into());
    }
    choose_picture(inspected.entity, edit, commands);
    if emitter.is_sky() {
        environments(ui, &model.assets.environments, commands);
    }
}

/// Shows the menu of the real lamps that fit a light in photometric units, and gives it the chosen one's strength and
/// colour. Returns true if edited.
fn real_lamp(ui: &mut Ui, light: &mut impl Declared, figures: &LightFigures) -> bool {
    let fits = |lamp: &Lamp| strength_of(lamp, &figures.measures).is_some();
    if !LAMPS.iter().any(&fits) {
        return false;
    }
    let Some(lamp) = fields::buttons(ui, |ui| lamps_menu(ui, "As a real lamp", fits)) else {
        return false;
    };
    PhotometricValue::apply_lamp(lamp, light, &figures.measures).is_ok()
}

/// Shows buttons for the environments that are shipped with the program.
fn environments(ui: &mut Ui, known: &[PathBuf], commands: &mut Vec<Command>) {
    if known.is_empty() {
        return;
    }
    ui.menu_button("Environments", |ui| {
        for path in known {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().replace('-', " ");
            if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                commands.push(SceneEdit::Import(path.clone()).into());
                ui.close();
            }
        }
    })
    .response
    .on_hover_text("Pictures of all directions that come with the program. The panel Assets shows them.");
}

/// Asks for the file of the picture that a row wants.
pub(super) fn choose_picture(owner: Entity, edit: Edit, commands: &mut Vec<Command>) {
    if let Some((parameter, place)) = edit.wants_picture {
        commands.push(
            FileCommand::ShowDialog(FileDialogKind::OpenPicture {
                owner,
                parameter,
                place,
            })
            .into(),
        );
    }
}
