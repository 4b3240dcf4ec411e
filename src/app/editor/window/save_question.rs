//! The question how to save a scene whose file was changed by others since it was read, if saving would lose edits of either side.

use bevy_egui::egui::{self, Id, Modal};

use crate::app::editor::command::{Command, FileDialogKind};
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::save_question::SaveQuestion;
use crate::scene::write::OnChange;

/// Asks, if there is something to ask.
pub fn show(context: &egui::Context, requests: &mut Requests, commands: &mut Vec<Command>) {
    let Some(question) = &mut requests.save_question else {
        return;
    };
    if question.is_naming {
        // The dialog is closed, with a name or without.
        if requests.dialog.is_none() {
            requests.save_question = None;
        }
        return;
    }
    match ask(context, question) {
        None => {}
        Some(Answer::Save(on_change)) => {
            commands.push(Command::SaveChanged(question.path.clone(), on_change));
            requests.save_question = None;
        }
        Some(Answer::SaveAs) => {
            question.is_naming = true;
            requests.dialog = Some(FileDialogKind::SaveScene);
        }
        Some(Answer::Cancel) => requests.save_question = None,
    }
}

enum Answer {
    Save(OnChange),
    SaveAs,
    Cancel,
}

fn ask(context: &egui::Context, question: &SaveQuestion) -> Option<Answer> {
    let modal = Modal::new(Id::new("file changed")).show(context, |ui| {
        ui.set_width(440.0);
        ui.heading("The file was changed elsewhere");
        ui.add_space(4.0);
        ui.label(format!("{}.", question.reason));
        ui.add_space(8.0);
        let mut answer = None;
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if question.can_merge {
                let merge = ui.button("Merge and save").on_hover_text(
                    "Take in what the file changed and save the rest of your edits; where both changed the same, the file's edit counts",
                );
                if merge.clicked() {
                    answer = Some(Answer::Save(OnChange::TakeIn));
                }
            }
            let overwrite = ui
                .button("Overwrite")
                .on_hover_text("Save the scene as it is here; what others changed in the file is lost");
            if overwrite.clicked() {
                answer = Some(Answer::Save(OnChange::Overwrite));
            }
            let save_as = ui
                .button("Save as...")
                .on_hover_text("Save under another name; the file stays as it is");
            if save_as.clicked() {
                answer = Some(Answer::SaveAs);
            }
            let cancel = ui.button("Cancel").on_hover_text("Save nothing (Esc)");
            if cancel.clicked() {
                answer = Some(Answer::Cancel);
            }
        });
        answer
    });
    let closed = modal.should_close();
    modal.inner.or(closed.then_some(Answer::Cancel))
}
