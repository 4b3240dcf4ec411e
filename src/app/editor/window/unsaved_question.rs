//! The question what to do with unsaved edits. A command that would lose them waits until it is answered.

use bevy_egui::egui::{self, Id, Modal, Ui};

use crate::app::editor::command::shell::ShellCommand;
use crate::app::editor::command::{Command, Effect};

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
    /// Whether there are edits that no file has.
    pub edits: bool,
    /// Whether the user is choosing a file.
    pub dialog_open: bool,
}

/// The number of frames after which edits that are still there mean that the save failed or was cancelled. A save takes one frame, and the panels
/// know one later.
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
        let loses = |command: &Command| {
            matches!(
                command,
                Command::NewScene
                    | Command::OpenScene(_)
                    | Command::RevertScene
                    | Command::Quit
                    | Command::Shell(ShellCommand::Recover(_))
            )
        };
        let Some(place) = commands.iter().position(loses) else {
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

    /// Shows the question, and hands the command on once it is answered. To be called after [`Self::hold`].
    pub fn show(&mut self, context: &egui::Context, unsaved: UnsavedState, commands: &mut Vec<Command>) {
        let Some(waiting) = &mut self.waiting else {
            return;
        };
        if !unsaved.edits && !self.is_new {
            commands.extend(self.waiting.take().map(|waiting| waiting.command));
            return;
        }
        match &mut waiting.step {
            Step::Saving(frames) => {
                *frames = if unsaved.dialog_open { 0 } else { *frames + 1 };
                if *frames > FRAMES_UNTIL_SAVED {
                    self.waiting = None;
                }
            }
            Step::Asking => match question(context, unsaved.name, &waiting.command) {
                Some(Answer::Save) => {
                    waiting.step = Step::Saving(0);
                    commands.push(Command::Save);
                }
                Some(Answer::Lose) => commands.extend(self.waiting.take().map(|waiting| waiting.command)),
                Some(Answer::Cancel) => self.waiting = None,
                None => {}
            },
        }
    }
}

enum Answer {
    Save,
    Lose,
    Cancel,
}

fn question(context: &egui::Context, name: &str, command: &Command) -> Option<Answer> {
    let modal = Modal::new(Id::new("unsaved edits")).show(context, |ui| {
        ui.set_width(380.0);
        let reverts = *command == Command::RevertScene;
        if reverts {
            ui.heading(format!("Lose the changes of {name}?"));
            ui.add_space(4.0);
            ui.label("What was changed since the scene was saved cannot be brought back.");
        } else {
            ui.heading(format!("Save the changes of {name}?"));
            ui.add_space(4.0);
            let what = match command {
                Command::Quit => "closing the window",
                Command::NewScene => "a new scene",
                _ => "opening another scene",
            };
            ui.label(format!(
                "Otherwise {what} loses what was changed since the scene was saved."
            ));
        }
        ui.add_space(8.0);
        answers(ui, reverts)
    });
    let closed = modal.should_close();
    modal.inner.or(closed.then_some(Answer::Cancel))
}

/// The buttons. The command to revert has none to save.
fn answers(ui: &mut Ui, reverts: bool) -> Option<Answer> {
    let mut answer = None;
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        if reverts {
            if ui.button("Revert").on_hover_text("Read the file anew").clicked() {
                answer = Some(Answer::Lose);
            }
        } else {
            let accepted = ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, egui::Key::Enter));
            let save = ui.button("Save").on_hover_text("Save, then continue (Enter)");
            if save.clicked() || accepted {
                answer = Some(Answer::Save);
            }
            if ui
                .button("Don't save")
                .on_hover_text("Continue without saving")
                .clicked()
            {
                answer = Some(Answer::Lose);
            }
        }
        if ui.button("Cancel").on_hover_text("Stay here (Esc)").clicked() {
            answer = Some(Answer::Cancel);
        }
    });
    answer
}
