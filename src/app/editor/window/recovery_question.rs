//! The question about an autosave, and the list of all autosaves.

use bevy_egui::egui::{self, Button, Id, Modal, RichText, ScrollArea, Ui};

use super::dialog::{self, ROW};
use super::question::{Answer, Question};
use crate::app::editor::command::recovery_offer::Offer;
use crate::app::editor::command::{Command, ShellCommand};
use crate::app::editor::panels::look;
use crate::app::editor::session::recovery_words::{
    about_file, count_of, scene_of, short_names, time_and_age, time_of, times_of, with_age,
};

/// Asks what to do with an autosave; `offer` becomes None once it is answered. Returns true if the user postponed it.
pub fn question(context: &egui::Context, offer: &mut Option<Offer>, commands: &mut Vec<Command>) -> bool {
    let Some(asked) = offer else {
        return false;
    };
    let question = Question {
        id: "recovery",
        width: 460.0,
        heading: "Recover unsaved edits?".to_owned(),
        answers: vec![
            Answer::primary(
                recover_text(time_of(&asked.note).as_deref()),
                Some(ShellCommand::Recover(asked.clone())),
            )
            .named("Recover")
            .does("the scene opens with those edits. No file is changed until you save.")
            .help("Enter")
            .on_enter(),
            Answer::cancel("Later", None).does("the copy stays: File > Recover has it, and the next start names it."),
            Answer::danger("Discard", Some(ShellCommand::DiscardRecovery(asked.clone())))
                .does("the copy is deleted, and the edits are lost."),
        ],
    };
    let answer = question.ask(context, |ui| {
        ui.label(format!(
            "The program ended without saving the last edits of {}. A copy of them was written {}.",
            scene_of(asked),
            time_and_age(&asked.note)
        ));
        if let Some(file) = about_file(asked) {
            ui.add_space(4.0);
            ui.label(file);
        }
        ui.add_space(6.0);
    });
    let Some(answer) = answer else {
        return false;
    };
    *offer = None;
    let is_put_off = answer.is_none();
    commands.extend(answer.map(Command::Shell));
    is_put_off
}

/// The message after the question was postponed.
pub(crate) const PUT_OFF: &str = "The copy of the edits stays: File > Recover has it.";

/// Lists all autosaves; returns false when the list is to be closed.
pub fn list(context: &egui::Context, left: &[Offer], commands: &mut Vec<Command>) -> bool {
    let before = commands.len();
    let modal = dialog::form(context, Modal::new(Id::new("recovery list")), |ui| {
        ui.set_width(520.0);
        ui.label(RichText::new("Recover unsaved edits").heading().strong());
        ui.add_space(6.0);
        if left.is_empty() {
            ui.weak("There is nothing to recover.");
        }
        let height = ui.ctx().content_rect().height() - 160.0;
        ScrollArea::vertical().max_height(height).show(ui, |ui| {
            for (offer, time) in left.iter().zip(times_of(left)) {
                ui.separator();
                row(ui, offer, time, commands);
            }
        });
        ui.add_space(8.0);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.button("Close").on_hover_text("The copies stay (Esc)").clicked() {
                ui.close();
            }
        });
    });
    commands.len() == before && !modal.should_close()
}

fn row(ui: &mut Ui, offer: &Offer, time: Option<String>, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            ask_button(ui, Button::new("Recover…"), offer, commands);
            ui.with_layout(egui::Layout::top_down(egui::Align::Min), |ui| {
                ui.add(egui::Label::new(RichText::new(scene_of(offer)).strong()).wrap());
                ui.label(format!("Written {}", with_age(time, &offer.note)));
                if let Some(file) = about_file(offer) {
                    ui.add(egui::Label::new(RichText::new(file).weak()).wrap());
                }
            });
        });
    });
}

fn ask_button(ui: &mut Ui, button: Button, offer: &Offer, commands: &mut Vec<Command>) {
    if ui.add(button).on_hover_text(scene_of(offer)).clicked() {
        commands.push(ShellCommand::AskAboutRecovery(offer.clone()).into());
    }
}

/// The most autosaves that the start page lists.
const MOST_SHOWN: usize = 4;

/// The section of the start page about autosaves; nothing if there are none.
pub(super) fn on_start_page(ui: &mut Ui, left: &[Offer], commands: &mut Vec<Command>) {
    if left.is_empty() {
        return;
    }
    let color = ui.visuals().warn_fg_color;
    ui.label(RichText::new(count_of(left)).strong().color(color));
    let named = short_names(left).into_iter().zip(times_of(left)).zip(left);
    for (place, ((name, time), offer)) in named.take(MOST_SHOWN).enumerate() {
        let mut button = look::primary_if(ui, place == 0, &format!("Recover {name}"))
            .truncate()
            .min_size(egui::vec2(ui.available_width(), ROW));
        if let Some(clock) = time {
            let text = RichText::new(format!("of {clock}"));
            button = button.right_text(match place == 0 {
                true => text.color(look::ON_ACCENT),
                false => text.weak(),
            });
        }
        ask_button(ui, button, offer, commands);
    }
    if left.len() > MOST_SHOWN {
        let all = Button::new(format!("All {}…", left.len())).min_size(egui::vec2(ui.available_width(), ROW));
        if ui.add(all).clicked() {
            commands.push(ShellCommand::ShowRecovery.into());
        }
    }
    ui.add_space(8.0);
}

/// The text of the button, such as "Recover the copy of 14:32".
fn recover_text(clock: Option<&str>) -> String {
    match clock {
        Some(clock) => format!("Recover the copy of {clock}"),
        None => "Recover the copy".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_button_says_which_copy() {
        assert_eq!(recover_text(Some("14:32")), "Recover the copy of 14:32");
        assert_eq!(recover_text(None), "Recover the copy");
    }
}
