//! The question what to do with a picture that is not finished. Closing the window waits until it is answered.

use bevy_egui::egui;

use super::dialog;
use crate::app::editor::command::Command;
use crate::app::editor::command::kept_picture::KeptPicture;
use crate::app::editor::panels::look;
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
    /// about unsaved edits, which hands the command on.
    pub fn hold(&mut self, commands: &mut Vec<Command>, is_worth_it: bool) {
        if is_worth_it && commands.contains(&Command::Quit) {
            commands.retain(|command| *command != Command::Quit);
            self.is_asking = true;
        }
    }

    /// Shows the question. `seconds`: how long the picture was rendered. To be called after [`Self::hold`].
    pub fn show(&mut self, context: &egui::Context, seconds: f64, commands: &mut Vec<Command>) {
        if !self.is_asking {
            return;
        }
        let mut answer = None;
        let modal = dialog::question(context, "unfinished picture", 440.0, "Keep the picture?", |ui| {
            ui.label(format!("It was rendered for {} and is not finished.", clock(seconds)));
            ui.add_space(6.0);
            let kept =
                "it is written beside the scene, and resumed with all its samples when the scene is opened again.";
            dialog::consequence(ui, "Keep", kept);
            dialog::consequence(ui, "Don't keep", "the window closes, and the samples are lost.");
            dialog::consequence(ui, "Cancel", "everything stays as it is.");
            let (lose, keep) = (look::danger(ui, "Don't keep"), look::primary(ui, "Keep"));
            let (mut loses, mut keeps, mut cancels) = (false, dialog::is_entered(ui), false);
            dialog::answers(
                ui,
                |ui| loses = ui.add(lose).on_hover_text("Close without keeping").clicked(),
                |ui| {
                    keeps |= ui.add(keep).on_hover_text("Keep it, then close (Enter)").clicked();
                    cancels = ui.button("Cancel").on_hover_text("Esc").clicked();
                },
            );
            if keeps {
                answer = Some(Command::KeptPicture(KeptPicture::KeepAndQuit));
            } else if loses {
                answer = Some(Command::Quit);
            } else if cancels {
                ui.close();
            }
        });
        self.is_asking = answer.is_none() && !modal.should_close();
        commands.extend(answer);
    }
}
