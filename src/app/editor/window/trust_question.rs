//! The question whether a scene may read files outside its folder.

use std::path::{Path, PathBuf};

use bevy_egui::egui;

use super::dialog;
use crate::app::editor::command::Command;
use crate::app::editor::command::file_access::Question;
use crate::app::editor::command::shell::ShellCommand;
use crate::app::editor::panels::look;

/// The most files, and the most folders, that are listed; of the others only the number is told.
const MOST_LISTED: usize = 6;

const READ: &str = "Read them";
const LEAVE_OUT: &str = "Leave them out";

/// Asks; `question` is None once it is answered.
pub fn question(context: &egui::Context, question: &mut Option<Question>, commands: &mut Vec<Command>) {
    let Some(asked) = question else {
        return;
    };
    let mut answer = None;
    let modal = dialog::question(
        context,
        "trust",
        460.0,
        "Read files outside the scene's folder?",
        |ui| {
            let name = asked.import.as_deref().and_then(Path::file_name);
            let subject = name.map_or("The scene".into(), |name| name.to_string_lossy());
            ui.label(format!("{subject} names files that it may not read:"));
            list(ui, &asked.shown);
            ui.label("If it may, every scene may read all files in these folders, and below them, from now on:");
            list(ui, &asked.folders);
            ui.add_space(4.0);
            dialog::consequence(ui, READ, "the folders are remembered, and the files are read now.");
            let left_out = match (&asked.import, asked.is_needed) {
                (Some(_), _) => "nothing is imported.",
                (None, true) => "the scene cannot be shown without them, and the last one stays.",
                (None, false) => "the scene is shown without these pictures and meshes.",
            };
            dialog::consequence(ui, LEAVE_OUT, left_out);
            let read = look::primary(ui, READ);
            dialog::answers(
                ui,
                |_| {},
                |ui| {
                    if ui.add(read).clicked() {
                        answer = Some(ShellCommand::AllowFiles(asked.clone()));
                    }
                    if ui.button(LEAVE_OUT).on_hover_text("Esc").clicked() {
                        ui.close();
                    }
                },
            );
        },
    );
    if answer.is_some() || modal.should_close() {
        commands.extend(answer.map(Command::Shell));
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
