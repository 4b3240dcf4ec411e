//! The question how to save a scene whose file others changed since it was read, where saving would lose what was edited there or here.

use std::path::{Path, PathBuf};

use bevy_egui::egui::{self, Id, Modal};

use super::command::{Command, FileDialogKind};
use super::state::EditorState;
use crate::scene::write::{OnChange, SaveError};

/// Shown until it is answered; while it is there, what is read of the file anew stays aside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SaveQuestion {
    path: PathBuf,
    /// What has happened to the file, without a full stop.
    reason: String,
    /// The changes of the file can be taken in.
    can_merge: bool,
    /// The user is choosing another file.
    is_naming: bool,
}

impl SaveQuestion {
    /// `path`: where the scene was to be saved. None for errors that saving in another way would not mend.
    pub fn about(error: &SaveError, path: &Path) -> Option<Self> {
        let can_merge = match error {
            SaveError::Changed { edited_twice, .. } => edited_twice.is_some(),
            SaveError::Broken { .. } => false,
            _ => return None,
        };
        Some(Self {
            path: path.to_owned(),
            reason: error.to_string(),
            can_merge,
            is_naming: false,
        })
    }

    /// The same for those who cannot be asked.
    pub fn refusal(&self) -> String {
        let merge = match self.can_merge {
            true => "`save-to FILE merge` takes in what the file changed, ",
            false => "",
        };
        format!(
            "{}; it was not saved ({merge}`save-to FILE overwrite` replaces it)",
            self.reason
        )
    }
}

/// Asks, if there is something to ask.
pub fn show(context: &egui::Context, state: &mut EditorState, commands: &mut Vec<Command>) {
    let Some(question) = &mut state.save_question else {
        return;
    };
    if question.is_naming {
        // The dialog is closed, with a name or without.
        if state.dialog.is_none() {
            state.save_question = None;
        }
        return;
    }
    match ask(context, question) {
        None => {}
        Some(Answer::Save(on_change)) => {
            commands.push(Command::SaveChanged(question.path.clone(), on_change));
            state.save_question = None;
        }
        Some(Answer::SaveAs) => {
            question.is_naming = true;
            state.dialog = Some(FileDialogKind::SaveScene);
        }
        Some(Answer::Cancel) => state.save_question = None,
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
