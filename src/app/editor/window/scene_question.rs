//! The question whether to add or open a scene that was dropped on the picture.

use bevy_egui::egui;

use super::question::{Answer, Question};
use crate::app::editor::command::asset_kind::FileUse;
use crate::app::editor::command::{Command, FileCommand, SceneEdit};

/// Shows the question if there is one.
pub fn question(context: &egui::Context, asked: &mut Option<FileUse>, commands: &mut Vec<Command>) {
    let Some(file) = asked else { return };
    let name = file.path.file_name().unwrap_or_default().to_string_lossy();
    let question = Question {
        id: "dropped scene",
        width: 440.0,
        heading: format!("Add {name}, or open it?"),
        answers: vec![
            Answer::primary("Add", Some(Command::from(SceneEdit::UseFile(Box::new(file.clone())))))
                .does("its shapes, materials and lights join the scene that is open.")
                .help("Enter")
                .on_enter(),
            Answer::other("Open", Some(FileCommand::OpenScene(file.path.clone()).into()))
                .does("it takes the place of the scene that is open.")
                .help("Unsaved edits are asked about"),
            Answer::cancel("Cancel", None),
        ],
    };
    if let Some(answer) = question.ask(context, |_| {}) {
        *asked = None;
        commands.extend(answer);
    }
}
