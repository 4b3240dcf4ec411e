//! The names that the program gives to materials: ids of new ones, and names after presets.

use bevy::prelude::*;

use super::materials::preset_tree;
use super::things::call;
use crate::app::editor::command::material_tree::MaterialTree;
use crate::app::editor::model::EditorModel;
use crate::app::editor::session::history::Edit;
use crate::scene::SceneId;
use crate::scene::names::{free_name_for, is_taken};

/// Gives a new material its name as id, so that shapes can refer to it in the file.
pub(super) fn name_as_id(edit: &mut Edit, material: Entity, otherwise: &str) {
    let name = edit.world.get::<Name>(material);
    let name = name.map_or_else(|| otherwise.to_owned(), |name| name.as_str().to_owned());
    edit.set(material, SceneId(name));
}

/// Names a material after the preset that it was replaced by, unless the user typed its name.
pub(super) fn name_after_preset(edit: &mut Edit, material: Entity, tree: &MaterialTree) {
    let Some(presets) = edit
        .world
        .get_resource::<EditorModel>()
        .map(|model| model.0.presets.clone())
    else {
        return;
    };
    let Some(id) = edit.world.get::<SceneId>(material).map(|id| id.0.clone()) else {
        return;
    };
    let Some(wanted) = presets
        .iter()
        .find(|preset| preset_tree(edit.world, preset) == *tree)
        .map(|preset| preset.id())
    else {
        return;
    };
    let stem = without_number(&id);
    let is_of_program = stem == "material" || presets.iter().any(|preset| preset.id() == stem);
    let is_copy = stem != id && is_taken(edit.world, stem);
    if stem != wanted && (is_of_program || is_copy) {
        let name = free_name_for(edit.world, &wanted);
        call(edit, material, &name);
    }
}

/// A name without the number that was added because another entity had it.
fn without_number(name: &str) -> &str {
    match name.rsplit_once('-') {
        Some((stem, number)) if number.parse::<u32>().is_ok() => stem,
        _ => name,
    }
}
