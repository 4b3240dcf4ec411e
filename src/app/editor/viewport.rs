//! The picture in its panel, what is drawn over it, and the mouse and keys that act on it.

use std::time::Duration;

use bevy::math::{Affine3A, Vec2, Vec3};
use bevy_egui::egui::{
    self, Align2, Color32, EventFilter, FontId, Id, MouseWheelUnit, PointerButton, Pos2, Rect, Response, Sense, Shape,
    Stroke, Ui,
};

use super::actions::ActionContext;
use super::command::Command;
use super::display::{DisplayMode, HOTTEST_STEPS, heat};
use super::keys::{self, Press};
use super::material_drop::drop_target;
use super::navigation::{FlyInput, Navigation};
use super::overlay::{BoxList, MAX_BOXES, WorldBox, edges};
use super::selection::Extend;
use crate::render::camera::Camera;

/// What the viewport shows.
#[derive(Clone, Copy, Debug)]
pub struct ViewportModel<'a> {
    /// The picture and its size in pixels.
    pub picture: Option<(egui::TextureId, [u32; 2])>,
    /// In place of the picture while there is none.
    pub placeholder: &'a str,
    /// World from camera; None without a camera.
    pub pose: Option<Affine3A>,
    /// The camera of the picture, to draw over it.
    pub camera: Option<Camera>,
    pub boxes: &'a BoxList,
    pub selection_box: Option<WorldBox>,
    pub navigation: Navigation,
    pub keys: ActionContext<'a>,
    /// The keys pressed since the last frame, in order.
    pub presses: &'a [Press],
    /// False while a dialog is open: then neither keys nor mouse act on the picture.
    pub enabled: bool,
}

/// What the viewport remembers between frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewportState {
    flying: bool,
}

/// The id of the picture: whatever has the keyboard when no other widget wants it.
pub const PICTURE: &str = "viewport picture";
/// A point drag of the wheel counts as a notch after so many points.
const POINTS_PER_NOTCH: f32 = 50.0;
const SELECTION: Color32 = Color32::from_rgb(255, 160, 40);
const SCENE_BOX: Color32 = Color32::from_rgba_premultiplied(60, 200, 90, 200);
const MESH_BOX: Color32 = Color32::from_rgba_premultiplied(60, 130, 230, 160);

pub fn viewport(ui: &mut Ui, model: &ViewportModel, state: &mut ViewportState, commands: &mut Vec<Command>) {
    let panel = ui.available_rect_before_wrap();
    ui.painter().rect_filled(panel, 0.0, Color32::from_gray(18));
    let picture = model.picture.map_or(panel, |(_, size)| fitted(panel, size));
    let response = ui.interact(picture, Id::new(PICTURE), Sense::click_and_drag());
    match model.picture {
        Some((texture, _)) => {
            let uv = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            ui.painter().image(texture, picture, uv, Color32::WHITE);
        }
        None => {
            let font = FontId::proportional(16.0);
            ui.painter().text(
                panel.center(),
                Align2::CENTER_CENTER,
                model.placeholder,
                font,
                Color32::GRAY,
            );
        }
    }
    paint_over(ui, picture, model);
    act(ui, &response, picture, model, state, commands);
    drop_target(ui, &response, picture, commands);
    ui.advance_cursor_after_rect(panel);
}

/// The largest rectangle of the picture's proportions in the middle of the panel, on whole points so that pixels stay sharp.
fn fitted(panel: Rect, [width, height]: [u32; 2]) -> Rect {
    let size = egui::vec2(width.max(1) as f32, height.max(1) as f32);
    let scale = (panel.width() / size.x).min(panel.height() / size.y);
    let fitted = (size * scale).floor();
    Rect::from_min_size((panel.center() - 0.5 * fitted).floor(), fitted)
}

fn act(
    ui: &Ui,
    response: &Response,
    picture: Rect,
    model: &ViewportModel,
    state: &mut ViewportState,
    commands: &mut Vec<Command>,
) {
    let has_keyboard = takes_keyboard(ui, response, model.enabled);
    let looking =
        model.enabled && (response.dragged_by(PointerButton::Secondary) || response.dragged_by(PointerButton::Primary));
    if model.enabled
        && response.clicked_by(PointerButton::Primary)
        && let Some(position) = response.interact_pointer_pos()
    {
        let film = (position - picture.min) / picture.size();
        commands.push(Command::Pick(Vec2::new(film.x, film.y), Extend::Replace));
    }
    let was_flying = std::mem::take(&mut state.flying);
    let (fly, notches) = ui.input(|input| {
        let modifiers = input.modifiers;
        // Control with a letter is a shortcut, unless the user is flying already.
        let keys_fly = has_keyboard && !modifiers.alt && (!modifiers.command || looking || was_flying);
        let look = if looking {
            input.pointer.delta()
        } else {
            egui::Vec2::ZERO
        };
        let notches = if response.hovered() || looking {
            wheel(input)
        } else {
            0.0
        };
        let fly = FlyInput {
            direction: if keys_fly {
                keys::fly_direction(input)
            } else {
                Vec3::ZERO
            },
            look: Vec2::new(look.x, look.y),
            dolly: 0.0,
            fast: modifiers.shift,
            slow: modifiers.command,
            seconds: input.unstable_dt,
        };
        (fly, notches)
    });
    let changes_speed = ui.input(|input| input.pointer.secondary_down());
    if notches != 0.0 && changes_speed && model.enabled {
        commands.push(Command::SetSpeed(model.navigation.speed_after(notches)));
    }
    let fly = FlyInput {
        dolly: if changes_speed || !model.enabled { 0.0 } else { notches },
        ..fly
    };
    state.flying = looking || fly.direction != Vec3::ZERO;
    if let Some(pose) = model.pose.and_then(|pose| model.navigation.fly(pose, &fly)) {
        commands.push(Command::MoveView(pose));
    }
    if state.flying {
        // Time passes without further events while a key is held.
        ui.ctx().request_repaint_after(Duration::from_millis(16));
    }
    if has_keyboard {
        let context = ActionContext {
            flying: state.flying || was_flying,
            ..model.keys
        };
        commands.extend(keys::shortcuts(model.presses, &context));
    }
}

/// The picture has the keyboard whenever no other widget wants it, and then it keeps Tab, arrows and Escape to itself. Without `enabled`
/// it lets go of it.
fn takes_keyboard(ui: &Ui, response: &Response, enabled: bool) -> bool {
    if !enabled || ui.ctx().any_popup_open() {
        response.surrender_focus();
        return false;
    }
    let focused = ui.memory(|memory| memory.focused());
    if focused.is_none() || response.is_pointer_button_down_on() {
        response.request_focus();
    }
    let filter = EventFilter {
        tab: true,
        horizontal_arrows: true,
        vertical_arrows: true,
        escape: true,
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    response.has_focus()
}

/// Notches of the wheel this frame, positive away from the user.
fn wheel(input: &egui::InputState) -> f32 {
    let notches = |event: &egui::Event| match event {
        egui::Event::MouseWheel { unit, delta, .. } => match unit {
            MouseWheelUnit::Point => delta.y / POINTS_PER_NOTCH,
            MouseWheelUnit::Line => delta.y,
            MouseWheelUnit::Page => 10.0 * delta.y,
        },
        _ => 0.0,
    };
    input.events.iter().map(notches).sum()
}

fn paint_over(ui: &Ui, picture: Rect, model: &ViewportModel) {
    let painter = ui.painter_at(picture);
    let at = |film: Vec2| picture.min + egui::vec2(film.x, film.y) * picture.size();
    if let Some(camera) = &model.camera {
        let mut lines = Vec::new();
        let mut add = |world_box: &WorldBox, stroke: Stroke| {
            lines.extend(
                edges(camera, world_box)
                    .into_iter()
                    .map(|[a, b]| Shape::line_segment([at(a), at(b)], stroke)),
            );
        };
        if model.keys.overlay.shown {
            for world_box in &model.boxes.boxes {
                let color = if world_box.over_instances { SCENE_BOX } else { MESH_BOX };
                add(world_box, Stroke::new(1.0, color));
            }
        }
        if let Some(selected) = &model.selection_box {
            add(selected, Stroke::new(1.5, SELECTION));
        }
        painter.extend(lines);
    }
    let mut notes = Vec::new();
    if model.keys.display.mode != DisplayMode::Shaded {
        notes.push(model.keys.display.mode.name().to_owned());
    }
    if model.keys.overlay.shown {
        let (shown, total) = (model.boxes.boxes.len(), model.boxes.total);
        notes.push(if total > MAX_BOXES {
            format!("{shown} of {total} boxes")
        } else {
            format!("{total} boxes")
        });
    }
    if model.keys.paused {
        notes.push("Paused".to_owned());
    }
    if !notes.is_empty() {
        tag(
            &painter,
            picture.left_top() + egui::vec2(8.0, 8.0),
            Align2::LEFT_TOP,
            &notes.join("   "),
        );
    }
    if model.pose.is_some() {
        let speed = format!(
            "speed {:.2}x, {:.3} units/s",
            model.navigation.speed,
            model.navigation.units_per_second()
        );
        tag(
            &painter,
            picture.left_bottom() + egui::vec2(8.0, -8.0),
            Align2::LEFT_BOTTOM,
            &speed,
        );
    }
    if model.keys.display.mode == DisplayMode::BvhSteps {
        legend(&painter, picture);
    }
}

/// A text that can be read on any picture.
fn tag(painter: &egui::Painter, corner: Pos2, align: Align2, text: &str) {
    let layout = painter.layout_no_wrap(text.to_owned(), FontId::proportional(12.5), Color32::from_gray(230));
    let rect = align.anchor_size(corner, layout.size() + egui::vec2(12.0, 6.0));
    painter.rect_filled(rect, 3.0, Color32::from_black_alpha(150));
    painter.galley(rect.min + egui::vec2(6.0, 3.0), layout, Color32::WHITE);
}

/// The heat map's colours with their numbers of steps.
fn legend(painter: &egui::Painter, picture: Rect) {
    let bar = Rect::from_min_size(
        picture.right_bottom() - egui::vec2(228.0, 26.0),
        egui::vec2(180.0, 12.0),
    );
    painter.rect_filled(bar.expand2(egui::vec2(40.0, 8.0)), 3.0, Color32::from_black_alpha(150));
    let strips = 60;
    for strip in 0..strips {
        let (from, to) = (strip as f32 / strips as f32, (strip + 1) as f32 / strips as f32);
        let [r, g, b] = heat(0.5 * (from + to)).map(|c| (255.0 * c) as u8);
        let rect = Rect::from_x_y_ranges(
            egui::lerp(bar.x_range(), from)..=egui::lerp(bar.x_range(), to),
            bar.y_range(),
        );
        painter.rect_filled(rect, 0.0, Color32::from_rgb(r, g, b));
    }
    let font = FontId::proportional(11.5);
    painter.text(
        bar.left_center() - egui::vec2(5.0, 0.0),
        Align2::RIGHT_CENTER,
        "0",
        font.clone(),
        Color32::WHITE,
    );
    let most = format!("{HOTTEST_STEPS:.0}+");
    painter.text(
        bar.right_center() + egui::vec2(5.0, 0.0),
        Align2::LEFT_CENTER,
        most,
        font,
        Color32::WHITE,
    );
}
