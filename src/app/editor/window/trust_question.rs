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
            if asked.is_needed {
                ui.label("The scene cannot be shown without them: if they are left out, the last one stays.");
            }
            ui.add_space(8.0);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let allow = ui.add(look::primary(ui, "Read them"));
                let allow = allow.on_hover_text("Allow the folders, and read the files");
                if allow.clicked() {
                    answer = Some(ShellCommand::AllowFiles(asked.clone()));
                }
                let refuse = ui.button("Leave them out").on_hover_text(match asked.import {
                    None => "Read nothing outside the scene's folder (Esc)",
                    Some(_) => "Import nothing (Esc)",
                });
                if refuse.clicked() {
                    ui.close();
                }
            });
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
