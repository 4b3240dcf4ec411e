//! Edits that add entities to the scene and remove them.

use super::file_use::use_file;
use super::things::{delete, selected};
use super::{adding, blocking, copying, files, finding};
use crate::app::editor::command::SceneEdit;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::session::history::Edit;

/// Applies the edit.
pub fn edit(edit: &mut Edit, command: SceneEdit) -> Result<(), CommandError> {
    match command {
        SceneEdit::Import(path) => adding::import_chosen(edit, &path)?,
        SceneEdit::UseFile(file) => use_file(edit, &file)?,
        SceneEdit::FindFile { missing, found, others } => finding::find(edit, &missing, &found, others)?,
        SceneEdit::Paste(text) => adding::paste(edit, &text)?,
        SceneEdit::Add(addition) => adding::add(edit, addition)?,
        SceneEdit::Build(block) => blocking::build(edit, *block)?,
        SceneEdit::Reshape(entity, shape, pose, _) => blocking::reshape(edit, entity, shape, pose)?,
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
    for entity in selected(edit)? {
        delete(edit, entity);
    }
    edit.world.insert_resource(Selection::default());
    Ok(())
}
