//! The list of the files of the scene that are missing, where each can be found by hand.

use bevy_egui::egui::{self, Align, Layout, RichText, ScrollArea, Ui};

use crate::app::editor::command::Command;
use crate::app::editor::command::shell::{ShellCommand, SoughtFile};
use crate::app::editor::model::MissingItem;

/// The largest height of the list, in points.
const HEIGHT: f32 = 320.0;

/// The state of the list while the window is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MissingForm {
    others: bool,
}

impl Default for MissingForm {
    fn default() -> Self {
        Self { others: true }
    }
}

/// Shows the list. Returns true when it is to be closed.
pub fn missing_files(
    ui: &mut Ui,
    form: &mut MissingForm,
    missing: &[MissingItem],
    commands: &mut Vec<Command>,
) -> bool {
    if missing.is_empty() {
        ui.label("All files of the scene are there.");
    } else {
        ui.label(
            "Boxes of lines stand in place of meshes, and grey in place of pictures. What you save keeps the names.",
        );
        ui.add_space(6.0);
        ScrollArea::vertical().max_height(HEIGHT).show(ui, |ui| {
            for (place, item) in missing.iter().enumerate() {
                ui.push_id(place, |ui| row(ui, *form, item, commands));
                ui.separator();
            }
        });
        ui.checkbox(&mut form.others, "Look in that folder for the others")
            .on_hover_text("When a file was found, the other missing files are looked for beside it, and where they lay relative to it");
    }
    ui.add_space(8.0);
    let mut closes = false;
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            closes = ui.button("Close").on_hover_text("Esc").clicked();
        });
    });
    closes
}

/// Shows the button that asks for a file. `others`: whether the other missing files are searched in its folder as well.
pub(super) fn find_button(ui: &mut Ui, item: &MissingItem, others: bool, commands: &mut Vec<Command>) {
    let button = ui.button("Find…").on_hover_text("Choose the file where it is now");
    if button.clicked() {
        commands.push(
            ShellCommand::FindFile(SoughtFile {
                kind: item.kind,
                path: item.path.clone(),
                others,
            })
            .into(),
        );
    }
}

fn row(ui: &mut Ui, form: MissingForm, item: &MissingItem, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            find_button(ui, item, form.others, commands);
            ui.with_layout(Layout::top_down(Align::LEFT), |ui| {
                let name = item.path.file_name().unwrap_or_default().to_string_lossy();
                ui.add(egui::Label::new(RichText::new(name).strong()).truncate());
                let folder = item.path.parent().unwrap_or(&item.path).display();
                ui.add(egui::Label::new(RichText::new(format!("{} in {folder}", item.kind)).weak()).truncate());
            });
        });
    });
}
