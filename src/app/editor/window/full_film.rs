//! The question before a large film is traced in full, and the progress of a full film that is waited for to be saved.

use bevy_egui::egui::{self, Align2, Area, Frame, Id, ProgressBar, Rect};

use super::dialog;
use crate::app::editor::command::Command;
use crate::app::editor::model::StatusModel;
use crate::app::editor::panels::look;
use crate::app::editor::panels::status::{clock, progress_of};
use crate::app::editor::session::full_film_question::FullFilmQuestion;

/// The answer that renders it.
const RENDER: &str = "Render the full film";

/// Shows the question if there is one.
pub fn question(context: &egui::Context, asked: &mut Option<FullFilmQuestion>, commands: &mut Vec<Command>) {
    let Some(question) = asked else {
        return;
    };
    let modal = dialog::question(context, "full film", 440.0, "Render a film of this size?", |ui| {
        ui.label(question.text());
        ui.add_space(6.0);
        dialog::consequence(
            ui,
            RENDER,
            "the picture has all pixels of the film until the scene or the view changes.",
        );
        dialog::consequence(ui, "Cancel", "the picture keeps the pixels that the window shows.");
        let render = look::primary(ui, RENDER);
        let mut answer = dialog::is_entered(ui).then_some(true);
        dialog::answers(
            ui,
            |_| {},
            |ui| {
                if ui.add(render).on_hover_text("Enter").clicked() {
                    answer = Some(true);
                }
                if ui.button("Cancel").on_hover_text("Esc").clicked() {
                    answer = Some(false);
                }
            },
        );
        answer
    });
    let closed = modal.should_close();
    match modal.inner.or(closed.then_some(false)) {
        None => {}
        Some(false) => *asked = None,
        Some(true) => commands.extend(asked.take().map(|question| Command::RenderFull(question.confirmed()))),
    }
}

/// Shows the progress of the full film that will be saved. `viewport` is the rectangle of the picture's panel.
pub fn progress(context: &egui::Context, status: &StatusModel, viewport: Rect, commands: &mut Vec<Command>) {
    let Some(image) = &status.awaited_image else {
        return;
    };
    let (done, left) = progress_of(&status.status, image.samples);
    Area::new(Id::new("full film progress"))
        .pivot(Align2::CENTER_BOTTOM)
        .fixed_pos(viewport.center_bottom() - egui::vec2(0.0, 16.0))
        .order(egui::Order::Foreground)
        .show(context, |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                ui.set_width(320.0);
                let size = status.status.full_size;
                // The filter does not report its progress.
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
                        Some(seconds) => format!("{:.0} %, {} left", 100.0 * done, clock(seconds)),
                        None => format!("{:.0} %", 100.0 * done),
                    };
                    if !is_filtered {
                        ui.add(ProgressBar::new(done).desired_width(240.0).text(text));
                    }
                    let cancel = ui
                        .button("Cancel")
                        .on_hover_text("Save nothing; the picture keeps the samples that it has");
                    if cancel.clicked() {
                        commands.push(Command::StopFull);
                    }
                });
            });
        });
}
