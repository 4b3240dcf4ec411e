//! The form for a bake over the window, the panel of the bake that is under way beside the picture, and the question before the window is closed meanwhile.

use bevy_egui::egui::{self, Align2, Area, Frame, Id, Modal, Rect, RichText, TextureHandle, TextureOptions};

use super::dialog;
use crate::app::editor::command::Command;
use crate::app::editor::command::baking::BakeCommand;
use crate::app::editor::model::baking::BakeModel;
use crate::app::editor::panels::baking::{BakeForm, form, progress};
use crate::app::editor::panels::look;

/// The width of the form, in points.
const WIDTH: f32 = 400.0;
/// The distance of the panel from the edges of the picture.
const MARGIN: f32 = 12.0;

/// The form, and the texture of the panel.
#[derive(Default)]
pub struct BakeWidgets {
    form: BakeForm,
    /// The texture of the lightmap, with the image that it was made of.
    picture: Option<(TextureHandle, std::sync::Arc<egui::ColorImage>)>,
}

impl BakeWidgets {
    /// Shows the form; false when it is to be closed.
    pub fn sheet(&mut self, context: &egui::Context, model: &BakeModel, commands: &mut Vec<Command>) -> bool {
        let modal = Modal::new(Id::new("bake")).show(context, |ui| {
            ui.set_width(WIDTH);
            ui.label(RichText::new("Bake lightmaps").heading().strong());
            ui.add_space(6.0);
            if form(ui, &mut self.form, model, commands) {
                ui.close();
            }
        });
        !modal.should_close()
    }

    /// Shows the bake that is under way. `viewport` is the rectangle of the picture's panel.
    pub fn panel(&mut self, context: &egui::Context, model: &BakeModel, viewport: Rect, commands: &mut Vec<Command>) {
        let Some(shown) = &model.shown else {
            self.picture = None;
            return;
        };
        self.update_picture(context, shown.news.picture.as_ref().map(|picture| &picture.image));
        Area::new(Id::new("bake under way"))
            .pivot(Align2::RIGHT_BOTTOM)
            .default_pos(viewport.right_bottom() - egui::vec2(MARGIN, MARGIN))
            .movable(true)
            .constrain_to(viewport)
            .order(egui::Order::Middle)
            .show(context, |ui| {
                Frame::popup(ui.style()).show(ui, |ui| {
                    let picture = self.picture.as_ref().map(|(texture, _)| texture);
                    progress(ui, shown, picture, commands);
                });
            });
    }

    /// Gives the texture the pixels of the image unless it has them.
    fn update_picture(&mut self, context: &egui::Context, image: Option<&std::sync::Arc<egui::ColorImage>>) {
        let Some(image) = image else {
            self.picture = None;
            return;
        };
        match &mut self.picture {
            Some((_, known)) if std::sync::Arc::ptr_eq(known, image) => {}
            Some((texture, known)) => {
                texture.set(image.clone(), TextureOptions::NEAREST);
                *known = image.clone();
            }
            None => {
                let texture = context.load_texture("lightmap", image.clone(), TextureOptions::NEAREST);
                self.picture = Some((texture, image.clone()));
            }
        }
    }
}

/// The question what to do with a bake that is under way. Closing the window waits until it is answered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BakeQuestion {
    /// Nothing is asked.
    #[default]
    None,
    /// It is asked.
    Asking,
    /// The window closes when the bake has ended.
    Waiting,
}

impl BakeQuestion {
    /// Whether the question is open and takes keys and mouse.
    pub fn is_asking(self) -> bool {
        self == Self::Asking
    }

    /// Holds back the command to quit while a bake is under way, and gives it when the bake has ended that was waited for.
    pub fn hold(&mut self, commands: &mut Vec<Command>, model: &BakeModel) {
        if !model.is_busy() {
            // A bake that failed is no longer shown, and leaves the window open.
            if std::mem::take(self) == Self::Waiting && model.shown.is_some() {
                commands.push(Command::Quit);
            }
        } else if commands.contains(&Command::Quit) {
            commands.retain(|command| *command != Command::Quit);
            *self = Self::Asking;
        }
    }

    /// Shows the question. To be called after [`Self::hold`] and after what else holds back the command to quit.
    pub fn show(&mut self, context: &egui::Context, commands: &mut Vec<Command>) {
        if !self.is_asking() {
            return;
        }
        let modal = dialog::question(context, "bake", 440.0, "Stop the bake?", |ui| {
            ui.label("Lightmaps are still being baked.");
            ui.add_space(6.0);
            dialog::consequence(ui, "Stop", "what there is is written, and then the window closes.");
            dialog::consequence(ui, "Discard", "nothing is written, and the window closes.");
            dialog::consequence(ui, "Cancel", "the bake goes on.");
            let (lose, stop) = (look::danger(ui, "Discard"), look::primary(ui, "Stop"));
            let (mut loses, mut stops, mut cancels) = (false, false, false);
            dialog::answers(
                ui,
                |ui| loses = ui.add(lose).clicked(),
                |ui| {
                    stops = ui.add(stop).clicked();
                    cancels = ui.button("Cancel").on_hover_text("Esc").clicked();
                },
            );
            if loses {
                commands.extend([Command::Bake(BakeCommand::Discard), Command::Quit]);
            } else if stops {
                commands.push(Command::Bake(BakeCommand::Stop));
            }
            if loses || cancels {
                ui.close();
            }
            stops
        });
        if modal.inner {
            *self = Self::Waiting;
        } else if modal.should_close() {
            *self = Self::None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::model::baking::ShownBake;

    fn bake(is_busy: bool) -> BakeModel {
        let shown = ShownBake {
            folder: "level".into(),
            news: Default::default(),
            is_stopped: false,
            is_busy,
            page: 0,
            view: Default::default(),
        };
        BakeModel {
            shown: Some(shown),
            ..BakeModel::default()
        }
    }

    #[test]
    fn the_window_closes_when_the_bake_has_ended() {
        let after = |question: &mut BakeQuestion, mut commands: Vec<Command>, model: &BakeModel| {
            question.hold(&mut commands, model);
            commands
        };
        let mut question = BakeQuestion::default();
        assert_eq!(
            after(&mut question, vec![Command::Quit], &BakeModel::default()),
            [Command::Quit]
        );
        assert_eq!(
            after(&mut question, vec![Command::Save, Command::Quit], &bake(true)),
            [Command::Save]
        );
        assert!(question.is_asking());
        question = BakeQuestion::Waiting;
        assert_eq!(after(&mut question, Vec::new(), &bake(true)), []);
        assert_eq!(after(&mut question, Vec::new(), &bake(false)), [Command::Quit]);
        assert_eq!(after(&mut question, Vec::new(), &bake(false)), []);
        // A bake that failed leaves it open.
        question = BakeQuestion::Waiting;
        assert_eq!(after(&mut question, Vec::new(), &BakeModel::default()), []);
        assert_eq!(question, BakeQuestion::None);
    }
}
