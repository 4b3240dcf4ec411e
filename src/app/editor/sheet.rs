//! What lies over the window until it is closed: the palette, the overview of keys, the preferences.

use bevy_egui::egui::{self, Id, Modal};

use super::actions::ActionContext;
use super::command::Command;
use super::model::Model;
use super::panels::preferences::preferences;
use super::preferences::Preferences;
use super::shell::Sheet;
use super::shortcuts::shortcuts;
use super::state::EditorState;

/// What the sheets tell beside the model.
#[derive(Clone, Copy)]
pub struct SheetModel<'a> {
    pub actions: ActionContext<'a>,
    pub preferences: &'a Preferences,
    /// What is wrong with the file of the preferences.
    pub problem: Option<&'a str>,
}

pub fn show(
    context: &egui::Context,
    model: &Model,
    shown: SheetModel,
    state: &mut EditorState,
    commands: &mut Vec<Command>,
) {
    let Some(sheet) = state.sheet else {
        return;
    };
    let recent = &shown.preferences.recent_files;
    let stays = match sheet {
        Sheet::Palette => state.palette.show(context, model, &shown.actions, recent, commands),
        Sheet::Shortcuts => shortcuts(context),
        Sheet::Preferences => {
            let modal = Modal::new(Id::new("preferences")).show(context, |ui| {
                ui.set_width(400.0);
                ui.heading("Preferences");
                ui.add_space(6.0);
                preferences(ui, shown.preferences, shown.problem, commands);
                ui.add_space(6.0);
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    if ui
                        .button("Close")
                        .on_hover_text("They are kept as they are (Esc)")
                        .clicked()
                    {
                        ui.close();
                    }
                });
            });
            !modal.should_close()
        }
    };
    if !stays {
        state.sheet = None;
    }
}
