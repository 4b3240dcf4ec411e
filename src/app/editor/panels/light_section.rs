//! The sections of the inspector about light: of a shape, and of a light that is no shape.

use std::path::PathBuf;

use bevy::prelude::Entity;
use bevy_egui::egui::Ui;

use super::inspector::others;
use super::key_marks::moving;
use super::lamps::lamps_menu;
use super::light_strength::StrengthUnits;
use super::material::Edit;
use super::polar_curve::polar_curve;
use super::{emission, fields};
use crate::app::editor::command::lamps::{PhotometricValue, strength_of};
use crate::app::editor::command::{Command, FileCommand, FileDialogKind, SceneEdit, ValueEdit};
use crate::app::editor::model::light_figures::LightFigures;
use crate::app::editor::model::{Inspected, Model};
use crate::color::luminance;
use crate::photometry::lamps::{LAMPS, Lamp};
use crate::scene::{Declared, Emitter, Parameter, ParameterRef};

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
    let shone = match (&inspected.area_light, &mut edited) {
        (Some(before), Some(after)) => shone(ui, before, after, inspected, model),
        _ => None,
    };
    if edit.changed || shone.is_some() {
        commands.push(shining(ValueEdit::SetAreaLight(inspected.entity, edited), shone));
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
    let figures = &inspected.light_figures;
    if let (Some([c0, _, c90, _]), Some(emitted)) = (figures.curves.as_deref(), figures.emitted) {
        polar_curve(ui, [c0, c90], emitted);
    }
    let shone = shone(ui, emitter, &mut edited, inspected, model);
    if edit.changed || shone.is_some() {
        commands.push(shining(ValueEdit::SetEmitter(inspected.entity, edited), shone));
    }
    choose_picture(inspected.entity, edit, commands);
    if emitter.is_sky() {
        environments(ui, &model.assets.environments, commands);
    }
}

/// A parameter of a light, and the value in photometric units that it was given.
type Shone = (&'static str, PhotometricValue);

/// Shows the menu of real lamps, which may change the light. Returns what it was given by the menu, or by its row in a
/// photometric unit where several lights are selected: the others get as much in that unit.
fn shone<L: Declared>(ui: &mut Ui, before: &L, after: &mut L, inspected: &Inspected, model: &Model) -> Option<Shone> {
    let figures = &inspected.light_figures;
    real_lamp(ui, after, figures).or_else(|| {
        let typed = typed_amount(ui, before, after, figures);
        typed.filter(|_| others(inspected, model) > 0)
    })
}

/// The command that gives the light its value.
fn shining(edit: ValueEdit, shone: Option<Shone>) -> Command {
    match shone {
        Some((parameter, value)) => ValueEdit::Shine(Box::new(edit), parameter, value).into(),
        None => edit.into(),
    }
}

/// Shows the menu of the real lamps that fit a light in photometric units, and gives it the chosen one's strength and
/// colour, which are returned.
fn real_lamp(ui: &mut Ui, light: &mut impl Declared, figures: &LightFigures) -> Option<Shone> {
    let fits = |lamp: &Lamp| strength_of(lamp, &figures.measures).is_some();
    if !LAMPS.iter().any(&fits) {
        return None;
    }
    let lamp = fields::buttons(ui, |ui| lamps_menu(ui, "As a real lamp", fits))?;
    PhotometricValue::apply_lamp(lamp, light, &figures.measures).ok()?;
    Some((strength_of(lamp, &figures.measures)?, lamp.into()))
}

/// The amount that was typed into the row of a photometric unit. A colour that was edited there leaves it as it is.
fn typed_amount(ui: &Ui, before: &impl Declared, after: &impl Declared, figures: &LightFigures) -> Option<Shone> {
    figures.measures.iter().find_map(|(parameter, _)| {
        let measure = StrengthUnits {
            radiometric: "",
            parameter,
            measures: &figures.measures,
        }
        .chosen(ui)?;
        let [before, after] = [strength(before, parameter)?, strength(after, parameter)?];
        let amount = Some((after * measure.per_strength, measure.unit));
        let is_edited = (after - before).abs() > 1e-5 * after.max(before);
        is_edited.then_some((*parameter, PhotometricValue { amount, color: None }))
    })
}

/// The luminance of a parameter of this name; None for one with a texture.
fn strength(light: &impl Declared, parameter: &str) -> Option<f32> {
    let mut found = None;
    light.visit(&mut |info, value| {
        if info.name == parameter {
            found = match value {
                ParameterRef::Emission(color) | ParameterRef::TexturedEmission(Parameter::Constant(color)) => {
                    Some(luminance(*color))
                }
                ParameterRef::Factor(factor) => Some(*factor),
                _ => None,
            };
        }
    });
    found
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
