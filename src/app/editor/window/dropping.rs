//! Files dropped on the window.

use std::path::PathBuf;

use bevy::prelude::*;
use bevy::window::FileDragAndDrop;
use bevy_egui::egui::{self, Align2, Color32, FontId, Rect};

use crate::app::editor::command::asset_kind::FileUse;
use crate::app::editor::command::{Command, FileCommand, SceneEdit, ShellCommand};
use crate::app::editor::words::files::SCENE_FILES;

/// The files that hover over the window, and those that were dropped since the last frame.
#[derive(Resource, Debug, Default)]
pub struct DroppedFiles {
    pub hovering: usize,
    dropped: Vec<PathBuf>,
}

pub fn take_dropped_files(mut events: MessageReader<FileDragAndDrop>, mut files: ResMut<DroppedFiles>) {
    for event in events.read() {
        match event {
            FileDragAndDrop::HoveredFile { .. } => files.hovering += 1,
            FileDragAndDrop::HoveredFileCanceled { .. } => files.hovering = 0,
            FileDragAndDrop::DroppedFile { path_buf, .. } => {
                files.hovering = 0;
                files.dropped.push(path_buf.clone());
            }
        }
    }
}

impl DroppedFiles {
    /// The commands of a drop. A first scene is opened if none is open, and otherwise a single scene raises the
    /// question whether to open it; all other files are added to the scene. `untouched`: no file is open, and nothing
    /// was edited.
    pub fn commands(&mut self, untouched: bool) -> Vec<Command> {
        let is_scene = |path: &PathBuf| {
            let extension = path.extension().unwrap_or_default();
            SCENE_FILES.iter().any(|known| extension.eq_ignore_ascii_case(known))
        };
        let mut files = std::mem::take(&mut self.dropped);
        if !untouched {
            if let [scene] = &files[..]
                && is_scene(scene)
            {
                let file = FileUse {
                    path: scene.clone(),
                    at: None,
                    bounds: None,
                };
                return vec![Command::Shell(ShellCommand::AskAboutScene(Box::new(file)))];
            }
            return files.into_iter().map(|it| SceneEdit::Import(it).into()).collect();
        }
        let first = files.iter().position(is_scene).map(|place| files.remove(place));
        match first {
            // A scene replaces everything, so that the other files would be lost in it.
            Some(scene) => vec![Command::from(FileCommand::OpenScene(scene))],
            None => files.into_iter().map(|it| SceneEdit::Import(it).into()).collect(),
        }
    }
}

/// Shows the effect of a drop over the picture.
pub fn hint(context: &egui::Context, place: Rect) {
    let layer = egui::LayerId::new(egui::Order::Foreground, egui::Id::new("dropped files"));
    let painter = context.layer_painter(layer).with_clip_rect(place);
    painter.rect_filled(place, 0.0, Color32::from_black_alpha(140));
    let (font, text) = (FontId::proportional(20.0), "Drop to add it to the scene");
    painter.text(place.center(), Align2::CENTER_CENTER, text, font, Color32::WHITE);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dropped(names: &[&str], untouched: bool) -> Vec<Command> {
        let mut files = DroppedFiles {
            hovering: 0,
            dropped: names.iter().map(PathBuf::from).collect(),
        };
        let commands = files.commands(untouched);
        assert_eq!(files.commands(untouched), []);
        commands
    }

    #[test]
    fn a_scene_opens_where_there_is_none_and_is_asked_about_where_there_is() {
        let path = PathBuf::from("/room.GLB");
        assert_eq!(
            dropped(&["/room.GLB"], true),
            [Command::from(FileCommand::OpenScene(path.clone()))]
        );
        let (at, bounds) = (None, None);
        let file = Box::new(FileUse { path, at, bounds });
        let asked = Command::Shell(ShellCommand::AskAboutScene(file));
        assert_eq!(dropped(&["/room.GLB"], false), [asked]);
        let both = ["/room.GLB", "/a.ply"];
        let imports = both.map(|path| Command::from(SceneEdit::Import(path.into())));
        assert_eq!(dropped(&both, false), imports);
    }

    #[test]
    fn several_are_all_imported() {
        let [mesh, sky] = ["/bunny.ply", "/sky.hdr"].map(PathBuf::from);
        for untouched in [true, false] {
            let commands = dropped(&["/bunny.ply", "/sky.hdr"], untouched);
            assert_eq!(
                commands,
                [
                    Command::from(SceneEdit::Import(mesh.clone())),
                    Command::from(SceneEdit::Import(sky.clone()))
                ]
            );
        }
    }
}
