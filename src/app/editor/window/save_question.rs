//! The question how to save a scene whose file was changed by others since it was read, if saving would lose edits of either side.

use bevy_egui::egui::{self, Ui};

use super::dialog;
use crate::app::editor::command::{Command, FileDialogKind};
use crate::app::editor::panels::look;
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::save_question::SaveQuestion;
use crate::scene::write::OnChange;

/// Shows the question if there is one.
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
    let modal = dialog::question(context, "file changed", 480.0, "The file was changed elsewhere", |ui| {
        ui.label(format!("{}.", question.reason));
        ui.add_space(6.0);
        consequences(ui, question.can_merge);
        let (mut merges, mut overwrites, mut renames, mut cancels) = (false, false, false, false);
        let (merge, overwrite) = (look::primary(ui, MERGE), look::danger(ui, OVERWRITE));
        dialog::answers(
            ui,
            |ui| overwrites = ui.add(overwrite).clicked(),
            |ui| {
                merges = question.can_merge && ui.add(merge).clicked();
                renames = ui.button("Save as...").clicked();
                cancels = ui.button("Cancel").on_hover_text("Save nothing (Esc)").clicked();
            },
        );
        match (merges, overwrites, renames, cancels) {
            (true, ..) => Some(Answer::Save(OnChange::TakeIn)),
            (_, true, ..) => Some(Answer::Save(OnChange::Overwrite)),
            (_, _, true, _) => Some(Answer::SaveAs),
            (.., true) => Some(Answer::Cancel),
            _ => None,
        }
    });
    let closed = modal.should_close();
    modal.inner.or(closed.then_some(Answer::Cancel))
}

const MERGE: &str = "Merge and save";
const OVERWRITE: &str = "Overwrite";

fn consequences(ui: &mut Ui, can_merge: bool) {
    if can_merge {
        let merge = "what the file changed is taken in, and the rest of your edits is saved. Where both changed the same, the file's edit counts.";
        dialog::consequence(ui, MERGE, merge);
    }
    let overwrite = "the scene is saved as it is here, and what others changed in the file is lost.";
    dialog::consequence(ui, OVERWRITE, overwrite);
    let save_as = "the scene is saved under another name, and the file stays as it is.";
    dialog::consequence(ui, "Save as", save_as);
}
