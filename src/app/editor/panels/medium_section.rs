//! The media of the selection: the references to media, and their parameters.

use std::collections::HashMap;

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Ui};

use super::key_marks::moving;
use super::{fields, medium};
use crate::app::editor::command::media::{Filling, MediumSide};
use crate::app::editor::command::{Command, MediumEdit, SettingsEdit, ValueEdit};
use crate::app::editor::model::{Inspected, InspectedMedium, Item, Model};
use crate::scene::{Medium, PathPlugin};

/// Copies of the shown media, for their rows to edit. Only a changed one is copied again.
#[derive(Debug, Default)]
pub(super) struct EditedMedia(HashMap<Entity, Medium>);

impl EditedMedia {
    /// The copy, which is equal to `shown`.
    fn of(&mut self, entry: &InspectedMedium) -> &mut Medium {
        let copy = self.0.entry(entry.entity).or_insert_with(|| (*entry.medium).clone());
        if *copy != *entry.medium {
            copy.clone_from(&entry.medium);
        }
        copy
    }
}

/// The choice in a row.
#[derive(Clone, Copy, PartialEq)]
enum Chosen {
    Nothing,
    Medium(Entity),
    New,
}

/// Whether the section has anything to show.
pub(super) fn has_media(inspected: &Inspected) -> bool {
    !inspected.media.is_empty() || MediumSide::ALL.into_iter().any(|side| inspected.has_side(side))
}

/// Shows the rows.
pub(super) fn medium_rows(
    ui: &mut Ui,
    inspected: &Inspected,
    model: &Model,
    copies: &mut EditedMedia,
    commands: &mut Vec<Command>,
) {
    for side in MediumSide::ALL {
        if inspected.has_side(side) {
            choice(ui, inspected, model, side, commands);
        }
    }
    if inspected.has_side(MediumSide::Interior) && inspected.media_at[MediumSide::Interior as usize].is_none() {
        let button = fields::buttons(ui, |ui| {
            ui.menu_button("Fill with", |ui| {
                fill_menu(ui, &meant(inspected, model, MediumSide::Interior), model, commands);
            })
        });
        button
            .response
            .on_hover_text("A medium inside, and a surface that lets light in to it");
    }
    if let Some(leak) = &inspected.leak {
        let text = format!("Not closed: {leak} Light that passes there does not know where the medium ends.");
        let text = egui::RichText::new(text).small().color(ui.visuals().warn_fg_color);
        ui.add(egui::Label::new(text).wrap());
    }
    if !inspected.media.is_empty() && !model.render.integrator.plugin.traces_media() {
        let plugin = model.render.integrator.plugin.name();
        let text = format!("The integrator `{plugin}` renders no media.");
        let text = egui::RichText::new(text).small().color(ui.visuals().warn_fg_color);
        ui.add(egui::Label::new(text).wrap());
        if fields::buttons(ui, |ui| ui.button("Use volpath")).clicked() {
            let mut integrator = model.render.integrator;
            integrator.plugin = PathPlugin::VolPath;
            commands.push(SettingsEdit::SetIntegrator(integrator).into());
        }
    }
    copies
        .0
        .retain(|entity, _| inspected.media.iter().any(|entry| entry.entity == *entity));
    for entry in &inspected.media {
        ui.push_id(entry.entity, |ui| {
            header(ui, entry, inspected);
            let edited = copies.of(entry);
            let changed = fields::compared(ui, &entry.mixed, |ui| {
                moving(ui, &model.timeline, (entry.entity, ""), |ui| {
                    medium::medium(ui, edited, entry, &model.textures)
                })
            });
            if changed {
                commands.push(ValueEdit::SetMedium(entry.entity, Box::new(edited.clone())).into());
            }
        });
    }
}

/// Shows the name of a medium, and its number of users.
fn header(ui: &mut Ui, entry: &InspectedMedium, inspected: &Inspected) {
    if inspected.media.len() > 1 || entry.side.is_some() {
        ui.add_space(4.0);
        let place = match entry.side {
            Some(side) if inspected.media.len() > 1 => format!("{}: {}", side.label(), entry.name),
            _ => entry.name.clone(),
        };
        ui.add(egui::Label::new(egui::RichText::new(place).italics()).truncate());
    }
    match entry.users {
        0 => ui.weak("nothing uses it"),
        1 if entry.side.is_some() => return,
        1 => ui.weak("in 1 thing"),
        users => ui.weak(format!("in {users} things")),
    };
}

/// Shows the row of the medium on one side.
fn choice(ui: &mut Ui, inspected: &Inspected, model: &Model, side: MediumSide, commands: &mut Vec<Command>) {
    let now = inspected.media_at[side as usize].map_or(Chosen::Nothing, Chosen::Medium);
    let mut chosen = now;
    let media = model.outline.media.iter();
    let mut options: Vec<(Chosen, &str)> = vec![(Chosen::Nothing, "none")];
    options.extend(media.map(|item| (Chosen::Medium(item.entity), item.name.as_str())));
    options.push((Chosen::New, "new medium"));
    if !fields::choice(ui, (side.label(), side.name()), &mut chosen, &options) {
        return;
    }
    let things = meant(inspected, model, side);
    commands.push(match chosen {
        Chosen::New => Command::from(MediumEdit::GiveMedium {
            thing: inspected.entity,
            side,
        }),
        Chosen::Nothing => Command::from(MediumEdit::UseMedium {
            things,
            side,
            medium: None,
        }),
        Chosen::Medium(medium) => Command::from(MediumEdit::UseMedium {
            things,
            side,
            medium: Some(medium),
        }),
    });
}

/// The inspected thing, or all selected things that may have a medium on this side.
fn meant(inspected: &Inspected, model: &Model, side: MediumSide) -> Vec<Entity> {
    let outline = &model.outline;
    let lists: &[&[Item]] = match side {
        MediumSide::Interior | MediumSide::Exterior => &[&outline.shapes],
        MediumSide::Around => &[&outline.sensors, &outline.lights],
    };
    let mut meant: Vec<Entity> = lists
        .iter()
        .flat_map(|list| list.iter())
        .filter(|item| item.kind != "group" && item.kind != "area" && model.selection.contains(item.entity))
        .map(|item| item.entity)
        .collect();
    if !meant.contains(&inspected.entity) {
        meant = vec![inspected.entity];
    }
    meant
}

/// Shows the menu of fillings for closed shapes.
pub(super) fn fill_menu(ui: &mut Ui, shapes: &[Entity], model: &Model, commands: &mut Vec<Command>) {
    let mut entry = |ui: &mut Ui, name: &str, with: Filling| {
        if ui.button(name).clicked() {
            let shapes = shapes.to_vec();
            commands.push(MediumEdit::Fill { shapes, with }.into());
            ui.close();
        }
    };
    entry(ui, "Fog", Filling::Fog);
    entry(ui, "Smoke", Filling::Smoke);
    if model.outline.media.is_empty() {
        return;
    }
    ui.separator();
    for item in &model.outline.media {
        entry(ui, &item.name, Filling::Medium(item.entity));
    }
}
