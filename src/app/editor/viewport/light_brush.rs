//! The tool that paints the light you want: a brush over the picture.

use std::f32::consts::PI;

use bevy::math::Vec2;
use bevy_egui::egui::{self, Color32, Painter, PointerButton, Pos2, Response, Shape, Ui};

use super::gizmo::interaction::Rest;
use super::model::ViewportModel;
use super::over_picture::is_over;
use super::tool::ViewportTool;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::light_paint::MOST_CORNERS;
use crate::app::editor::command::{Command, LightPaintCommand};
use crate::app::editor::input::press::Press;
use crate::inverse_lighting::{Stroke, Wish};
use crate::render::view::View;

/// The distance between corners of a path, in radii of the brush.
const STEP: f32 = 0.15;

/// The opacity of strokes over the picture, of 255.
const TINT: u8 = 48;

/// The state of the brush.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightBrushState {
    /// The strokes with the one that is being painted; None between strokes.
    held: Option<Vec<Stroke>>,
}

impl LightBrushState {
    /// Whether a stroke is being painted.
    pub(crate) fn is_busy(&self) -> bool {
        self.held.is_some()
    }

    /// Ends a stroke.
    pub(super) fn leave(&mut self) {
        self.held = None;
    }
}

impl ViewportTool for LightBrushState {
    fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        screen: &Screen,
        model: &ViewportModel,
        presses: &[Press],
        commands: &mut Vec<Command>,
    ) -> Rest {
        let rest = |pointer| Rest {
            pointer,
            presses: presses.to_vec(),
        };
        let Some(painting) = model.painting else {
            return rest(true);
        };
        let (pointer, pressed, down, alt) = ui.input(|input| {
            let pressed = input.pointer.button_pressed(PointerButton::Primary);
            let origin = input.pointer.press_origin().filter(|_| pressed);
            let latest = input.pointer.latest_pos().unwrap_or(screen.picture.center());
            let down = input.pointer.button_down(PointerButton::Primary);
            (origin.unwrap_or(latest), pressed, down, input.modifiers.alt)
        });
        let place = film_place(screen, model, pointer);
        if self.held.is_none() && pressed && !alt && is_over(ui, response) {
            // What is wanted of another view is not shown, and goes.
            let mut strokes = match painting.is_elsewhere {
                true => Vec::new(),
                false => painting.strokes.to_vec(),
            };
            strokes.push(painting.brush.stroke(vec![place]));
            commands.push(LightPaintCommand::SetStrokes(strokes.clone()).into());
            self.held = Some(strokes);
            return rest(false);
        }
        let Some(strokes) = &mut self.held else {
            return rest(!pressed || alt);
        };
        if !down {
            self.held = None;
            return rest(false);
        }
        if let Some(stroke) = strokes.last_mut()
            && let Some(&last) = stroke.path.last()
        {
            let moved = (place - last) * Vec2::new(aspect(screen, model), 1.0);
            if moved.length() > STEP * stroke.radius && stroke.path.len() < MOST_CORNERS {
                stroke.path.push(place);
                commands.push(LightPaintCommand::SetStrokes(strokes.clone()).into());
            }
        }
        rest(false)
    }

    fn paint(&self, painter: &Painter, screen: &Screen, model: &ViewportModel, pointer: Option<Pos2>) {
        let Some(painting) = model.painting else { return };
        if !painting.is_elsewhere {
            for stroke in painting.strokes.iter() {
                paint_stroke(painter, screen, model, stroke);
            }
        }
        if let Some(pointer) = pointer.filter(|pointer| screen.picture.contains(*pointer)) {
            let radius = painting.brush.radius * film_height(screen, model);
            painter.circle_stroke(pointer, radius, egui::Stroke::new(2.5, Color32::from_black_alpha(120)));
            painter.circle_stroke(pointer, radius, egui::Stroke::new(1.2, color(painting.brush.wish)));
        }
    }
}

/// The corners of the film in the picture.
fn corners(model: &ViewportModel) -> [Vec2; 2] {
    let view = model.packed.view.as_ref();
    view.map_or(View::WHOLE_FILM, View::film_corners)
}

/// The place in the film of a point of the window.
fn film_place(screen: &Screen, model: &ViewportModel, at: Pos2) -> Vec2 {
    let [least, most] = corners(model);
    (screen.film(at) - least) / (most - least)
}

fn film_height(screen: &Screen, model: &ViewportModel) -> f32 {
    let [least, most] = corners(model);
    (most.y - least.y) * screen.picture.height()
}

/// Width by height of the film.
fn aspect(screen: &Screen, model: &ViewportModel) -> f32 {
    let [least, most] = corners(model);
    let size = most - least;
    size.x * screen.picture.width() / (size.y * screen.picture.height())
}

fn paint_stroke(painter: &Painter, screen: &Screen, model: &ViewportModel, stroke: &Stroke) {
    let [least, most] = corners(model);
    let points = stroke
        .path
        .iter()
        .map(|&place| screen.point_of_film(least + place * (most - least)));
    let points: Vec<Pos2> = points.collect();
    let radius = stroke.radius * film_height(screen, model);
    let color = color(stroke.wish);
    let tint = Color32::from_rgba_unmultiplied(color.r(), color.g(), color.b(), TINT);
    // What overlaps would be tinted twice: the line has half disks at its ends.
    match points[..] {
        [point] => {
            painter.circle_filled(point, radius, tint);
        }
        [first, second, ..] => {
            painter.add(Shape::line(points.clone(), egui::Stroke::new(2.0 * radius, tint)));
            painter.add(half_disk(first, first - second, radius, tint));
            if let [.., before, last] = points[..] {
                painter.add(half_disk(last, last - before, radius, tint));
            }
        }
        [] => {}
    }
    painter.add(Shape::line(points, egui::Stroke::new(1.0, color)));
}

/// The half of a disk in a direction from its middle.
fn half_disk(middle: Pos2, towards: egui::Vec2, radius: f32, color: Color32) -> Shape {
    const STEPS: usize = 16;
    let angle = |step: usize| towards.angle() + PI * (step as f32 / STEPS as f32 - 0.5);
    let rim = (0..=STEPS).map(|step| middle + radius * egui::Vec2::angled(angle(step)));
    Shape::convex_polygon(rim.collect(), color, egui::Stroke::NONE)
}

/// The colour in which strokes of a wish are drawn.
fn color(wish: Wish) -> Color32 {
    match wish {
        Wish::Brighter(_) => Color32::from_rgb(255, 225, 110),
        Wish::Darker(_) => Color32::from_rgb(90, 120, 255),
        Wish::Luminance(_) | Wish::Illuminance(_) => Color32::from_rgb(120, 255, 150),
        Wish::Color(color) => {
            let level = color / color.max_element().max(f32::MIN_POSITIVE);
            let [r, g, b] = level
                .to_array()
                .map(|linear| (255.0 * crate::color::srgb_from_linear(linear)) as u8);
            Color32::from_rgb(r, g, b)
        }
        Wish::Keep => Color32::from_gray(220),
    }
}
