//! The state that the list keeps between frames.

use bevy::prelude::Entity;
use bevy_egui::egui::Ui;

use super::lines::{Folding, Lines, leaf};
use crate::app::editor::command::selection::Extend;
use crate::app::editor::model::Item;

/// The state that the panel keeps between frames.
#[derive(Clone, Debug, Default)]
pub struct OutlinerState {
    /// The filter: only things whose names contain it are listed.
    pub filter: String,
    pub(super) folding: Folding,
    pub(super) lines: Lines,
    pub(super) renaming: Option<Renaming>,
    /// A thing whose name is asked for as soon as it is listed, and the time of the request in seconds of egui's clock.
    pub(super) asked: Option<(Entity, f64)>,
    /// The first line of a range.
    pub(super) anchor: Option<Entity>,
    /// The active thing when the list was last shown: another one is scrolled to.
    pub(super) shown_active: Option<Entity>,
    /// The materials whose lines were visible, so that they get pictures.
    pub materials_in_sight: Vec<Entity>,
}

impl OutlinerState {
    /// Opens the field for a new name of this thing as soon as it is listed, unless that is too late. `now` is in
    /// seconds of egui's clock.
    pub fn ask_for_name(&mut self, thing: Entity, now: f64) {
        self.asked = Some((thing, now));
    }
}

/// The change of the selection by a click, from the modifiers.
pub fn how(ui: &Ui) -> Extend {
    if ui.input(|input| input.modifiers.command) {
        Extend::Toggle
    } else {
        Extend::Replace
    }
}

/// A name that is being typed.
#[derive(Clone, Debug)]
pub(super) struct Renaming {
    pub entity: Entity,
    /// The last part of the name, as typed so far.
    pub text: String,
    /// Whether the field has not had the keyboard yet.
    pub is_new: bool,
}

impl Renaming {
    pub fn of(item: &Item) -> Self {
        // The name of a group's transform ends with a slash.
        Self::new(item.entity, leaf(item.name.trim_end_matches('/')))
    }

    pub fn new(entity: Entity, name: &str) -> Self {
        Self {
            entity,
            text: name.to_owned(),
            is_new: true,
        }
    }
}
