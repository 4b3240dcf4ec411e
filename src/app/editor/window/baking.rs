//! The form for a bake, the panel of a running bake, and the question before the window is closed during one.

use std::sync::Arc;

use bevy_egui::egui::{self, Id, Modal, RichText, TextureHandle, TextureOptions, Ui};

use super::dialog;
use super::question::{Answer, Question};
use crate::app::editor::command::panel::Panel;
use crate::app::editor::command::{BakeCommand, Command, FileCommand};
use crate::app::editor::model::baking::BakeModel;
use crate::app::editor::panels::baking::{BakeForm, form, no_bake, progress};
use crate::app::editor::panels::fields;
use crate::app::editor::session::layout::Layout;

/// The width of the form, in points.
const WIDTH: f32 = 400.0;

/// The form, and the state of the panel.
#[derive(Default)]
pub struct BakeWidgets {
    form: BakeForm,
    /// Whether a bake was shown in the last frame; None before the first one.
    was_there: Option<bool>,
    /// The panel that was in front before the panel of the bake opened.
    covered: Option<Panel>,
    /// The texture of the lightmap, with the image that it was made of.
    picture: Option<(TextureHandle, Arc<egui::ColorImage>)>,
}

impl BakeWidgets {
    /// Shows the form; returns false when it is to be closed.
    pub fn sheet(&mut self, context: &egui::Context, model: &BakeModel, commands: &mut Vec<Command>) -> bool {
        let modal = dialog::form(context, Modal::new(Id::new("bake form")), |ui| {
            ui.set_width(WIDTH);
            ui.label(RichText::new("Bake lightmaps").heading().strong());
            ui.add_space(6.0);
            if form(ui, &mut self.form, model, commands) {
                ui.close();
            }
        });
        !modal.should_close()
    }

    /// Opens the panel of the bake when a bake begins, and closes it when the bake is closed.
    pub fn follow(&mut self, layout: &mut Layout, model: &BakeModel) {
        let is_there = model.shown.is_some();
        let was_there = self.was_there.replace(is_there);
        if is_there && was_there != Some(true) {
            let before = layout.fronts();
            layout.show(Panel::Bake);
            let after = layout.fronts();
            self.covered = before.into_iter().find(|panel| !after.contains(panel));
        } else if !is_there && was_there != Some(false) {
            // In the first frame the panel may be open from the last run.
            let covered = self.covered.take().filter(|_| layout.fronts().contains(&Panel::Bake));
            layout.close(Panel::Bake);
            if let Some(covered) = covered {
                layout.bring_to_front(covered);
            }
        }
    }

    /// Shows the running bake, or the ended one.
    pub fn panel(&mut self, ui: &mut Ui, model: &BakeModel, commands: &mut Vec<Command>) {
        fields::leave_scroll_bar(ui);
        let Some(shown) = &model.shown else {
            self.picture = None;
            no_bake(ui, commands);
            return;
        };
        self.update_picture(ui.ctx(), shown.news.picture.as_ref().map(|picture| &picture.image));
        let picture = self.picture.as_ref().map(|(texture, _)| texture);
        progress(ui, shown, picture, commands);
    }

    /// Updates the pixels of the texture if the image has changed.
    fn update_picture(&mut self, context: &egui::Context, image: Option<&Arc<egui::ColorImage>>) {
        let Some(image) = image else {
            self.picture = None;
            return;
        };
        match &mut self.picture {
            Some((_, known)) if Arc::ptr_eq(known, image) => {}
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

/// The question what to do with a running bake. Closing the window waits until it is answered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BakeQuestion {
    /// Nothing is asked.
    #[default]
    None,
    /// It is asked.
    Asking,
    /// The window closes when the bake has written its result so far.
    Waiting,
    /// The window closes when the bake is discarded.
    Leaving,
}

impl BakeQuestion {
    /// Whether the question is open and takes keys and mouse.
    pub fn is_asking(self) -> bool {
        self == Self::Asking
    }

    /// Holds back the command to quit during a bake, and issues it when the awaited bake has ended. To be called before
    /// all other guards of the command to quit, such as the question about unsaved edits, which may hold it back again.
    pub fn hold(&mut self, commands: &mut Vec<Command>, model: &BakeModel) {
        if !model.is_busy() {
            let quits = match std::mem::take(self) {
                Self::None | Self::Asking => false,
                // A failed bake is no longer shown, and leaves the window open.
                Self::Waiting => model.shown.is_some(),
                Self::Leaving => true,
            };
            if quits && !commands.contains(&Command::from(FileCommand::Quit)) {
                commands.push(FileCommand::Quit.into());
            }
        } else if commands.contains(&Command::from(FileCommand::Quit)) {
            commands.retain(|command| *command != Command::from(FileCommand::Quit));
            if *self != Self::Leaving {
                *self = Self::Asking;
            }
        }
    }

    /// Shows the question. To be called after [`Self::hold`] and after the other guards of the command to quit.
    pub fn show(&mut self, context: &egui::Context, model: &BakeModel, commands: &mut Vec<Command>) {
        if !self.is_asking() {
            return;
        }
        let mut answers = vec![
            Answer::danger("Discard", Self::Leaving).does("nothing is written, and the window closes."),
            Answer::cancel("Cancel", Self::None).does("the bake goes on."),
        ];
        if model.can_stop() {
            let stop = Answer::primary("Stop", Self::Waiting)
                .does("the lightmaps are written with the samples that they have, and then the window closes.")
                .help("Enter")
                .on_enter();
            answers.insert(0, stop);
        }
        let question = Question {
            id: "bake",
            width: 440.0,
            heading: "Stop the bake?".to_owned(),
            answers,
        };
        let answer = question.ask(context, |ui| {
            ui.label("Lightmaps are still being baked.");
            ui.add_space(6.0);
        });
        *self = answer.unwrap_or(Self::Asking);
        // When the bake has ended, `hold` quits, ahead of the other questions.
        match self {
            Self::Leaving => commands.push(BakeCommand::Discard.into()),
            Self::Waiting => commands.push(BakeCommand::Stop.into()),
            Self::None | Self::Asking => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::model::baking::ShownBake;
    use crate::app::editor::window::unsaved_question::UnsavedQuestion;
    use crate::bake::files::Content;

    fn bake(is_busy: bool) -> BakeModel {
        let shown = ShownBake {
            folder: "level".into(),
            news: Default::default(),
            is_stopped: false,
            is_busy,
            page: 0,
            view: Default::default(),
            is_of_open_scene: true,
        };
        BakeModel {
            shown: Some(shown),
            ..BakeModel::default()
        }
    }

    #[test]
    fn the_panel_comes_with_a_bake_and_goes_with_it() {
        // The panel was open when the program ended.
        let mut layout = Layout::default();
        layout.show(Panel::Bake);
        let mut widgets = BakeWidgets::default();
        widgets.follow(&mut layout, &BakeModel::default());
        assert!(!layout.has(Panel::Bake));
        layout.show(Panel::History);
        for is_busy in [true, false] {
            widgets.follow(&mut layout, &bake(is_busy));
            assert!(layout.fronts().contains(&Panel::Bake));
        }
        widgets.follow(&mut layout, &BakeModel::default());
        assert!(!layout.has(Panel::Bake) && layout.fronts().contains(&Panel::History));
        // The user switches to another panel meanwhile, and closes this one.
        widgets.follow(&mut layout, &bake(true));
        layout.show(Panel::Inspector);
        layout.close(Panel::Bake);
        widgets.follow(&mut layout, &bake(true));
        assert!(!layout.has(Panel::Bake));
        widgets.follow(&mut layout, &BakeModel::default());
        assert!(layout.fronts().contains(&Panel::Inspector));
    }

    #[test]
    fn the_window_closes_when_the_bake_has_ended() {
        let after = |question: &mut BakeQuestion, mut commands: Vec<Command>, model: &BakeModel| {
            question.hold(&mut commands, model);
            commands
        };
        let mut question = BakeQuestion::default();
        assert_eq!(
            after(
                &mut question,
                vec![Command::from(FileCommand::Quit)],
                &BakeModel::default()
            ),
            [Command::from(FileCommand::Quit)]
        );
        assert_eq!(
            after(
                &mut question,
                vec![Command::from(FileCommand::Save), Command::from(FileCommand::Quit)],
                &bake(true)
            ),
            [Command::from(FileCommand::Save)]
        );
        assert!(question.is_asking());
        question = BakeQuestion::Waiting;
        assert_eq!(after(&mut question, Vec::new(), &bake(true)), []);
        assert_eq!(
            after(&mut question, Vec::new(), &bake(false)),
            [Command::from(FileCommand::Quit)]
        );
        assert_eq!(after(&mut question, Vec::new(), &bake(false)), []);
        // A failed bake leaves it open.
        question = BakeQuestion::Waiting;
        assert_eq!(after(&mut question, Vec::new(), &BakeModel::default()), []);
        assert_eq!(question, BakeQuestion::None);
    }

    /// Runs a frame of egui with a press at a place.
    fn frame(
        context: &egui::Context,
        question: &mut BakeQuestion,
        model: &BakeModel,
        click: Option<egui::Pos2>,
    ) -> (Vec<Command>, egui::FullOutput) {
        let mut commands = Vec::new();
        let button = |pos, pressed| egui::Event::PointerButton {
            pos,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        };
        let events = click.map(|pos| vec![egui::Event::PointerMoved(pos), button(pos, true), button(pos, false)]);
        let input = egui::RawInput {
            screen_rect: Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(800.0, 600.0))),
            events: events.unwrap_or_default(),
            ..Default::default()
        };
        let output = context.run_ui(input, |ui| question.show(&ui.ctx().clone(), model, &mut commands));
        (commands, output)
    }

    /// The middle of a button with this text, if it is shown.
    fn button(output: &egui::FullOutput, name: &str) -> Option<egui::Pos2> {
        fn texts(shape: &egui::Shape, name: &str, found: &mut Option<egui::Pos2>) {
            match shape {
                egui::Shape::Text(text) if text.galley.text() == name => {
                    *found = Some(text.visual_bounding_rect().center());
                }
                egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| texts(shape, name, found)),
                _ => {}
            }
        }
        let mut found = None;
        let shapes = output.shapes.iter();
        shapes.for_each(|shape| texts(&shape.shape, name, &mut found));
        found
    }

    #[test]
    fn edits_are_asked_for_after_the_bake_is_discarded() {
        let context = egui::Context::default();
        let (mut bakes, mut edits) = (BakeQuestion::default(), UnsavedQuestion::default());
        let mut hold = |bakes: &mut BakeQuestion, mut commands: Vec<Command>, model: &BakeModel| {
            bakes.hold(&mut commands, model);
            edits.hold(&mut commands, true);
            (commands, edits.is_asking())
        };
        assert_eq!(
            hold(&mut bakes, vec![Command::from(FileCommand::Quit)], &bake(true)),
            (Vec::new(), false)
        );
        // The size of a window is known after it was shown once.
        frame(&context, &mut bakes, &bake(true), None);
        let (_, output) = frame(&context, &mut bakes, &bake(true), None);
        assert!(button(&output, "Stop").is_none(), "there are no samples");
        let place = button(&output, "Discard");
        let (said, _) = frame(&context, &mut bakes, &bake(true), place);
        assert_eq!(said, [Command::Bake(BakeCommand::Discard)]);
        assert_eq!(bakes, BakeQuestion::Leaving);
        // While the command is on its way, nothing is asked again.
        assert_eq!(
            hold(&mut bakes, vec![Command::from(FileCommand::Quit)], &bake(true)),
            (Vec::new(), false)
        );
        assert_eq!(bakes, BakeQuestion::Leaving);
        assert_eq!(hold(&mut bakes, Vec::new(), &BakeModel::default()), (Vec::new(), true));
        assert_eq!(bakes, BakeQuestion::None);
    }

    #[test]
    fn a_bake_with_samples_can_be_stopped() {
        let context = egui::Context::default();
        let mut question = BakeQuestion::Asking;
        let mut model = bake(true);
        if let Some(shown) = &mut model.shown {
            shown.news.samples = 1;
        }
        frame(&context, &mut question, &model, None);
        let (_, output) = frame(&context, &mut question, &model, None);
        let (said, _) = frame(&context, &mut question, &model, button(&output, "Stop"));
        assert_eq!(said, [Command::Bake(BakeCommand::Stop)]);
        assert_eq!(question, BakeQuestion::Waiting);
        // A folder with a better level would not be overwritten.
        if let Some(shown) = &mut model.shown {
            shown.news.stays = Some(Content { samples: 64, probes: 2 });
        }
        question = BakeQuestion::Asking;
        frame(&context, &mut question, &model, None);
        let (_, output) = frame(&context, &mut question, &model, None);
        assert!(button(&output, "Stop").is_none() && button(&output, "Discard").is_some());
    }
}
