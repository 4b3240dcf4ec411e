//! The question before a large film is traced in full, and the progress of a full film that will be saved.

use bevy_egui::egui::{self, Align2, Area, Frame, Id, ProgressBar, Rect};

use super::question::{Answer, Question};
use crate::app::editor::command::{Command, RenderCommand};
use crate::app::editor::model::StatusModel;
use crate::app::editor::panels::status::{progress_of, roughly};
use crate::app::editor::session::full_film_question::FullFilmQuestion;

/// Shows the question if there is one.
pub fn question(context: &egui::Context, asked: &mut Option<FullFilmQuestion>, commands: &mut Vec<Command>) {
    let Some(question) = asked else {
        return;
    };
    let dialog = Question {
        id: "full film",
        width: 440.0,
        heading: "Render a film of this size?".to_owned(),
        answers: vec![
            Answer::primary("Render the full film", true)
                .does("the picture has all pixels of the film until the scene or the view changes.")
                .help("Enter")
                .on_enter(),
            Answer::cancel("Cancel", false).does("the picture keeps the pixels that the window shows."),
        ],
    };
    let answer = dialog.ask(context, |ui| {
        ui.label(question.text());
        ui.add_space(6.0);
    });
    if let Some(renders) = answer {
        let question = asked.take().filter(|_| renders);
        commands.extend(question.map(|question| RenderCommand::RenderFull(question.confirmed()).into()));
    }
}

/// Shows the progress of the full film that will be saved, and returns its place. `viewport` is the rectangle of the
/// picture's panel.
pub fn progress(
    context: &egui::Context,
    status: &StatusModel,
    viewport: Rect,
    commands: &mut Vec<Command>,
) -> Option<Rect> {
    let image = status.awaited_image.as_ref()?;
    let (done, left) = progress_of(&status.status, image.samples);
    let shown = Area::new(Id::new("full film progress"))
        .pivot(Align2::CENTER_BOTTOM)
        .fixed_pos(viewport.center_bottom() - egui::vec2(0.0, 16.0))
        .order(egui::Order::Foreground)
        .show(context, |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_width(320.0);
                let size = status.status.full_size;
                // The denoiser does not report its progress.
                let is_filtered = image.is_denoised && status.status.rests() && status.status.size == size;
                let does = if is_filtered { "Denoising" } else { "Rendering all" };
                ui.label(format!(
                    "{does} {} × {} pixels for {}",
                    size.x,
                    size.y,
                    image.file_name()
                ));
                ui.horizontal(|ui| {
                    let text = match left {
                        Some(seconds) => format!("{:.0} %, {} left", 100.0 * done, roughly(seconds)),
                        None => format!("{:.0} %", 100.0 * done),
                    };
                    if !is_filtered {
                        ui.add(ProgressBar::new(done).desired_width(240.0).text(text));
                    }
                    let cancel = ui
                        .button("Cancel")
                        .on_hover_text("Save nothing; the picture keeps the samples that it has");
                    if cancel.clicked() {
                        commands.push(RenderCommand::StopFull.into());
                    }
                });
            });
        });
    Some(shown.response.rect)
}
