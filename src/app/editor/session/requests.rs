//! Requests for the next step: the commands of this frame, and the dialogs of the window.

use bevy::prelude::{Entity, Resource};

use super::full_film_question::FullFilmQuestion;
use super::save_question::SaveQuestion;
use crate::app::editor::command::asset_kind::FileUse;
use crate::app::editor::command::panel::Panel;
use crate::app::editor::command::shell::{Sheet, SoughtFile};
use crate::app::editor::command::{Command, FileDialogKind};

/// The commands of this frame, in order; `commands` applies them once per frame.
#[derive(Resource, Default)]
pub struct CommandQueue(pub Vec<Command>);

/// Requests to the window.
#[derive(Resource, Default)]
pub struct Requests {
    /// The file dialog to open.
    pub dialog: Option<FileDialogKind>,
    /// The missing file that the dialog replaces.
    pub sought: Option<SoughtFile>,
    /// The question how to save a file that others have changed.
    pub save_question: Option<SaveQuestion>,
    /// The question whether to trace a large film in full.
    pub full_film_question: Option<FullFilmQuestion>,
    /// A scene file, with the question whether to add or open it.
    pub scene_question: Option<FileUse>,
    /// The sheet that covers the window.
    pub sheet: Option<Sheet>,
    /// A panel to bring to the front of its group, unless it is closed.
    pub wanted_panel: Option<Panel>,
    /// A new group, for whose name the outliner asks.
    pub nameless_group: Option<Entity>,
    /// A text for the system's clipboard.
    pub clipboard: Option<String>,
    /// Whether the user wants to close the window.
    pub closes: bool,
    /// Counts the commands to save that were applied, successful or not.
    pub saves_handled: u64,
    /// Counts drags, typings and clicks: edits of one kind within one of them are one step of the history.
    pub interaction: u64,
    /// Imported meshes whose size is reported once they are loaded.
    pub imported: Vec<Entity>,
}

impl Requests {
    /// Closes the start page, which would cover the new scene.
    pub fn leave_start_page(&mut self) {
        self.sheet = self.sheet.filter(|sheet| *sheet != Sheet::Start);
    }
}
