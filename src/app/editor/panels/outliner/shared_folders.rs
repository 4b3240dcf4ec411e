//! The folders that hold shapes together with lights or cameras, so that the list shows each folder once.

use std::collections::HashSet;

use bevy::prelude::Entity;

use crate::app::editor::model::item_list::ItemList;
use crate::app::editor::model::{Item, Outline};

/// The index of a heading's list in [`Outline::groups`], and of an item in the list.
pub type Place = (usize, usize);

/// The lights and cameras that are in folders of shapes.
#[derive(Default)]
pub struct SharedFolders {
    /// Things that are listed in the folder, in the order of their lists.
    pub others: Vec<Place>,
    /// The lights that are shapes, which are listed in the folder already.
    pub repeated: HashSet<Place>,
}

impl SharedFolders {
    /// Finds them in an outline.
    pub fn of(outline: &Outline) -> Self {
        let mut shared = Self::default();
        let has_folders = |items: &ItemList| !items.is_flat();
        if !has_folders(&outline.shapes) || ![&outline.lights, &outline.sensors].into_iter().any(has_folders) {
            return shared;
        }
        let folders: HashSet<&str> = outline.shapes.iter().filter_map(outermost).collect();
        let shapes: HashSet<Entity> = outline.shapes.iter().map(|item| item.entity).collect();
        for (group, (_, items)) in outline.groups().into_iter().enumerate() {
            if ![Outline::LIGHTS, Outline::CAMERAS].contains(&outline.groups()[group].0) {
                continue;
            }
            for (index, item) in items.iter().enumerate() {
                if !outermost(item).is_some_and(|folder| folders.contains(folder)) {
                    continue;
                }
                match shapes.contains(&item.entity) {
                    true => _ = shared.repeated.insert((group, index)),
                    false => shared.others.push((group, index)),
                }
            }
        }
        shared
    }
}

/// The outermost folder that a thing is in.
fn outermost(item: &Item) -> Option<&str> {
    item.name
        .trim_start_matches('/')
        .split_once('/')
        .map(|(folder, _)| folder)
}
