//! The list of everything in the scene; a click selects.

use bevy_egui::egui::{self, Ui};

use super::super::command::Command;
use super::super::model::{Item, Outline};
use super::super::selection::{Extend, Selection};

/// A line: a group's heading or one of its items.
enum Line<'a> {
    Group(&'static str, usize),
    Item(&'a Item),
}

pub fn outliner(
    ui: &mut Ui,
    outline: &Outline,
    selection: &Selection,
    filter: &mut String,
    commands: &mut Vec<Command>,
) {
    ui.add(
        egui::TextEdit::singleline(filter)
            .hint_text("Find")
            .desired_width(f32::INFINITY),
    );
    let lines = lines(outline, filter);
    let height = ui.spacing().interact_size.y;
    // Scenes of thousands of shapes are usual: only the lines in sight are laid out.
    egui::ScrollArea::vertical()
        .auto_shrink(false)
        .show_rows(ui, height, lines.len(), |ui, range| {
            for line in &lines[range] {
                match line {
                    Line::Group(name, count) => {
                        ui.horizontal(|ui| {
                            ui.set_min_height(height);
                            ui.strong(*name);
                            ui.weak(count.to_string());
                        });
                    }
                    Line::Item(item) => {
                        if item_line(ui, item, selection.contains(item.entity), height) {
                            commands.push(Command::Select(vec![item.entity], Extend::Replace));
                        }
                    }
                }
            }
        });
}

/// True when clicked.
fn item_line(ui: &mut Ui, item: &Item, selected: bool, height: f32) -> bool {
    ui.horizontal(|ui| {
        ui.add_space(8.0);
        let kind = egui::RichText::new(item.kind).weak().small();
        let size = egui::vec2(ui.available_width(), height);
        let line = egui::Button::selectable(selected, item.name.as_str())
            .right_text(kind)
            .truncate()
            .min_size(size);
        let response = ui.add(line);
        response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Button, true, selected, &item.name));
        response.clicked()
    })
    .inner
}

fn lines<'a>(outline: &'a Outline, filter: &str) -> Vec<Line<'a>> {
    let wanted = filter.trim().to_lowercase();
    let mut lines = Vec::new();
    let groups = [
        ("Shapes", &outline.shapes),
        ("Materials", &outline.materials),
        ("Lights", &outline.lights),
        ("Sensors", &outline.sensors),
    ];
    for (name, items) in groups {
        let matches = |item: &&Item| wanted.is_empty() || item.name.to_lowercase().contains(&wanted);
        let found: Vec<&Item> = items.iter().filter(matches).collect();
        if !found.is_empty() {
            lines.push(Line::Group(name, found.len()));
            lines.extend(found.into_iter().map(Line::Item));
        }
    }
    lines
}
