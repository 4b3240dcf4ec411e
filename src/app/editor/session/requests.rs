//! What is to be done next: commands of this frame, and what the window is asked to show.

use bevy::prelude::Resource;

use super::save_question::SaveQuestion;
use crate::app::editor::command::panel::Panel;
use crate::app::editor::command::shell::Sheet;
use crate::app::editor::command::{Command, FileDialogKind};

/// What the user did this frame, in order; applied once per frame by `commands`.
#[derive(Resource, Default)]
pub struct CommandQueue(pub Vec<Command>);

/// What the window is asked to show or do.
#[derive(Resource, Default)]
pub struct Requests {
    /// A file to ask for.
    pub dialog: Option<FileDialogKind>,
    /// How to save a file that others changed.
    pub save_question: Option<SaveQuestion>,
    /// What lies over the window.
    pub sheet: Option<Sheet>,
    /// To be brought to the front of its group, unless it is closed.
    pub wanted_panel: Option<Panel>,
    /// A text on its way to the system's clipboard.
    pub clipboard: Option<String>,
    /// The user wants to close the window.
    pub closes: bool,
    /// Counts drags, typings and clicks: edits of one kind within one of them are one step of the history.
    pub interaction: u64,
}
