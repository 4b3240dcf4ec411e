//! The question whether a scene may read files outside its folder.

use std::path::{Path, PathBuf};

use bevy_egui::egui;

use super::question::{Answer, Question};
use crate::app::editor::command::file_access::Question as AccessQuestion;
use crate::app::editor::command::{Command, SceneEdit, ShellCommand};

/// The most files, and the most folders, that are listed; of the others only the number is shown.
const MOST_LISTED: usize = 6;

/// Asks the question, and sets `question` to None once it is answered.
pub fn question(context: &egui::Context, question: &mut Option<AccessQuestion>, commands: &mut Vec<Command>) {
    let Some(asked) = question else {
        return;
    };
    let left_out = match (&asked.edit, asked.is_needed) {
        (Some(SceneEdit::Replace(_)), _) => "nothing is replaced.",
        (Some(_), _) => "nothing is imported.",
        (None, true) => "the scene cannot be shown without them, and the last one stays.",
        (None, false) => "the scene is shown without these pictures and meshes.",
    };
    let dialog = Question {
        id: "trust",
        width: 460.0,
        heading: "Read files outside the scene's folder?".to_owned(),
        answers: vec![
            Answer::primary(
                "Read them",
                Some(Command::Shell(ShellCommand::AllowFiles(asked.clone()))),
            )
            .does("the folders are remembered, and the files are read now."),
            Answer::cancel("Leave them out", None).does(left_out),
        ],
    };
    let answer = dialog.ask(context, |ui| {
        let name = asked.file().and_then(Path::file_name);
        let subject = name.map_or("The scene".into(), |name| name.to_string_lossy());
        ui.label(format!("{subject} names files that it may not read:"));
        list(ui, &asked.shown);
        ui.label("If it may, every scene may read all files in these folders, and below them, from now on:");
        list(ui, &asked.folders);
        ui.add_space(4.0);
    });
    if let Some(answer) = answer {
        commands.extend(answer);
        *question = None;
    }
}

fn list(ui: &mut egui::Ui, paths: &[PathBuf]) {
    ui.add_space(4.0);
    for path in paths.iter().take(MOST_LISTED) {
        ui.weak(path.display().to_string());
    }
    if let Some(more @ 1..) = paths.len().checked_sub(MOST_LISTED) {
        ui.weak(format!("... and {more} more"));
    }
    ui.add_space(4.0);
}
