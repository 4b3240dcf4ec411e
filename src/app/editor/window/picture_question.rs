//! The question what to do with an unfinished picture. Closing the window waits until it is answered.

use bevy_egui::egui;

use super::question::{Answer, Question};
use crate::app::editor::command::{Command, FileCommand, KeptPicture};
use crate::app::editor::panels::status::clock;

/// Whether the question is open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PictureQuestion {
    is_asking: bool,
}

impl PictureQuestion {
    /// Whether the question is open and takes keys and mouse.
    pub fn is_asking(self) -> bool {
        self.is_asking
    }

    /// Holds back the command to quit, if the picture can be kept and is worth it. To be called after the question
    /// about unsaved edits, which passes the command on.
    pub fn hold(&mut self, commands: &mut Vec<Command>, is_worth_it: bool) {
        if is_worth_it && commands.contains(&Command::from(FileCommand::Quit)) {
            commands.retain(|command| *command != Command::from(FileCommand::Quit));
            self.is_asking = true;
        }
    }

    /// Shows the question. `seconds` is the picture's time of rendering. To be called after [`Self::hold`].
    pub fn show(&mut self, context: &egui::Context, seconds: f64, commands: &mut Vec<Command>) {
        if !self.is_asking {
            return;
        }
        let question = Question {
            id: "unfinished picture",
            width: 440.0,
            heading: "Keep the picture?".to_owned(),
            answers: vec![
                Answer::primary("Keep", Some(KeptPicture::KeepAndQuit.into()))
                    .does(
                        "it is written beside the scene, and resumed with all its samples when the scene is opened \
                         again.",
                    )
                    .help("Keep it, then close (Enter)")
                    .on_enter(),
                Answer::danger("Don't keep", Some(Command::from(FileCommand::Quit)))
                    .does("the window closes, and the samples are lost.")
                    .help("Close without keeping"),
                Answer::cancel("Cancel", None).does("everything stays as it is."),
            ],
        };
        let answer = question.ask(context, |ui| {
            ui.label(format!("It was rendered for {} and is not finished.", clock(seconds)));
            ui.add_space(6.0);
        });
        self.is_asking = answer.is_none();
        commands.extend(answer.flatten());
    }
}
