//! Drives the editor's panels without a window: what the user does comes out as commands, and showing a panel changes
//! nothing. One module for each panel; here is what moves the mouse.

mod angles;
mod assets;
mod inspector;
mod keys;
mod lengths;
mod light_painting;
mod light_units;
mod lights;
mod materials;
mod media;
mod menus;
mod outliner;
mod picture;
mod reasons;
mod render;
mod subjects;
mod timeline;

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Pos2, Ui};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::Command;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::model::{Item, Model, Outline};
use sunroom::app::editor::viewport::material_drop::{Takers, drop_target};
use sunroom::color::Rgb;
use sunroom::scene::AreaLight;

fn entity(index: u32) -> Entity {
    Entity::from_raw_u32(index).expect("a small index is valid")
}

/// What a panel is given, and what came of it.
struct Shown<T> {
    given: T,
    commands: Vec<Command>,
}

type Panel<T> = fn(&mut Ui, &T, &mut Vec<Command>);

fn show<T: 'static>(given: T, panel: Panel<T>) -> Harness<'static, Shown<T>> {
    show_at(340.0, given, panel)
}

fn show_at<T: 'static>(width: f32, given: T, panel: Panel<T>) -> Harness<'static, Shown<T>> {
    let shown = Shown {
        given,
        commands: Vec::new(),
    };
    let mut harness = Harness::builder().with_size(egui::vec2(width, 1000.0)).build_ui_state(
        move |ui, shown: &mut Shown<T>| panel(ui, &shown.given, &mut shown.commands),
        shown,
    );
    harness.run_steps(3);
    harness
}

/// A panel of `width` points beside a picture that takes materials which are dragged onto it.
fn show_beside_picture(
    size: egui::Vec2,
    width: f32,
    model: Model,
    mut panel: impl FnMut(&mut Ui, &Model, &mut Vec<Command>) + 'static,
) -> Harness<'static, Shown<Model>> {
    let shown = Shown {
        given: model,
        commands: Vec::new(),
    };
    let mut harness = Harness::builder().with_size(size).build_ui_state(
        move |ui, shown: &mut Shown<Model>| {
            let Shown { given, commands } = shown;
            egui::Panel::left("panel")
                .exact_size(width)
                .show(ui, |ui| panel(ui, given, commands));
            let picture = ui.available_rect_before_wrap();
            let response = ui.interact(picture, egui::Id::new("picture"), egui::Sense::click_and_drag());
            let takers = Takers {
                packed: &Default::default(),
                things: &given.outline,
                locked: &Default::default(),
            };
            drop_target(ui, &response, picture, takers, commands);
        },
        shown,
    );
    harness.run_steps(3);
    harness
}

/// Drags the slider of this name to a fraction of its length.
fn slide<T>(harness: &mut Harness<Shown<T>>, name: &str, fraction: f32) {
    let rect = harness.get_by_label(name).rect();
    press_at(
        harness,
        Pos2::new(rect.left() + fraction * rect.width(), rect.center().y),
    );
}

fn press_at<T>(harness: &mut Harness<T>, position: Pos2) {
    harness.hover_at(position);
    harness.run_steps(1);
    harness.drag_at(position);
    harness.run_steps(1);
    harness.drop_at(position);
    harness.run_steps(2);
}

fn click<T>(harness: &mut Harness<T>, name: &str) {
    harness.get_by_label(name).click();
    harness.run_steps(4);
}

/// Drags a number by some points to the right.
fn drag<T>(harness: &mut Harness<T>, name: &str, points: f32) {
    let start = harness.get_by_label(name).rect().center();
    harness.hover_at(start);
    harness.run_steps(1);
    harness.drag_at(start);
    harness.run_steps(1);
    for step in 1..=4 {
        harness.hover_at(start + egui::vec2(points * step as f32 / 4.0, 0.0));
        harness.run_steps(1);
    }
    harness.drop_at(start + egui::vec2(points, 0.0));
    harness.run_steps(2);
}

fn item(index: u32, name: &str) -> Item {
    Item {
        entity: entity(index),
        name: name.to_owned(),
        kind: "diffuse",
        hidden: false,
        locked: false,
        can_hide: true,
        inside_of: None,
        uses: None,
        properties: None,
    }
}

fn light(radiance: Rgb) -> AreaLight {
    AreaLight {
        radiance: radiance.into(),
        ..AreaLight::default()
    }
}

fn with_outline(outline: Outline, selection: Selection) -> Model {
    Model {
        outline: outline.into(),
        selection,
        ..Model::default()
    }
}

fn drag_between<T>(harness: &mut Harness<T>, from: Pos2, to: Pos2) {
    harness.hover_at(from);
    harness.run_steps(2);
    harness.drag_at(from);
    harness.run_steps(2);
    for part in 1..=4 {
        harness.hover_at(from + (to - from) * (part as f32 / 4.0));
        harness.run_steps(1);
    }
    harness.drop_at(to);
    harness.run_steps(3);
}

fn press_and_move_in_one_frame<T>(harness: &mut Harness<T>, from: Pos2, to: Pos2) {
    harness.input_mut().events.extend([
        egui::Event::PointerMoved(from),
        egui::Event::PointerButton {
            pos: from,
            button: egui::PointerButton::Primary,
            pressed: true,
            modifiers: egui::Modifiers::NONE,
        },
        egui::Event::PointerMoved(to),
    ]);
    harness.run_steps(1);
}
