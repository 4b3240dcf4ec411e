//! The question what to do with unsaved edits. A command that would lose them waits until it is answered.

use std::path::Path;

use bevy_egui::egui;

use super::question::{Answer, Question};
use crate::app::editor::command::{Command, FileCommand, ShellCommand};
use crate::app::editor::session::recovery::is_copy_of;
use crate::scene::write::OnChange;

/// The command that waits for an answer, if there is one.
#[derive(Debug, Default)]
pub struct UnsavedQuestion {
    waiting: Option<Waiting>,
    /// Whether it was held back in this frame.
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
    /// The scene is being saved.
    Saving {
        /// The number of commands to save that were applied before.
        handled: u64,
        /// Whether a dialog was open since the last command to save.
        chose_file: bool,
    },
}

/// The state that the question depends on.
#[derive(Clone, Copy, Debug)]
pub struct UnsavedState<'a> {
    /// The scene's name.
    pub name: &'a str,
    /// The scene's file.
    pub path: Option<&'a Path>,
    /// The time of the last save, as a sentence.
    pub saved: Option<&'a str>,
    /// Whether there are edits that no file has.
    pub edits: bool,
    /// Whether the user is choosing a file.
    pub dialog_open: bool,
    /// The number of commands to save that were applied.
    pub saves_handled: u64,
}

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
        let Some(place) = commands.iter().position(|command| command.traits().loses_edits) else {
            return;
        };
        // Edits of this frame count as well.
        let is_edit = |command: &Command| matches!(command, Command::Edit(_));
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

    /// Shows the question, and passes the command on once it is answered. To be called after [`Self::hold`]. Returns
    /// true if the user has chosen to lose the edits.
    pub fn show(&mut self, context: &egui::Context, unsaved: UnsavedState, commands: &mut Vec<Command>) -> bool {
        let Some(waiting) = &mut self.waiting else {
            return false;
        };
        if !unsaved.edits && !self.is_new {
            commands.extend(self.waiting.take().map(|waiting| waiting.command));
            return false;
        }
        match &mut waiting.step {
            Step::Saving { handled, chose_file } => {
                if unsaved.dialog_open {
                    *chose_file = true;
                } else if commands.iter().any(|command| command.traits().saves) {
                    (*handled, *chose_file) = (unsaved.saves_handled, false);
                } else if *chose_file || *handled != unsaved.saves_handled {
                    // The save has failed or was cancelled.
                    self.waiting = None;
                }
            }
            Step::Asking => {
                let answer = question(unsaved.name, &waiting.command).ask(context, |ui| {
                    if let Some(saved) = unsaved.saved {
                        ui.label(saved);
                        ui.add_space(6.0);
                    }
                });
                match answer {
                    Some(Choice::Save) => {
                        waiting.step = Step::Saving {
                            handled: unsaved.saves_handled,
                            chose_file: false,
                        };
                        commands.push(save_before(&waiting.command, unsaved.path));
                    }
                    Some(Choice::Lose) => {
                        commands.extend(self.waiting.take().map(|waiting| waiting.command));
                        return true;
                    }
                    Some(Choice::Cancel) => self.waiting = None,
                    None => {}
                }
            }
        }
        false
    }
}

/// The command that saves the scene before this one. A user who recovers an autosave of the same scene knows of it, and
/// is not asked again.
fn save_before(command: &Command, scene: Option<&Path>) -> Command {
    if let (Command::Shell(ShellCommand::Recover(copy)), Some(scene)) = (command, scene)
        && is_copy_of(copy, scene)
    {
        return FileCommand::SaveChanged(scene.to_owned(), OnChange::Refuse).into();
    }
    FileCommand::Save.into()
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Choice {
    Save,
    Lose,
    Cancel,
}

fn question(name: &str, command: &Command) -> Question<Choice> {
    let cancel = Answer::cancel("Cancel", Choice::Cancel)
        .does("everything stays as it is.")
        .help("Stay here (Esc)");
    let (heading, answers) = if *command == Command::from(FileCommand::RevertScene) {
        let revert = Answer::danger("Revert", Choice::Lose)
            .does("the file is read anew. What was changed since it was saved is lost and cannot be brought back.")
            .help("Read the file anew");
        (format!("Lose the changes of {name}?"), vec![revert, cancel])
    } else {
        let what = if matches!(command, Command::File(FileCommand::Quit)) {
            "the window closes"
        } else if matches!(command, Command::File(FileCommand::NewScene)) {
            "a new scene begins"
        } else if matches!(command, Command::Shell(ShellCommand::Recover(_))) {
            "the copy opens"
        } else {
            "the other scene opens"
        };
        let save = Answer::primary("Save", Choice::Save)
            .does(format!("the scene is saved, and then {what}."))
            .help("Save, then continue (Enter)")
            .on_enter();
        let lose = Answer::danger("Don't save", Choice::Lose)
            .does(format!(
                "{what}, and what was changed since the scene was saved is lost."
            ))
            .help("Continue without saving");
        (format!("Save the changes of {name}?"), vec![save, lose, cancel])
    };
    Question {
        id: "unsaved edits",
        width: 420.0,
        heading,
        answers,
    }
}
