//! The question how to save a scene whose file was changed by others since it was read, if saving would lose edits of
//! either side; and whether to save one of which there are other edits to recover.

use bevy_egui::egui::{self, Ui};

use super::dialog;
use crate::app::editor::command::recovery_offer::Offer;
use crate::app::editor::command::shell::ShellCommand;
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
    let answer = match question.copy.clone() {
        Some(copy) => ask_about_copy(context, question, copy),
        None => ask(context, question),
    };
    match answer {
        None => {}
        Some(Answer::Recover(copy)) => {
            commands.push(Command::Shell(ShellCommand::Recover(copy)));
            requests.save_question = None;
        }
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
    Recover(Offer),
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

fn ask_about_copy(context: &egui::Context, question: &SaveQuestion, copy: Offer) -> Option<Answer> {
    // Those of the window may be newer still.
    let heading = "There are other edits of this scene";
    let modal = dialog::question(context, "newer copy", 480.0, heading, |ui| {
        ui.label(format!(
            "{}. The scene that is open does not have them.",
            question.reason
        ));
        ui.add_space(6.0);
        let recover = "the copy opens in place of this scene, after a question about the edits here; the file stays as it is until you save.";
        dialog::consequence(ui, "Recover", recover);
        dialog::consequence(ui, SAVE_ANYWAY, "the scene is saved as it is here. The copy stays.");
        let save_as = "the scene is saved under another name; the file and the copy stay.";
        dialog::consequence(ui, "Save as", save_as);
        let (mut saves, mut renames, mut cancels) = (false, false, false);
        let mut recovers = dialog::is_entered(ui);
        let (primary, save) = (look::primary(ui, "Recover"), look::danger(ui, SAVE_ANYWAY));
        dialog::answers(
            ui,
            |ui| saves = ui.add(save).clicked(),
            |ui| {
                recovers |= ui.add(primary).on_hover_text("Enter").clicked();
                renames = ui.button("Save as...").clicked();
                cancels = ui.button("Cancel").on_hover_text("Save nothing (Esc)").clicked();
            },
        );
        match (recovers, saves, renames, cancels) {
            (true, ..) => Some(Answer::Recover(copy)),
            (_, true, ..) => Some(Answer::Save(OnChange::Refuse)),
            (_, _, true, _) => Some(Answer::SaveAs),
            (.., true) => Some(Answer::Cancel),
            _ => None,
        }
    });
    let closed = modal.should_close();
    modal.inner.or(closed.then_some(Answer::Cancel))
}

const SAVE_ANYWAY: &str = "Save anyway";
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
