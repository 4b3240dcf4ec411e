//! The verbs about files.

use std::path::Path;

use bevy::prelude::World;

use super::error::ScriptError;
use super::names::{named, parse_place};
use super::verb::verbs;
use crate::app::editor::command::asset_kind::FileUse;
use crate::app::editor::command::scene::Replacement;
use crate::app::editor::command::{FileCommand, SceneEdit};
use crate::document::paths::settle;
use crate::scene::write::OnChange;

verbs! {
    SCENES(world):
    "open" "FILE" [path] => FileCommand::OpenScene(path.into());
    "save-to" "FILE [merge|overwrite] (if it was changed elsewhere)"
        [path] => FileCommand::SaveScene(path.into()),
        [path, "merge"] => FileCommand::SaveChanged(path.into(), OnChange::TakeIn),
        [path, "overwrite"] => FileCommand::SaveChanged(path.into(), OnChange::Overwrite);
    "export-to" "FILE" [path] => FileCommand::ExportScene(path.into());
}

verbs! {
    VERBS(world):
    "save-image-to" "FILE" [path] => FileCommand::SaveImage(path.into());
    "import-file" "FILE" [path] => SceneEdit::Import(path.into());
    "replace" "NAME (of a shape)|FILE (what is selected)" [by] => replacement(world, by)?;
    "find-file" "MISSING FOUND" [missing, found] => found_file(missing, found);
    "use-file" "FILE [X,Y (0 to 1 from the upper left); else for the selection]"
        [path, at @ ..] if at.len() < 2 => use_file(path, at.first().copied())?;
    "paste" "XML (to the end of the line)" [xml] => SceneEdit::Paste((*xml).to_owned());
}

/// A shape of this name, or else a file.
fn replacement(world: &mut World, by: &str) -> Result<SceneEdit, ScriptError> {
    Ok(SceneEdit::Replace(match named(world, by) {
        Ok(shape) => Replacement::Shape(shape),
        Err(_) if Path::new(by).extension().is_some() => Replacement::File(settle(Path::new(by))),
        Err(error) => return Err(error),
    }))
}

fn found_file(missing: &str, found: &str) -> SceneEdit {
    SceneEdit::FindFile {
        missing: settle(Path::new(missing)),
        found: settle(Path::new(found)),
        others: true,
    }
}

fn use_file(path: &str, at: Option<&str>) -> Result<SceneEdit, ScriptError> {
    let at = at.map(parse_place).transpose()?;
    let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
    Ok(SceneEdit::UseFile(Box::new(FileUse { path, at, bounds: None })))
}
