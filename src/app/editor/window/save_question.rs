//! The question how to save a scene whose file was changed by others since it was read, if saving would lose edits of
//! either side; and whether to save over a scene with an autosave.

use bevy_egui::egui;

use super::question::{Answer, Question};
use crate::app::editor::command::recovery_offer::Offer;
use crate::app::editor::command::{Command, FileCommand, FileDialogKind, ShellCommand};
use crate::app::editor::session::requests::Requests;
use crate::scene::write::OnChange;

/// Shows the question if there is one.
pub fn show(context: &egui::Context, requests: &mut Requests, commands: &mut Vec<Command>) {
    let Some(question) = &mut requests.save_question else {
        return;
    };
    if question.is_naming {
        // The dialog is closed, with a name chosen or not.
        if requests.dialog.is_none() {
            requests.save_question = None;
        }
        return;
    }
    let dialog = match question.copy.clone() {
        Some(copy) => about_copy(copy),
        None => about_change(question.can_merge),
    };
    let is_about_copy = question.copy.is_some();
    let answer = dialog.ask(context, |ui| {
        ui.label(match is_about_copy {
            true => format!("{}. The scene that is open does not have them.", question.reason),
            false => format!("{}.", question.reason),
        });
        ui.add_space(6.0);
    });
    match answer {
        None => return,
        Some(Choice::Recover(copy)) => commands.push(ShellCommand::Recover(copy).into()),
        Some(Choice::Save(on_change)) => {
            commands.push(FileCommand::SaveChanged(question.path.clone(), on_change).into())
        }
        Some(Choice::SaveAs) => {
            question.is_naming = true;
            requests.dialog = Some(FileDialogKind::SaveScene);
            return;
        }
        Some(Choice::Cancel) => {}
    }
    requests.save_question = None;
}

enum Choice {
    Save(OnChange),
    Recover(Offer),
    SaveAs,
    Cancel,
}

fn about_change(can_merge: bool) -> Question<Choice> {
    let merge = Answer::primary("Merge and save", Choice::Save(OnChange::TakeIn)).does(
        "what the file changed is taken in, and the rest of your edits is saved. Where both changed the same, the \
         file's edit counts.",
    );
    let mut answers = vec![
        Answer::danger("Overwrite", Choice::Save(OnChange::Overwrite))
            .does("the scene is saved as it is here, and what others changed in the file is lost."),
        Answer::other("Save as...", Choice::SaveAs)
            .does("the scene is saved under another name, and the file stays as it is."),
        cancel(),
    ];
    if can_merge {
        answers.insert(0, merge);
    }
    Question {
        id: "file changed",
        width: 480.0,
        heading: "The file was changed elsewhere".to_owned(),
        answers,
    }
}

/// The question about an autosave, which may be older than the window's edits.
fn about_copy(copy: Offer) -> Question<Choice> {
    Question {
        id: "newer copy",
        width: 480.0,
        heading: "There are other edits of this scene".to_owned(),
        answers: vec![
            Answer::primary("Recover", Choice::Recover(copy))
                .does(
                    "the copy opens in place of this scene, after a question about the edits here; the file stays as \
                     it is until you save.",
                )
                .help("Enter")
                .on_enter(),
            Answer::danger("Save anyway", Choice::Save(OnChange::Refuse))
                .does("the scene is saved as it is here. The copy stays."),
            Answer::other("Save as...", Choice::SaveAs)
                .does("the scene is saved under another name; the file and the copy stay."),
            cancel(),
        ],
    }
}

fn cancel() -> Answer<Choice> {
    Answer::cancel("Cancel", Choice::Cancel).help("Save nothing (Esc)")
}
