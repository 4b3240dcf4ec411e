//! The step of the tutorial over the lower left corner of the picture.

use bevy_egui::egui::{self, Align2, Button, Id, Rect, RichText};

use crate::app::editor::command::{Command, ShellCommand};
use crate::app::editor::panels::look;
use crate::app::editor::session::tutorial::{LESSONS, Tutorial};

const WIDTH: f32 = 300.0;

/// Shows the present step, if there is one. `place` is the rectangle of the picture's panel.
pub fn show(context: &egui::Context, tutorial: &Tutorial, place: Rect, commands: &mut Vec<Command>) {
    let Some((step, lesson)) = tutorial.step.and_then(|step| Some((step, LESSONS.get(step)?))) else {
        return;
    };
    let is_done = tutorial.done[step];
    let is_last = step + 1 == LESSONS.len();
    let mut go_to = |step: Option<usize>| commands.push(ShellCommand::ShowTutorial(step).into());
    let corner = place.left_bottom() + egui::vec2(12.0, -12.0);
    egui::Area::new(Id::new("tutorial"))
        .pivot(Align2::LEFT_BOTTOM)
        .fixed_pos(corner)
        .show(context, |ui| {
            egui::Frame::window(ui.style()).show(ui, |ui| {
                ui.set_width(WIDTH);
                ui.horizontal(|ui| {
                    ui.label(RichText::new(format!("{} of {}: {}", step + 1, LESSONS.len(), lesson.title)).strong());
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        if ui
                            .small_button("Leave")
                            .on_hover_text("It can be begun again in the menu Window")
                            .clicked()
                        {
                            go_to(None);
                        }
                    });
                });
                ui.label(lesson.text);
                ui.horizontal(|ui| {
                    if ui.add_enabled(step > 0, Button::new("Back")).clicked() {
                        go_to(step.checked_sub(1));
                    }
                    let next = match (is_last, is_done) {
                        (true, true) => "Finish",
                        (true, false) => "Finish without it",
                        (false, true) => "Next",
                        (false, false) => "Skip",
                    };
                    if ui.add(look::primary_if(ui, is_done, next)).clicked() {
                        go_to((!is_last).then_some(step + 1));
                    }
                    if is_done {
                        ui.label(RichText::new("Done").strong());
                    }
                });
            });
        });
}
