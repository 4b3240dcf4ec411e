//! Walks through the history.

use bevy::prelude::*;

use crate::app::editor::command::HistoryCommand;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::session::history::{self, History};

/// Applies the command.
pub fn apply(world: &mut World, command: HistoryCommand) -> Result<(), CommandError> {
    match command {
        HistoryCommand::Undo => history::undo(world)?,
        HistoryCommand::Redo => history::redo(world)?,
        HistoryCommand::GoTo(steps) => {
            while world.resource::<History>().len().0 > steps && history::undo(world).is_ok() {}
            while world.resource::<History>().len().0 < steps && history::redo(world).is_ok() {}
        }
    }
    Ok(())
}
