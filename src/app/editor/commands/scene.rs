//! Edits that add entities to the scene and remove them.

use bevy::prelude::*;

use super::file_use::use_file;
use super::things::{delete, selected};
use super::{adding, blocking, copying, files, finding, importing, replacing, roofing};
use crate::app::editor::command::SceneEdit;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::toasts::Toasts;
use crate::scene::listed::listed;
use crate::scene::{MaterialUsers, ObjectState};

/// Applies the edit.
pub fn edit(edit: &mut Edit, command: SceneEdit) -> Result<(), CommandError> {
    match command {
        SceneEdit::Import(path) => importing::import_chosen(edit, &path)?,
        SceneEdit::UseFile(file) => use_file(edit, &file)?,
        SceneEdit::FindFile { missing, found, others } => finding::find(edit, &missing, &found, others)?,
        SceneEdit::Paste(text) => importing::paste(edit, &text)?,
        SceneEdit::Add(addition) => adding::add(edit, addition)?,
        SceneEdit::Build(block) => blocking::build(edit, *block)?,
        SceneEdit::Cover(plugin) => roofing::cover(edit, plugin)?,
        SceneEdit::Reshape(entity, shape, pose, _) => blocking::reshape(edit, entity, shape, pose)?,
        SceneEdit::Replace(by) => replacing::replace(edit, &by)?,
        SceneEdit::Delete => delete_selection(edit)?,
        SceneEdit::Cut => {
            files::copy(edit.world)?;
            delete_selection(edit)?;
        }
        SceneEdit::Duplicate => copying::duplicate(edit)?,
        SceneEdit::MakeSeries(series) => copying::series(edit, &series)?,
    }
    Ok(())
}

fn delete_selection(edit: &mut Edit) -> Result<(), CommandError> {
    let gone = selected(edit)?;
    let users: Vec<Entity> = gone
        .iter()
        .flat_map(|material| edit.world.get::<MaterialUsers>(*material))
        .flat_map(|users| users.iter())
        .collect();
    for entity in gone {
        delete(edit, entity);
    }
    edit.world.insert_resource(Selection::default());
    // Their look changes although they were not selected.
    let bare = users
        .iter()
        .filter(|user| ObjectState::is_in_scene(edit.world, **user))
        .filter_map(|user| Some(edit.world.get::<Name>(*user)?.to_string()));
    let bare: Vec<String> = bare.collect();
    if !bare.is_empty() {
        let has = if bare.len() == 1 { "has" } else { "have" };
        let message = format!("{} {has} no material now", listed(&bare, MOST_NAMED));
        edit.world.get_resource_or_init::<Toasts>().info(message);
    }
    Ok(())
}

/// The most shapes that the message about a deleted material names.
const MOST_NAMED: usize = 3;
