//! The file dialog: one at a time, drawn inside the window.

use std::path::{Path, PathBuf};

use bevy::prelude::Resource;
use bevy_egui::egui;
use egui_file_dialog::{DialogState, FileDialog};

use super::late_enter::LateEnter;
use crate::app::editor::command::{Command, FileDialogKind};
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::toasts::Toasts;
use crate::app::editor::words::files::{ENVIRONMENTS, SCENE_FILES, extension};
use crate::render::tonemap::ToneMap;

#[derive(Resource, Default)]
pub struct Dialogs {
    open: Option<(FileDialogKind, FileDialog)>,
    /// The folder in which a picture was last saved.
    image_folder: Option<PathBuf>,
    /// The folder from which a picture was last taken.
    picture_folder: Option<PathBuf>,
    /// The folder from which something was last imported.
    import_folder: Option<PathBuf>,
    late_enter: LateEnter,
}

impl Dialogs {
    /// Opens the requested dialog, shows it, and turns a picked file into a command. `scene` is the file of the open scene.
    pub fn show(
        &mut self,
        context: &egui::Context,
        scene: Option<&Path>,
        tone_map: ToneMap,
        requests: &mut Requests,
        toasts: &mut Toasts,
        commands: &mut Vec<Command>,
    ) {
        let Some(wanted) = requests.dialog else {
            self.open = None;
            return;
        };
        if self.open.as_ref().is_none_or(|(kind, _)| *kind != wanted) {
            let beside_scene = scene
                .and_then(Path::parent)
                .filter(|folder| !folder.as_os_str().is_empty())
                .map(Path::to_path_buf);
            let examples = || Some(PathBuf::from("scenes")).filter(|folder| folder.is_dir());
            let before = match wanted {
                FileDialogKind::SaveImage => self.image_folder.clone(),
                FileDialogKind::OpenPicture { .. } | FileDialogKind::OpenEnvironment => self.picture_folder.clone(),
                FileDialogKind::Import => self.import_folder.clone(),
                FileDialogKind::OpenScene | FileDialogKind::SaveScene => None,
            };
            let start = before.or(beside_scene).or_else(examples).unwrap_or_else(|| ".".into());
            let dialog = opened(wanted, scene, tone_map, &start);
            self.open = Some((wanted, dialog));
        }
        let Some((kind, dialog)) = &mut self.open else {
            return;
        };
        // The dialog itself would let its text field have the first one.
        if context.input(|input| input.key_pressed(egui::Key::Escape)) {
            self.open = None;
            requests.dialog = None;
            return;
        }
        self.late_enter.hold_back(context);
        dialog.update(context);
        if let Some(path) = dialog.take_picked() {
            let folder = path.parent().map(Path::to_path_buf);
            match kind {
                FileDialogKind::SaveImage => self.image_folder = folder,
                FileDialogKind::OpenPicture { .. } | FileDialogKind::OpenEnvironment => self.picture_folder = folder,
                FileDialogKind::Import => self.import_folder = folder,
                FileDialogKind::OpenScene | FileDialogKind::SaveScene => {}
            }
            match picked(*kind, path) {
                Ok(command) => commands.push(command),
                Err(message) => toasts.reject(message),
            }
            requests.dialog = None;
        } else if *dialog.state() != DialogState::Open {
            requests.dialog = None;
        }
    }
}

/// The command of a finished dialog; a message if the file is of another kind.
fn picked(kind: FileDialogKind, path: PathBuf) -> Result<Command, String> {
    Ok(match kind {
        FileDialogKind::OpenScene => Command::OpenScene(path),
        FileDialogKind::SaveScene => Command::SaveScene(path),
        FileDialogKind::SaveImage => Command::SaveImage(path),
        FileDialogKind::OpenEnvironment if !ENVIRONMENTS.contains(&extension(&path).as_str()) => {
            let known = ENVIRONMENTS.join(", ");
            return Err(format!(
                "{}: not a picture for an environment ({known})",
                path.display()
            ));
        }
        FileDialogKind::Import | FileDialogKind::OpenEnvironment => Command::Import(path),
        FileDialogKind::OpenPicture {
            owner,
            parameter,
            place,
        } => Command::SetPicture {
            owner,
            parameter,
            place,
            path,
        },
    })
}

/// The extensions that can be imported, beside those of scenes.
const IMPORTS: [&str; 5] = ["obj", "ply", "serialized", "hdr", "exr"];
const PICTURES: [&str; 10] = ["png", "jpg", "jpeg", "exr", "hdr", "pfm", "bmp", "tga", "ppm", "pgm"];

fn opened(kind: FileDialogKind, scene: Option<&Path>, tone_map: ToneMap, start: &Path) -> FileDialog {
    let start = std::path::absolute(start).unwrap_or_else(|_| start.to_path_buf());
    let dialog = FileDialog::new()
        .default_size([720.0, 460.0])
        .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
        .initial_directory(start);
    match kind {
        FileDialogKind::OpenScene => {
            let mut dialog = dialog
                .title("Open a scene")
                .add_file_filter_extensions("Scenes (xml, glb, gltf)", SCENE_FILES.to_vec())
                .default_file_filter("Scenes (xml, glb, gltf)");
            dialog.pick_file();
            dialog
        }
        FileDialogKind::Import => {
            let known: Vec<&str> = IMPORTS.iter().chain(&SCENE_FILES).copied().collect();
            let mut dialog = dialog
                .title("Import a mesh, a scene or an environment")
                .add_file_filter_extensions("Meshes, scenes, environments", known)
                .default_file_filter("Meshes, scenes, environments");
            dialog.pick_file();
            dialog
        }
        FileDialogKind::OpenEnvironment => {
            let mut dialog = dialog
                .title("Choose an environment map")
                .add_file_filter_extensions("Environment maps", ENVIRONMENTS.to_vec())
                .default_file_filter("Environment maps");
            dialog.pick_file();
            dialog
        }
        FileDialogKind::OpenPicture { .. } => {
            let mut dialog = dialog
                .title("Choose a picture")
                .add_file_filter_extensions("Pictures", PICTURES.to_vec())
                .default_file_filter("Pictures");
            dialog.pick_file();
            dialog
        }
        FileDialogKind::SaveScene => {
            let mut dialog = dialog
                .title("Save the scene")
                .add_save_extension("Scene", "xml")
                .default_save_extension("Scene")
                .default_file_name(&proposed_name(scene, "scene", "xml"));
            dialog.save_file();
            dialog
        }
        FileDialogKind::SaveImage => {
            let mut dialog = dialog
                .title(&format!("Save the picture (PNG: tone map {})", tone_map.name()))
                .add_save_extension("PNG, as shown", "png")
                .add_save_extension("EXR, linear", "exr")
                .add_save_extension("HDR, linear", "hdr")
                .default_save_extension("PNG, as shown")
                .default_file_name(&proposed_name(scene, "picture", "png"));
            dialog.save_file();
            dialog
        }
    }
}

/// The name of the scene's file with this extension; `otherwise` without a scene.
fn proposed_name(scene: Option<&Path>, otherwise: &str, extension: &str) -> String {
    let stem = scene
        .and_then(Path::file_stem)
        .map_or(otherwise.into(), |stem| stem.to_string_lossy());
    format!("{stem}.{extension}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_environment_is_a_picture() {
        let chosen = |path: &str| picked(FileDialogKind::OpenEnvironment, path.into());
        assert!(chosen("room.xml").is_err() && chosen("room").is_err());
        assert_eq!(chosen("sky.HDR"), Ok(Command::Import("sky.HDR".into())));
        let imported = picked(FileDialogKind::Import, "room.xml".into());
        assert_eq!(imported, Ok(Command::Import("room.xml".into())));
    }

    #[test]
    fn files_are_named_after_the_scene() {
        let scene = Path::new("scenes/cornell-box.xml");
        assert_eq!(proposed_name(Some(scene), "picture", "png"), "cornell-box.png");
        assert_eq!(proposed_name(None, "scene", "xml"), "scene.xml");
    }
}
