//! Shows the sheet that covers the window until it is closed: the palette, the overview of keys, the preferences.

use bevy_egui::egui::{self, Id, Modal};

use super::palette::Palette;
use super::shortcuts::shortcuts;
use crate::app::editor::command::Command;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::shell::Sheet;
use crate::app::editor::input::actions::ActionContext;
use crate::app::editor::model::Model;
use crate::app::editor::panels::preferences::preferences;

/// The data of the sheets beside the model.
#[derive(Clone, Copy)]
pub struct SheetModel<'a> {
    pub actions: ActionContext<'a>,
    pub preferences: &'a Preferences,
    /// A problem with the file of the preferences.
    pub problem: Option<&'a str>,
}

pub fn show(
    context: &egui::Context,
    model: &Model,
    shown: SheetModel,
    sheet: &mut Option<Sheet>,
    palette: &mut Palette,
    commands: &mut Vec<Command>,
) {
    if *sheet != Some(Sheet::Palette) {
        // The palette opens without a query.
        *palette = Palette::default();
    }
    let Some(open) = *sheet else {
        return;
    };
    let recent = &shown.preferences.recent_files;
    let stays = match open {
        Sheet::Palette => palette.show(context, model, &shown.actions, recent, commands),
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
        *sheet = None;
    }
}
