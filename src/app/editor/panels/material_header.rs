//! Shows the header of a material: a ball of it, its name, the library, and materials that may wrap it.

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Ui};

use crate::app::editor::command::material_tree::{Inside, MaterialTree, can_wrap, wrappers};
use crate::app::editor::command::{Command, MaterialEdit};
use crate::app::editor::model::panel_textures::Ball;
use crate::app::editor::model::{InspectedMaterial, MaterialPlace, Model};
use crate::scene::Material;

/// The edge of the ball in points for the outermost material, and below for nested ones.
const LARGE: f32 = 80.0;
const SMALL: f32 = 46.0;

/// Shows the name of a material, its number of users, and actions on the whole material.
pub(crate) fn material_header(ui: &mut Ui, entry: &InspectedMaterial, model: &Model, commands: &mut Vec<Command>) {
    let edge = match entry.place {
        MaterialPlace::Whole => LARGE,
        _ => SMALL,
    };
    ui.add_space(4.0);
    ui.horizontal_top(|ui| {
        let (rect, _) = ui.allocate_exact_size(egui::Vec2::splat(edge), egui::Sense::hover());
        model.textures.paint_ball(ui, Ball::Material(entry.entity), rect);
        ui.vertical(|ui| {
            let title = egui::RichText::new(title(entry)).italics();
            ui.add(egui::Label::new(title).truncate());
            if entry.place == MaterialPlace::Whole && entry.users > 1 {
                ui.weak(format!("on {} shapes", entry.users));
            }
            ui.horizontal(|ui| {
                presets(ui, entry.entity, entry.place, model, commands);
                ui.menu_button("Layers", |ui| layers(ui, entry, model, commands))
                    .response
                    .on_hover_text("The materials around this one, or inside it");
            });
        });
    });
}

fn title(entry: &InspectedMaterial) -> String {
    let name = &entry.name;
    match entry.place {
        MaterialPlace::Whole => name.clone(),
        MaterialPlace::Front => format!("Front: {name}"),
        MaterialPlace::Back => format!("Back: {name}"),
        MaterialPlace::First => format!("First: {name}"),
        MaterialPlace::Second => format!("Second: {name}"),
        MaterialPlace::Inside => format!("Inside: {name}"),
    }
}

/// Shows the materials of the library that `place` takes. The chosen one is applied to the material or the shape; if
/// that is the outermost, to the whole selection.
pub fn presets(ui: &mut Ui, target: Entity, place: MaterialPlace, model: &Model, commands: &mut Vec<Command>) {
    ui.menu_button("Presets", |ui| preset_menu(ui, target, place, model, commands))
        .response
        .on_hover_text("Materials of the library");
}

fn preset_menu(ui: &mut Ui, target: Entity, place: MaterialPlace, model: &Model, commands: &mut Vec<Command>) {
    let offered = || model.presets.iter().filter(|preset| place.takes(&preset.tree.material));
    let mut groups: Vec<&str> = Vec::new();
    for preset in offered() {
        if !groups.contains(&preset.group.as_str()) {
            groups.push(&preset.group);
        }
    }
    for group in groups {
        ui.menu_button(group, |ui| {
            for preset in offered().filter(|preset| preset.group == group) {
                if ui.button(&preset.name).clicked() {
                    commands.push(
                        MaterialEdit::BuildMaterial {
                            targets: targets(target, place == MaterialPlace::Whole, model),
                            tree: Box::new(preset.tree_in(model.unit, model.up)),
                        }
                        .into(),
                    );
                }
            }
        });
    }
}

fn targets(target: Entity, whole: bool, model: &Model) -> Vec<Entity> {
    let selected = model.selection.entities();
    if whole && selected.len() > 1 {
        selected.to_vec()
    } else {
        vec![target]
    }
}

/// Shows the menu of materials that may wrap this one, and of its nested ones.
pub(super) fn layers(ui: &mut Ui, entry: &InspectedMaterial, model: &Model, commands: &mut Vec<Command>) {
    let mut become_tree = |tree: MaterialTree| {
        commands.push(
            MaterialEdit::BuildMaterial {
                targets: vec![entry.entity],
                tree: Box::new(tree),
            }
            .into(),
        );
    };
    let own = || MaterialTree::of(&entry.material, &entry.inside);
    ui.menu_button("Put it into", |ui| {
        for wrapper in wrappers() {
            let allowed = can_wrap(wrapper.name, &entry.material);
            let button = egui::Button::new(wrapper.label);
            if ui.add_enabled(allowed, button).clicked() {
                become_tree(own().wrapped(wrapper.name));
            }
        }
    });
    let all = model.inspected.iter().flat_map(|inspected| &inspected.materials);
    let inside: Vec<&InspectedMaterial> = entry
        .inside
        .iter()
        .filter_map(|inner| all.clone().find(|known| known.entity == *inner))
        .collect();
    let kind = entry.material.info().label;
    for inner in &inside {
        let text = match inside.len() {
            1 => format!("Take the {kind} off"),
            _ => format!("Keep only \u{201c}{}\u{201d}", inner.name),
        };
        if ui.button(text).clicked() {
            become_tree(MaterialTree::of(&inner.material, &inner.inside));
        }
    }
    type Change = fn(&mut Vec<Inside>);
    let (offer, change): (&str, Change) = match (&*entry.material, entry.inside.len()) {
        (Material::TwoSided, 1) => ("Give the back its own", |inside| {
            inside.push(MaterialTree::from(Material::default()).into());
        }),
        (Material::TwoSided, 2) => ("Same on both sides", |inside| inside.truncate(1)),
        (Material::Blend { .. }, 2) => ("Exchange the two", |inside| inside.swap(0, 1)),
        _ => return,
    };
    if ui.button(offer).clicked() {
        let mut changed = own();
        change(&mut changed.inside);
        become_tree(changed);
    }
}
