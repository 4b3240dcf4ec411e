//! The file dialog: one at a time, drawn inside the window.

use std::path::Path;

use bevy::prelude::Resource;
use bevy_egui::egui;
use egui_file_dialog::{DialogState, FileDialog};

use super::command::{Command, FileDialogKind};
use super::state::EditorState;
use super::ui::picked;

#[derive(Resource, Default)]
pub struct Dialogs {
    open: Option<(FileDialogKind, FileDialog)>,
}

impl Dialogs {
    /// Opens what `state.dialog` asks for, shows it, and turns a picked file into a command.
    pub fn show(&mut self, context: &egui::Context, state: &mut EditorState, commands: &mut Vec<Command>) {
        let Some(wanted) = state.dialog else {
            self.open = None;
            return;
        };
        if self.open.as_ref().is_none_or(|(kind, _)| *kind != wanted) {
            self.open = Some((wanted, opened(wanted)));
        }
        let Some((kind, dialog)) = &mut self.open else {
            return;
        };
        dialog.update(context);
        if let Some(path) = dialog.take_picked() {
            commands.push(picked(*kind, path));
            state.dialog = None;
        } else if *dialog.state() != DialogState::Open {
            state.dialog = None;
        }
    }
}

fn opened(kind: FileDialogKind) -> FileDialog {
    let scenes = Path::new("scenes");
    let start = if scenes.is_dir() { scenes } else { Path::new(".") };
    let start = std::path::absolute(start).unwrap_or_else(|_| start.to_path_buf());
    let dialog = FileDialog::new()
        .default_size([720.0, 460.0])
        .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
        .initial_directory(start);
    match kind {
        FileDialogKind::OpenScene => {
            let mut dialog = dialog
                .title("Open a scene")
                .add_file_filter_extensions("Scenes (xml)", vec!["xml"])
                .default_file_filter("Scenes (xml)");
            dialog.pick_file();
            dialog
        }
        FileDialogKind::SaveScene => {
            let mut dialog = dialog
                .title("Save the scene")
                .add_save_extension("Scene", "xml")
                .default_save_extension("Scene")
                .default_file_name("scene.xml");
            dialog.save_file();
            dialog
        }
        FileDialogKind::SaveImage => {
            let mut dialog = dialog
                .title("Save the picture")
                .add_save_extension("PNG, as shown", "png")
                .add_save_extension("EXR, linear", "exr")
                .add_save_extension("HDR, linear", "hdr")
                .default_save_extension("PNG, as shown")
                .default_file_name("picture.png");
            dialog.save_file();
            dialog
        }
    }
}
