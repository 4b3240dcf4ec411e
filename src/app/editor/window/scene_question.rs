//! The question what is to be done with a whole scene that was dropped on the picture.

use bevy_egui::egui;

use super::dialog;
use crate::app::editor::command::Command;
use crate::app::editor::command::asset_kind::FileUse;
use crate::app::editor::panels::look;

enum Answer {
    Add,
    Open,
    Cancel,
}

/// Shows the question if there is one.
pub fn question(context: &egui::Context, asked: &mut Option<FileUse>, commands: &mut Vec<Command>) {
    let Some(file) = asked else { return };
    let name = file.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let heading = format!("Add {name}, or open it?");
    let modal = dialog::question(context, "dropped scene", 440.0, &heading, |ui| {
        dialog::consequence(
            ui,
            "Add",
            "its shapes, materials and lights join the scene that is open.",
        );
        dialog::consequence(ui, "Open", "it takes the place of the scene that is open.");
        let add = look::primary(ui, "Add");
        let mut answer = None;
        if dialog::is_entered(ui) {
            answer = Some(Answer::Add);
        }
        dialog::answers(
            ui,
            |_| {},
            |ui| {
                if ui.add(add).on_hover_text("Enter").clicked() {
                    answer = Some(Answer::Add);
                }
                if ui
                    .button("Open")
                    .on_hover_text("Unsaved edits are asked about")
                    .clicked()
                {
                    answer = Some(Answer::Open);
                }
                if ui.button("Cancel").on_hover_text("Esc").clicked() {
                    answer = Some(Answer::Cancel);
                }
            },
        );
        answer
    });
    let closed = modal.should_close();
    let Some(answer) = modal.inner.or(closed.then_some(Answer::Cancel)) else {
        return;
    };
    let Some(file) = asked.take() else { return };
    match answer {
        Answer::Add => commands.push(Command::UseFile(Box::new(file))),
        Answer::Open => commands.push(Command::OpenScene(file.path)),
        Answer::Cancel => {}
    }
}
