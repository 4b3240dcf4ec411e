//! The question what to do with unsaved edits. A command that would lose them waits until it is answered.

use std::path::Path;

use bevy_egui::egui::{self, Ui};

use super::dialog;
use crate::app::editor::command::shell::ShellCommand;
use crate::app::editor::command::{Command, Effect};
use crate::app::editor::panels::look;
use crate::app::editor::session::recovery::is_copy_of;
use crate::scene::write::OnChange;

/// The command that waits for an answer, if there is one.
#[derive(Debug, Default)]
pub struct UnsavedQuestion {
    waiting: Option<Waiting>,
    /// Whether it was held back in this very frame.
    is_new: bool,
}

#[derive(Debug)]
struct Waiting {
    command: Command,
    step: Step,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Asking,
    /// The scene is being saved. The number counts the frames since then without a dialog.
    Saving(u32),
}

/// The state that the question depends on.
#[derive(Clone, Copy, Debug)]
pub struct UnsavedState<'a> {
    /// The scene's name.
    pub name: &'a str,
    /// The scene's file.
    pub path: Option<&'a Path>,
    /// When the scene was saved last, as a sentence.
    pub saved: Option<&'a str>,
    /// Whether there are edits that no file has.
    pub edits: bool,
    /// Whether the user is choosing a file.
    pub dialog_open: bool,
}

/// The number of frames after which edits that are still there mean that the save failed or was cancelled. A save of a
/// small scene takes one frame, and the panels know one later. One that goes on beside the frames counts as saved here.
const FRAMES_UNTIL_SAVED: u32 = 3;

impl UnsavedQuestion {
    /// Whether the question is open and takes keys and mouse.
    pub(crate) fn is_asking(&self) -> bool {
        self.waiting
            .as_ref()
            .is_some_and(|waiting| waiting.step == Step::Asking)
    }

    /// Holds back the first command that would lose edits, and drops those after it.
    pub fn hold(&mut self, commands: &mut Vec<Command>, edits: bool) {
        self.is_new = false;
        let Some(place) = commands.iter().position(Command::loses_edits) else {
            return;
        };
        // Edits of this very frame count as well.
        let is_edit = |command: &Command| matches!(command.effect(), Effect::Edit | Effect::Drag);
        if edits || commands[..place].iter().any(is_edit) {
            let command = commands.swap_remove(place);
            commands.truncate(place);
            self.is_new = true;
            self.waiting = Some(Waiting {
                command,
                step: Step::Asking,
            });
        }
    }

    /// Shows the question, and hands the command on once it is answered. To be called after [`Self::hold`]. True if the
    /// user has chosen to lose the edits.
    pub fn show(&mut self, context: &egui::Context, unsaved: UnsavedState, commands: &mut Vec<Command>) -> bool {
        let Some(waiting) = &mut self.waiting else {
            return false;
        };
        if !unsaved.edits && !self.is_new {
            commands.extend(self.waiting.take().map(|waiting| waiting.command));
            return false;
        }
        match &mut waiting.step {
            Step::Saving(frames) => {
                *frames = if unsaved.dialog_open { 0 } else { *frames + 1 };
                if *frames > FRAMES_UNTIL_SAVED {
                    self.waiting = None;
                }
            }
            Step::Asking => match question(context, unsaved.name, unsaved.saved, &waiting.command) {
                Some(Answer::Save) => {
                    waiting.step = Step::Saving(0);
                    commands.push(save_before(&waiting.command, unsaved.path));
                }
                Some(Answer::Lose) => {
                    commands.extend(self.waiting.take().map(|waiting| waiting.command));
                    return true;
                }
                Some(Answer::Cancel) => self.waiting = None,
                None => {}
            },
        }
        false
    }
}

/// The command that saves the scene before this one is done. Who recovers a copy of the very scene knows that there is
/// one, and is not asked about it again.
fn save_before(command: &Command, scene: Option<&Path>) -> Command {
    match (command, scene) {
        (Command::Shell(ShellCommand::Recover(copy)), Some(scene)) if is_copy_of(copy, scene) => {
            Command::SaveChanged(scene.to_owned(), OnChange::Refuse)
        }
        _ => Command::Save,
    }
}

enum Answer {
    Save,
    Lose,
    Cancel,
}

fn question(context: &egui::Context, name: &str, saved: Option<&str>, command: &Command) -> Option<Answer> {
    let reverts = *command == Command::RevertScene;
    let heading = match reverts {
        true => format!("Lose the changes of {name}?"),
        false => format!("Save the changes of {name}?"),
    };
    let modal = dialog::question(context, "unsaved edits", 420.0, &heading, |ui| {
        if let Some(saved) = saved {
            ui.label(saved);
            ui.add_space(6.0);
        }
        if reverts {
            let text = "the file is read anew. What was changed since it was saved is lost and cannot be brought back.";
            dialog::consequence(ui, "Revert", text);
        } else {
            let what = match command {
                Command::Quit => "the window closes",
                Command::NewScene => "a new scene begins",
                Command::Shell(ShellCommand::Recover(_)) => "the copy opens",
                _ => "the other scene opens",
            };
            dialog::consequence(ui, "Save", &format!("the scene is saved, and then {what}."));
            let lost = "and what was changed since the scene was saved is lost.";
            dialog::consequence(ui, "Don't save", &format!("{what}, {lost}"));
        }
        dialog::consequence(ui, "Cancel", "everything stays as it is.");
        answers(ui, reverts)
    });
    let closed = modal.should_close();
    modal.inner.or(closed.then_some(Answer::Cancel))
}

/// The buttons. The command to revert has none to save.
fn answers(ui: &mut Ui, reverts: bool) -> Option<Answer> {
    let (mut lost, mut saved, mut cancelled) = (false, false, false);
    let (lose, help) = match reverts {
        true => ("Revert", "Read the file anew"),
        false => ("Don't save", "Continue without saving"),
    };
    let (lose, save) = (look::danger(ui, lose), look::primary(ui, "Save"));
    if !reverts {
        saved = dialog::is_entered(ui);
    }
    dialog::answers(
        ui,
        |ui| lost = ui.add(lose).on_hover_text(help).clicked(),
        |ui| {
            if !reverts {
                saved |= ui.add(save).on_hover_text("Save, then continue (Enter)").clicked();
            }
            cancelled = ui.button("Cancel").on_hover_text("Stay here (Esc)").clicked();
        },
    );
    match (saved, lost, cancelled) {
        (true, ..) => Some(Answer::Save),
        (_, true, _) => Some(Answer::Lose),
        (_, _, true) => Some(Answer::Cancel),
        _ => None,
    }
}
