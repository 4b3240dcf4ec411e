//! The guards that hold back commands which would lose edits or results, above all the command to quit, until a
//! question is answered or work has ended.

use bevy_egui::egui;

use super::baking::BakeQuestion;
use super::late_quit::LateQuit;
use super::picture_question::PictureQuestion;
use super::unsaved_question::{UnsavedQuestion, UnsavedState};
use crate::app::editor::command::Command;
use crate::app::editor::model::Model;
use crate::app::editor::picture::awaited_image::EndedImage;
use crate::app::editor::session::kept_picture::KeptPictures;
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::toasts::Toasts;
use crate::app::editor::words::times::last_saved;

/// The guards, in their order: a command that one passes on may be held back by the next.
#[derive(Default)]
pub struct Guards {
    bake: BakeQuestion,
    image: LateQuit,
    edits: UnsavedQuestion,
    picture: PictureQuestion,
}

impl Guards {
    /// Whether a question is open and takes keys and mouse.
    pub fn is_asking(&self) -> bool {
        self.bake.is_asking() || self.edits.is_asking() || self.picture.is_asking()
    }

    /// Holds back commands of this frame, shows the questions, and adds the released commands. `ended`: the result of
    /// the last awaited image.
    pub fn apply(
        &mut self,
        context: &egui::Context,
        model: &Model,
        kept: &KeptPictures,
        ended: Option<&EndedImage>,
        requests: &mut Requests,
        toasts: &mut Toasts,
        commands: &mut Vec<Command>,
    ) {
        let status = &model.status;
        let edits = status.unsaved && !status.being_saved;
        self.bake.hold(commands, &model.bake);
        self.image.hold(commands, status.awaited_image.as_ref(), ended, toasts);
        self.edits.hold(commands, edits);
        let scene = status.scene.as_deref();
        let name = scene.and_then(std::path::Path::file_name);
        let saved = scene.filter(|_| self.edits.is_asking()).and_then(last_saved);
        let unsaved = UnsavedState {
            saved: saved.as_deref(),
            name: &name.map_or("the scene".into(), |name| name.to_string_lossy()),
            path: scene,
            edits,
            dialog_open: requests.dialog.is_some() || requests.save_question.is_some(),
            saves_handled: requests.saves_handled,
        };
        if self.edits.show(context, unsaved, commands) {
            // The question how to save them is obsolete.
            requests.save_question = None;
        }
        self.picture.hold(commands, kept.is_offered);
        self.picture.show(context, status.status.seconds, commands);
        self.bake.show(context, &model.bake, commands);
    }
}
