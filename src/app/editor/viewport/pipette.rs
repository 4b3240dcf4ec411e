//! The pipette in the picture: while a field waits for a colour, a click takes that of the surface below the pointer.

use bevy_egui::egui::{Color32, CursorIcon, Key, Painter, PointerButton, Pos2, Response, Stroke, Ui, vec2};

use super::model::ViewportModel;
use crate::app::editor::camera::picking;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::input::pipette;
use crate::color::{Rgb, srgb_from_linear};

/// The instruction over the picture.
pub(super) const HINT: &str = "Click a surface to take its colour, without the light on it (Esc: never mind)";
/// The radius in points of the disk beside the pointer, which has the colour below it.
const RADIUS: f32 = 9.0;

/// Follows mouse and keys for a frame. Returns whether the pipette is in use, and nothing else may use them.
pub(super) fn follow(ui: &Ui, response: &Response, screen: &Screen, model: &ViewportModel) -> bool {
    if !pipette::is_waiting(ui.ctx()) {
        return false;
    }
    if model.presses.iter().any(|press| press.key == Key::Escape) || response.clicked_by(PointerButton::Secondary) {
        pipette::cancel(ui.ctx());
    } else if response.clicked_by(PointerButton::Primary)
        && let Some(pointer) = response.hover_pos().or(response.interact_pointer_pos())
        && let Some(color) = color(pointer, screen, model)
    {
        pipette::give(ui.ctx(), color);
    }
    response.clone().on_hover_cursor(CursorIcon::Crosshair);
    true
}

/// The colour in the picture at a point of the window.
fn color(at: Pos2, screen: &Screen, model: &ViewportModel) -> Option<Rgb> {
    if !screen.picture.contains(at) {
        return None;
    }
    let scene = model.packed.scene.as_ref();
    let ray = picking::narrowed(model.packed, &screen.ray(at));
    let hit = ray.and_then(|ray| picking::first_hit(model.packed, &ray, |_| false));
    let is_light = scene
        .zip(hit)
        .is_some_and(|(scene, (_, hit, _))| scene.slot(&hit).light.is_some());
    model.depths.color_at(screen.film(at), is_light)
}

/// Paints the colour below the pointer beside it.
pub(super) fn paint(ui: &Ui, painter: &Painter, screen: &Screen, model: &ViewportModel) {
    let pointer = ui.input(|input| input.pointer.hover_pos());
    let Some(pointer) = pointer.filter(|_| pipette::is_waiting(ui.ctx())) else {
        return;
    };
    if let Some(color) = color(pointer, screen, model) {
        let encoded = |channel: f32| (255.0 * srgb_from_linear(channel.clamp(0.0, 1.0))).round() as u8;
        let [red, green, blue] = color.to_array().map(encoded);
        let middle = pointer + vec2(18.0, 18.0);
        painter.circle_filled(middle, RADIUS, Color32::from_rgb(red, green, blue));
        painter.circle_stroke(middle, RADIUS + 1.0, Stroke::new(1.0, Color32::BLACK));
        painter.circle_stroke(middle, RADIUS, Stroke::new(1.0, Color32::WHITE));
    }
}
