//! Shows the library of materials as a grid of balls: a click applies one to the selection, a drag to a shape in the
//! picture.

use bevy_egui::egui::{self, Rect, Sense, Ui, vec2};

use super::drag_start::is_drag_of;
use crate::app::editor::command::dragged::DraggedPreset;
use crate::app::editor::command::presets::Preset;
use crate::app::editor::command::{Command, MaterialEdit};
use crate::app::editor::model::Model;
use crate::app::editor::model::panel_textures::Ball;

/// The state that the panel keeps between frames.
#[derive(Clone, Debug, Default)]
pub struct LibraryState {
    filter: String,
    /// The library indices of the visible materials, so that they get pictures.
    pub in_sight: Vec<usize>,
}

/// The edge of a ball, and below the height of the name under it, in points.
const BALL: f32 = 64.0;
const NAME: f32 = 26.0;
const GAP: f32 = 6.0;

/// Shows the materials; they are dragged onto shapes or applied to the selection.
pub fn library(ui: &mut Ui, model: &Model, state: &mut LibraryState, commands: &mut Vec<Command>) {
    ui.add(
        egui::TextEdit::singleline(&mut state.filter)
            .hint_text("Find")
            .desired_width(f32::INFINITY),
    );
    let wanted = state.filter.trim().to_lowercase();
    let found: Vec<(usize, &Preset)> = model
        .presets
        .iter()
        .enumerate()
        .filter(|(_, preset)| preset.path().to_lowercase().contains(&wanted))
        .collect();
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        if found.is_empty() {
            ui.weak("No material is called so.");
        }
        for chunk in found.chunk_by(|(_, a), (_, b)| a.group == b.group) {
            ui.add_space(4.0);
            ui.strong(&chunk[0].1.group);
            ui.spacing_mut().item_spacing = vec2(GAP, GAP);
            ui.horizontal_wrapped(|ui| {
                for (place, preset) in chunk {
                    cell(ui, *place, preset, model, state, commands);
                }
            });
        }
    });
}

fn cell(
    ui: &mut Ui,
    place: usize,
    preset: &Preset,
    model: &Model,
    state: &mut LibraryState,
    commands: &mut Vec<Command>,
) {
    let (rect, response) = ui.allocate_exact_size(vec2(BALL, BALL + NAME), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, &preset.name));
    if !ui.is_rect_visible(rect) {
        return;
    }
    state.in_sight.push(place);
    let face = Rect::from_min_size(rect.min, vec2(BALL, BALL));
    model.textures.paint_ball(ui, Ball::Preset(place), face);
    if response.hovered() {
        let stroke = ui.visuals().selection.stroke;
        ui.painter().rect_stroke(face, 2.0, stroke, egui::StrokeKind::Inside);
    }
    name(ui, &preset.name, Rect::from_min_max(face.left_bottom(), rect.max));
    if is_drag_of(ui, &response) {
        egui::DragAndDrop::set_payload(ui.ctx(), DraggedPreset(preset.clone()));
    }
    if response.clicked() {
        let shapes = model.selected_shapes();
        if !shapes.is_empty() {
            let preset = Box::new(preset.clone());
            commands.push(MaterialEdit::UsePreset { preset, shapes }.into());
        }
    }
    response.on_hover_text("Click to give it to the selection, or drag it onto a shape in the picture");
}

/// Shows a name in at most two lines.
fn name(ui: &Ui, name: &str, place: Rect) {
    let mut job = egui::text::LayoutJob::simple(
        name.to_owned(),
        egui::TextStyle::Small.resolve(ui.style()),
        ui.visuals().text_color(),
        place.width(),
    );
    job.halign = egui::Align::Center;
    job.wrap.max_rows = 2;
    let galley = ui.painter().layout_job(job);
    ui.painter()
        .galley(place.center_top() + vec2(0.0, 2.0), galley, ui.visuals().text_color());
}
