//! Handles the mouse over the picture where the gizmo does not use it: looking, orbiting, panning, the wheel, picking
//! and the selection box.
//!
//! The press and the navigation preset decide the effect of a drag; the tables are in `input/drags.rs`.

use bevy::math::{Affine3A, Vec2, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{self, Color32, MouseWheelUnit, PointerButton, Pos2, Rect, Response, Ui};

use super::cursor::TurningCursor;
use super::marks::thin_frame;
use super::model::ViewportModel;
use super::over_picture::is_over;
use super::{gizmo, icons, rulers};
use crate::app::editor::camera::ground::GridPlane;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::camera::{orbit, picking};
use crate::app::editor::command::inspected_paths::InspectedPaths;
use crate::app::editor::command::panel::Panel;
use crate::app::editor::command::ruler::Ruler;
use crate::app::editor::command::selection::Extend;
use crate::app::editor::command::tool::Tool;
use crate::app::editor::command::{
    CameraEdit, Command, RenderCommand, SelectionCommand, ShellCommand, ToolCommand, ViewCommand,
};
use crate::app::editor::input::drags::{DragUse, drag_use};

/// The state of the mouse, from press to release.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointerState {
    hold: Option<Hold>,
    /// The cursor, which is held in place while the view turns.
    pub(crate) cursor: TurningCursor,
    /// The thing under the pointer.
    pub hovered: Option<Entity>,
    /// Whether nothing is hovered, because there is no user.
    pub(crate) is_unattended: bool,
    /// The first point of a distance that is being measured.
    pub(crate) measured_from: Option<Vec3>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Hold {
    Look,
    Orbit {
        center: Vec3,
    },
    Pan {
        last: Pos2,
        depth: f32,
    },
    Dolly {
        from: Pos2,
        last: Pos2,
        target: Option<Vec3>,
    },
    Box {
        from: Pos2,
    },
}

/// The points by which the wheel has to turn for one notch.
const POINTS_PER_NOTCH: f32 = 50.0;
/// The points of a dolly's drag that count as one notch of the wheel.
const POINTS_PER_STEP: f32 = 25.0;
/// The size in points from which a box of selection is shown: a click draws none.
const LEAST_BOX: f32 = 4.0;
/// The assumed distance of things where no surface is visible, as a share of the scene's size.
const NOWHERE: f32 = 0.5;

impl PointerState {
    /// Whether the view is being turned: flying keys are meant then, whatever the modifiers.
    pub(crate) fn is_looking(&self) -> bool {
        matches!(self.hold, Some(Hold::Look | Hold::Orbit { .. }))
    }

    /// Follows the mouse for a frame. `is_free` says that neither a tool nor the axes widget uses it. Returns the
    /// points by which the view is to be turned, and moves `pose`.
    pub fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        screen: &Screen,
        model: &ViewportModel,
        is_free: bool,
        pose: &mut Affine3A,
        commands: &mut Vec<Command>,
    ) -> Vec2 {
        let pointer = ui
            .input(|input| input.pointer.latest_pos())
            .unwrap_or(screen.picture.center());
        let is_over = is_free && is_over(ui, response);
        if ui.input(|input| !input.pointer.any_down() && !input.pointer.any_released()) {
            self.hold = None;
        }
        // The pointer may have moved on since the press.
        let pressed_at = ui.input(|input| input.pointer.press_origin()).unwrap_or(pointer);
        let is_pressed_here = is_over && response.interact_rect.contains(pressed_at);
        if is_pressed_here && let Some(button) = pressed_button(ui) {
            let what = drag_use(model.preset, button, ui.input(|input| input.modifiers));
            let what = match (model.keys.tool, button) {
                (Tool::Region | Tool::Paths, PointerButton::Primary) if what != DragUse::Orbit => DragUse::Box,
                _ => what,
            };
            let what = match what {
                // A side view has a fixed direction.
                DragUse::Look | DragUse::Orbit if model.side.is_some() => DragUse::Pan,
                what => what,
            };
            let hold = hold_of(what, pressed_at, screen, model, *pose);
            if let Hold::Orbit { center } = hold {
                commands.push(ViewCommand::TurnAbout(center).into());
            }
            self.hold = Some(hold);
        }
        if is_over && self.hold.is_some() && response.clicked_by(PointerButton::Primary) {
            self.click(ui, pointer, screen, model, commands);
        }
        let turns = self.is_looking() && response.dragged();
        let by = if turns {
            let (before, seen) = ui.input(|input| (pointer - input.pointer.delta(), moves(input)));
            let pixels = ui.ctx().pixels_per_point();
            let device = model.mouse / pixels;
            let by = self.cursor.follow(before, &seen, device, screen.picture, pixels);
            Vec2::new(by.x, by.y)
        } else {
            Vec2::ZERO
        };
        if model.keys.tool != Tool::Ruler {
            self.measured_from = None;
        }
        let mut look = Vec2::ZERO;
        match &mut self.hold {
            Some(Hold::Look) => look = by,
            Some(Hold::Orbit { center }) if by != Vec2::ZERO => {
                *pose = model.navigation.orbit(*pose, *center, by);
            }
            Some(Hold::Pan { last, depth }) if *last != pointer => {
                *pose = orbit::pan(*pose, screen, *last, pointer, *depth);
                *last = pointer;
            }
            Some(Hold::Dolly { from, last, target }) if last.y != pointer.y => {
                let notches = (last.y - pointer.y) / POINTS_PER_STEP;
                *pose = approach(*pose, screen, model, *from, *target, notches);
                *last = pointer;
            }
            Some(Hold::Box { from }) if response.drag_stopped() => {
                let boxed = Rect::from_two_pos(*from, pointer);
                let corners = [screen.film(boxed.min), screen.film(boxed.max)];
                let corners = corners.map(|corner| corner.clamp(Vec2::ZERO, Vec2::ONE));
                let view = model.packed.view.as_ref();
                let [min, max] = corners.map(|corner| view.map_or(corner, |view| view.film_of_picture(corner)));
                if model.keys.tool == Tool::Paths && model.side.is_none() {
                    let paths = InspectedPaths::between([min, max]).shown_as(model.paths.wanted);
                    commands.push(ToolCommand::InspectPaths(Some(paths)).into());
                    commands.push(ShellCommand::ShowPanel(Panel::Paths).into());
                    return Vec2::ZERO;
                }
                if model.keys.tool == Tool::Region {
                    commands.push(RenderCommand::SetRegion(Some(bevy::math::Rect { min, max })).into());
                    commands.push(ToolCommand::SetTool(Tool::Select).into());
                    return Vec2::ZERO;
                }
                let modifiers = ui.input(|input| input.modifiers);
                let how = match (modifiers.command, modifiers.shift) {
                    (true, _) => Extend::Toggle,
                    (false, true) => Extend::Add,
                    (false, false) => Extend::Replace,
                };
                let entities = inside(boxed, screen, model, ui.ctx().pixels_per_point());
                if !entities.is_empty() || how == Extend::Replace {
                    commands.push(SelectionCommand::Select(entities, how).into());
                }
            }
            _ => {}
        }
        if ui.input(|input| !input.pointer.any_down()) {
            self.let_go(ui);
        }
        let turns_wheel = is_free && response.contains_pointer();
        self.wheel(ui, turns_wheel, pointer, screen, model, pose, commands);
        let hovered = (is_over && self.hold.is_none() && !self.is_unattended)
            .then(|| under(pointer, screen, model))
            .flatten();
        if hovered != self.hovered {
            self.hovered = hovered;
            // The outline is found before the next frame is shown.
            ui.ctx().request_repaint();
        }
        look
    }

    /// Ends the use of the mouse.
    pub(crate) fn let_go(&mut self, ui: &Ui) {
        self.hold = None;
        self.cursor.let_go(ui.ctx().pixels_per_point());
    }

    fn click(&mut self, ui: &Ui, pointer: Pos2, screen: &Screen, model: &ViewportModel, commands: &mut Vec<Command>) {
        let modifiers = ui.input(|input| input.modifiers);
        let how = if modifiers.shift || modifiers.command {
            Extend::Toggle
        } else {
            Extend::Replace
        };
        let film = screen.film(pointer);
        match model.keys.tool {
            Tool::Select => {}
            Tool::Focus => {
                commands.extend([
                    Command::from(CameraEdit::FocusAt(film)),
                    Command::from(ToolCommand::SetTool(Tool::Select)),
                ]);
                return;
            }
            Tool::Paths => {
                let view = model.packed.view.as_ref();
                let place = view.map_or(film, |view| view.film_of_picture(film));
                let paths = InspectedPaths::at(place).shown_as(model.paths.wanted);
                commands.push(ToolCommand::InspectPaths(Some(paths)).into());
                commands.push(ShellCommand::ShowPanel(Panel::Paths).into());
                return;
            }
            Tool::Ruler => {
                let Some(point) = rulers::point_at(pointer, screen, model) else {
                    return;
                };
                match self.measured_from.take() {
                    Some(from) if from != point => {
                        commands.push(ToolCommand::AddRuler(Ruler { from, to: point }).into())
                    }
                    _ => self.measured_from = Some(point),
                }
                return;
            }
            Tool::Region | Tool::Draw(_) | Tool::Push | Tool::Cut(_) | Tool::PlaceTexture | Tool::PaintLight => return,
        }
        match icons::icon_at(screen, model.icons, pointer).filter(|entity| !model.locked.contains(entity)) {
            Some(entity) => commands.push(SelectionCommand::Select(vec![entity], how).into()),
            None if model.side.is_none() => commands.push(SelectionCommand::Pick(film, how).into()),
            // The command would look from the main camera.
            None => {
                let found = under(pointer, screen, model);
                if found.is_some() || how == Extend::Replace {
                    commands.push(SelectionCommand::Select(Vec::from_iter(found), how).into());
                }
            }
        }
    }

    fn wheel(
        &self,
        ui: &Ui,
        is_over: bool,
        pointer: Pos2,
        screen: &Screen,
        model: &ViewportModel,
        pose: &mut Affine3A,
        commands: &mut Vec<Command>,
    ) {
        let notches = ui.input(notches);
        if notches == 0.0 || !(is_over || self.hold.is_some()) {
            return;
        }
        // In a side view the button pans, and nothing flies.
        if model.side.is_none() && ui.input(|input| input.pointer.secondary_down()) {
            commands.push(ViewCommand::SetSpeed(model.navigation.speed_after(notches)).into());
        } else {
            let target = seen_at(pointer, screen, model).or_else(|| ground_at(pointer, screen, model));
            *pose = approach(*pose, screen, model, pointer, target, notches);
        }
    }

    /// Paints the selection box while it is drawn.
    pub fn paint(&self, painter: &egui::Painter, pointer: Option<Pos2>) {
        if let (Some(Hold::Box { from }), Some(pointer)) = (self.hold, pointer) {
            let rect = Rect::from_two_pos(from, pointer);
            if rect.size().max_elem() < LEAST_BOX {
                return;
            }
            painter.rect_filled(rect, 0.0, Color32::from_white_alpha(18));
            thin_frame(painter, rect, 200);
        }
    }
}

fn hold_of(what: DragUse, pointer: Pos2, screen: &Screen, model: &ViewportModel, pose: Affine3A) -> Hold {
    match what {
        DragUse::Look => Hold::Look,
        DragUse::Orbit => Hold::Orbit {
            center: center(screen, model, pose),
        },
        DragUse::Pan => Hold::Pan {
            last: pointer,
            depth: seen_at(pointer, screen, model)
                .map_or(NOWHERE * model.navigation.scene_size, |seen| screen.depth(seen)),
        },
        DragUse::Dolly => Hold::Dolly {
            from: pointer,
            last: pointer,
            target: seen_at(pointer, screen, model),
        },
        DragUse::Box => Hold::Box { from: pointer },
    }
}

/// The point of the nearest surface under a point of the window.
fn seen_at(pointer: Pos2, screen: &Screen, model: &ViewportModel) -> Option<Vec3> {
    picking::seen_surface(model.packed, &screen.ray(pointer), |_| false).map(|seen| seen.position)
}

/// The point of the ground under a point of the window, within a distance where things may be.
fn ground_at(pointer: Pos2, screen: &Screen, model: &ViewportModel) -> Option<Vec3> {
    /// The largest distance in sizes of the scene. The ground may reach the horizon, and a notch must not go a share of
    /// that distance.
    const FARTHEST: f32 = 4.0;
    let place = GridPlane::of(screen, model.navigation.up).hit(&screen.ray(pointer))?;
    (screen.depth(place) <= FARTHEST * model.navigation.scene_size).then_some(place)
}

/// The pose after some notches of the wheel towards `target`, which is seen at `at`.
fn approach(
    pose: Affine3A,
    screen: &Screen,
    model: &ViewportModel,
    at: Pos2,
    target: Option<Vec3>,
    notches: f32,
) -> Affine3A {
    match screen.camera.is_orthographic() {
        true => model.navigation.narrow(pose, screen.film(at), screen, notches),
        false => model.navigation.dolly(pose, &screen.ray(at), target, notches),
    }
}

fn pressed_button(ui: &Ui) -> Option<PointerButton> {
    let buttons = [PointerButton::Primary, PointerButton::Secondary, PointerButton::Middle];
    ui.input(|input| buttons.into_iter().find(|button| input.pointer.button_pressed(*button)))
}

/// The middle of the selection; without one the last centre of orbits if it is straight ahead, or the surface there.
pub(super) fn center(screen: &Screen, model: &ViewportModel, pose: Affine3A) -> Vec3 {
    let selected = gizmo::bounds(model.gizmo.targets);
    if !selected.is_empty() {
        return selected.center();
    }
    if let Some(pivot) = model.navigation.pivot_ahead(&pose) {
        return pivot;
    }
    let ahead = screen.ray(screen.picture.center());
    match picking::seen_surface(model.packed, &ahead, |_| false) {
        Some(seen) => seen.position,
        None => Vec3::from(pose.translation) + screen.forward() * (NOWHERE * model.navigation.scene_size),
    }
}

fn under(pointer: Pos2, screen: &Screen, model: &ViewportModel) -> Option<Entity> {
    let icon = icons::icon_at(screen, model.icons, pointer);
    let entity = icon.or_else(|| picking::pick(model.packed, screen.film(pointer)));
    entity.filter(|entity| !model.locked.contains(entity))
}

/// The shapes with a visible surface in a box of the window, and the lights and cameras with their icon in it.
fn inside(boxed: Rect, screen: &Screen, model: &ViewportModel, pixels_per_point: f32) -> Vec<Entity> {
    let pixels = boxed.intersect(screen.picture).size() * pixels_per_point;
    let mut found = picking::seen_in(
        model.packed,
        [screen.film(boxed.min), screen.film(boxed.max)],
        [pixels.x, pixels.y],
    );
    let is_inside = |icon: &&icons::Icon| icons::place(screen, icon).is_some_and(|at| boxed.contains(at));
    found.extend(model.icons.iter().filter(is_inside).map(|icon| icon.entity));
    found.retain(|entity| !model.locked.contains(entity));
    found
}

/// The places of the pointer since the last frame, in order.
fn moves(input: &egui::InputState) -> Vec<Pos2> {
    let place = |event: &egui::Event| match event {
        egui::Event::PointerMoved(place) => Some(*place),
        _ => None,
    };
    input.events.iter().filter_map(place).collect()
}

/// The notches of the wheel in this frame, positive away from the user.
fn notches(input: &egui::InputState) -> f32 {
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
