//! A small flat, as the panels show it.

use std::sync::Arc;

use bevy::prelude::Entity;
use bevy_egui::egui::Color32;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::model::panel_textures::{Ball, PanelTextures};
use sunroom::app::editor::model::{Item, Model, Outline};

pub fn entity(index: u32) -> Entity {
    Entity::from_raw_u32(index).expect("a small index is valid")
}

fn item(index: u32, name: &str, kind: &'static str) -> Item {
    Item {
        entity: entity(index),
        name: name.to_owned(),
        kind,
        hidden: false,
        locked: false,
        can_hide: true,
        inside_of: None,
        uses: None,
        properties: None,
    }
}

pub const OAK: u32 = 30;
pub const PLASTER: u32 = 31;
pub const BRASS: u32 = 32;

fn of(material: u32, item: Item) -> Item {
    Item {
        uses: Some(entity(material)),
        ..item
    }
}

fn outline() -> Outline {
    Outline {
        shapes: vec![
            of(OAK, item(1, "living room/floor", "cube")),
            of(PLASTER, item(2, "living room/wall with window", "wall")),
            of(PLASTER, item(3, "living room/wall with door", "wall")),
            of(OAK, item(4, "table/top", "cube")),
            of(OAK, item(5, "table/leg", "cylinder")),
            Item {
                hidden: true,
                ..of(PLASTER, item(6, "ceiling", "rectangle"))
            },
            Item {
                locked: true,
                ..of(OAK, item(7, "stairs to the attic", "stairs"))
            },
            of(BRASS, item(8, "bunny", "mesh")),
        ]
        .into(),
        materials: vec![
            item(OAK, "oak", "principled"),
            item(PLASTER, "plaster", "diffuse"),
            item(BRASS, "brass", "roughconductor"),
        ]
        .into(),
        media: vec![item(40, "morning fog", "medium")].into(),
        lights: vec![
            item(50, "sky", "sunsky"),
            item(51, "reading lamp", "spot"),
            item(52, "bulb", "point"),
        ]
        .into(),
        sensors: vec![item(60, "from the door", "camera"), item(61, "from above", "camera")].into(),
    }
}

/// The flat with the floor and a wall selected.
pub fn model() -> Model {
    let colors = [
        (OAK, Color32::from_rgb(150, 104, 62)),
        (PLASTER, Color32::from_rgb(226, 222, 212)),
        (BRASS, Color32::from_rgb(196, 160, 80)),
    ];
    Model {
        outline: Arc::new(outline()),
        selection: Selection::of([entity(2), entity(1)]),
        textures: PanelTextures {
            colors: colors
                .map(|(material, color)| (Ball::Material(entity(material)), color))
                .into(),
            ..PanelTextures::default()
        },
        ..Model::default()
    }
}
