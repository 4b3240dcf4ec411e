//! Shows a material with nested ones as a tree, whose parts can be selected, wrapped and unwrapped.

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Align, Layout, Response, Sense, Ui, WidgetInfo, WidgetType};

use super::material_header::layers;
use crate::app::editor::command::Command;
use crate::app::editor::model::panel_textures::Ball;
use crate::app::editor::model::{InspectedMaterial, MaterialPlace, Model};
use crate::scene::Material;

/// The height of a row and the edge of its ball, in points.
const ROW: f32 = 22.0;
/// The indentation of a part relative to the part around it, in points.
const INDENT: f32 = 14.0;
/// The width of the button at the right, in points.
const BUTTON: f32 = 22.0;

/// The edited part: the selected one, or else the outermost with parameters of its own.
pub(crate) fn edited(parts: &[InspectedMaterial], chosen: Option<Entity>) -> Option<&InspectedMaterial> {
    let has_rows = |part: &&InspectedMaterial| !matches!(*part.material, Material::TwoSided);
    let found = parts.iter().find(|part| Some(part.entity) == chosen);
    found.or_else(|| parts.iter().find(has_rows)).or_else(|| parts.first())
}

/// Shows the tree and selects the clicked part.
pub(crate) fn material_tree(
    ui: &mut Ui,
    parts: &[InspectedMaterial],
    model: &Model,
    chosen: &mut Option<Entity>,
    commands: &mut Vec<Command>,
) {
    let shown = edited(parts, *chosen).map(|part| part.entity);
    ui.add_space(2.0);
    ui.scope(|ui| {
        ui.spacing_mut().item_spacing.y = 1.0;
        for part in parts {
            ui.push_id(&part.path, |ui| {
                let is_shown = Some(part.entity) == shown;
                if row(ui, part, is_shown, model, commands).clicked() {
                    *chosen = Some(part.entity);
                }
            });
        }
    });
}

fn row(ui: &mut Ui, part: &InspectedMaterial, is_shown: bool, model: &Model, commands: &mut Vec<Command>) -> Response {
    let text = text(part);
    let width = ui.available_width();
    let (rect, response) = ui.allocate_exact_size(egui::vec2(width, ROW), Sense::click());
    response.widget_info(|| WidgetInfo::selected(WidgetType::SelectableLabel, true, is_shown, &text));
    let visuals = ui.style().interact_selectable(&response, is_shown);
    if is_shown || response.hovered() {
        ui.painter().rect_filled(rect, 3.0, visuals.weak_bg_fill);
    }
    let left = rect.left() + 2.0 + INDENT * part.path.len() as f32;
    let ball = egui::Rect::from_min_size(egui::pos2(left, rect.top()), egui::Vec2::splat(ROW)).shrink(1.0);
    model.textures.paint_ball(ui, Ball::Material(part.entity), ball);
    let words = egui::Rect::from_min_max(
        egui::pos2(ball.right() + 5.0, rect.top()),
        rect.max - egui::vec2(BUTTON, 0.0),
    );
    let wrap = Some(egui::TextWrapMode::Truncate);
    let galley = egui::WidgetText::from(text.as_str()).into_galley(ui, wrap, words.width(), egui::TextStyle::Body);
    let at = egui::pos2(words.left(), words.center().y - 0.5 * galley.size().y);
    ui.painter().galley(at, galley, visuals.text_color());
    let corner = egui::Rect::from_min_max(egui::pos2(words.right(), rect.top()), rect.max);
    let layout = Layout::left_to_right(Align::Center);
    let mut menu = ui.new_child(egui::UiBuilder::new().max_rect(corner).layout(layout));
    menu.menu_button("\u{2026}", |ui| layers(ui, part, model, commands))
        .response
        .on_hover_text("Put it into another, or take it out");
    response
}

/// The text of a part: its role in the part around it, its kind, and for the outermost one its name if it has one.
fn text(part: &InspectedMaterial) -> String {
    let place = match part.place {
        MaterialPlace::Whole | MaterialPlace::Inside => "",
        MaterialPlace::Front => "front: ",
        MaterialPlace::Back => "back: ",
        MaterialPlace::First => "first: ",
        MaterialPlace::Second => "second: ",
    };
    let kind = part.material.info().label;
    match part.name == kind || part.place != MaterialPlace::Whole {
        true => format!("{place}{kind}"),
        false => format!("{place}{kind}, {}", part.name),
    }
}
