//! The panel of the steps of the history; a click goes to a step.

use bevy_egui::egui::{self, Button, RichText, Ui};

use crate::app::editor::command::{Command, HistoryCommand};
use crate::app::editor::model::HistoryModel;

/// Shows the steps in a list; a click goes back or forward to the state after a step.
pub fn history(ui: &mut Ui, model: &HistoryModel, commands: &mut Vec<Command>) {
    let done = model.done.len();
    let steps = done + model.undone.len();
    let height = ui.spacing().interact_size.y;
    let changed = ui.data_mut(|data| {
        let before = data.get_temp_mut_or_default::<usize>(ui.id().with("step"));
        std::mem::replace(before, done) != done
    });
    let mut area = egui::ScrollArea::vertical().auto_shrink(false);
    if changed {
        // The present step is scrolled to the middle.
        let line = height + ui.spacing().item_spacing.y;
        area = area.vertical_scroll_offset((done as f32 * line - 0.5 * ui.available_height()).max(0.0));
    }
    // Only the visible lines are laid out: there may be a thousand.
    area.show_rows(ui, height, steps + 1, |ui, lines| {
        for step in lines {
            let label = match step.checked_sub(1) {
                None => "As opened",
                Some(place) if step <= done => &model.done[place],
                Some(place) => &model.undone[place - done],
            };
            let text = RichText::new(label);
            let text = if step > done { text.weak() } else { text };
            let size = egui::vec2(ui.available_width(), height);
            let line = Button::selectable(step == done, text).truncate().min_size(size);
            let response = ui.add(line);
            if response.on_hover_text(hint(step, done)).clicked() && step != done {
                commands.push(HistoryCommand::GoTo(step).into());
            }
        }
    });
}

fn hint(step: usize, done: usize) -> &'static str {
    match step.cmp(&done) {
        std::cmp::Ordering::Less => "Undo what came after it",
        std::cmp::Ordering::Equal => "The scene as it is now",
        std::cmp::Ordering::Greater => "Do it again, with all before it",
    }
}
