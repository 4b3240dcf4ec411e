//! The interaction with the gizmo: the handle under the pointer, a drag from press to release, and its keys.
//!
//! A drag begins with a press on a handle, or with G, R or T: then an axis (X, Y, Z) and a number may be typed, and the
//! same key again makes the selection follow the pointer. Escape restores all poses.

use bevy::math::Vec3;
use bevy::prelude::Entity;
use bevy_egui::egui::{Key, Painter, PointerButton, Pos2, Rect, Response, Ui, Vec2};

use super::super::marks::tag_beside;
use super::super::over_picture::is_over;
use super::constraint::Constraint;
use super::drag::{Change, Drag};
use super::handles::{self, Handle};
use super::{Target, frame, paint};
use crate::app::editor::camera::ground::GridPlane;
use crate::app::editor::camera::picking;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::camera::snapping::{self, SnapPoint};
use crate::app::editor::camera::solid::{Solid, solids_of};
use crate::app::editor::command::gizmo_settings::{GizmoSettings, Mode};
use crate::app::editor::command::grid_settings::GridSettings;
use crate::app::editor::command::key_bindings::KeyBindings;
use crate::app::editor::command::snapping::SnapTo;
use crate::app::editor::command::{Command, ValueEdit};
use crate::app::editor::input::actions;
use crate::app::editor::input::press::Press;
use crate::engine::PackedScene;
use crate::scene::LengthUnit;

/// The offset from the pointer to the text about a drag, in points.
const READ_OUT: Vec2 = Vec2::new(18.0, 14.0);

/// The data that the gizmo acts on.
#[derive(Clone, Copy, Debug)]
pub struct GizmoModel<'a> {
    /// The mode, axes, pivot and steps.
    pub settings: GizmoSettings,
    /// The selected objects that can be moved, the active one last.
    pub targets: &'a [Target],
    /// The step of lengths, in world units.
    pub length_step: f32,
    /// The grid on the ground, to whose lines moves may snap.
    pub grid: GridSettings,
    /// The world's upward direction, an axis.
    pub up: Vec3,
    /// The unit of the scene, for lengths that are typed.
    pub unit: LengthUnit,
    /// The packed scene, to drop things onto.
    pub packed: &'a PackedScene,
    /// The keys that the user has chosen.
    pub bound: &'a KeyBindings,
}

impl GizmoModel<'_> {
    /// The step of moves in world units: the step of the grid if moves snap to it and it is visible.
    fn step(&self, screen: &Screen, mode: Mode) -> f32 {
        let is_on_grid = mode == Mode::Move && self.settings.snap.to == SnapTo::Grid && self.grid.shown;
        match is_on_grid {
            true => GridPlane::of(screen, self.up).step(screen, &self.grid),
            false => self.length_step,
        }
    }
}

/// The state that the gizmo keeps between frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GizmoState {
    lit: Option<Constraint>,
    held: Option<Held>,
    /// Whether a drag has begun since the last query.
    begun: bool,
    /// The keys after one that ended a drag, which are handled in the next frame.
    waiting: Vec<Press>,
}

#[derive(Clone, Debug, PartialEq)]
struct Held {
    drag: Drag,
    by: Hold,
    change: Option<Change>,
    /// The dragged things as they were at the press.
    solids: Vec<Solid>,
    /// The place that the drag snaps to.
    snapped: Option<SnapPoint>,
}

/// The input that keeps a drag going.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hold {
    /// A pressed mouse button.
    Button,
    /// The pointer without a button, until a click.
    Pointer,
    /// No mouse button: the keyboard holds it, and numbers are awaited.
    Keys,
}

/// The input that the gizmo does not use.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rest {
    /// Whether the mouse is free for others.
    pub pointer: bool,
    /// The keys that the gizmo does not use, in order.
    pub presses: Vec<Press>,
}

impl GizmoState {
    /// Whether a drag has begun, even if it has not moved anything yet.
    pub(crate) fn is_dragging(&self) -> bool {
        self.held.is_some()
    }

    /// Whether a drag has begun that the pointer continues.
    pub(crate) fn follows_pointer(&self) -> bool {
        self.held.as_ref().is_some_and(|held| held.by != Hold::Keys)
    }

    /// Whether the drag has moved anything so far.
    pub(crate) fn is_moving(&self) -> bool {
        self.held.as_ref().is_some_and(|held| held.change.is_some())
    }

    /// Whether a drag has begun since the last call. It is a step of the history of its own.
    pub fn take_begun(&mut self) -> bool {
        std::mem::take(&mut self.begun)
    }

    /// Follows the mouse and the keys of one frame.
    pub fn follow_handles(
        &mut self,
        ui: &Ui,
        response: &Response,
        screen: &Screen,
        model: &GizmoModel,
        presses: &[Press],
        commands: &mut Vec<Command>,
    ) -> Rest {
        let (pointer, pressed, down) = ui.input(|input| {
            let pointer = input.pointer.latest_pos();
            (
                pointer,
                input.pointer.any_pressed(),
                input.pointer.button_down(PointerButton::Primary),
            )
        });
        let mut rest = Rest {
            pointer: true,
            presses: Vec::new(),
        };
        if self.held.as_ref().is_some_and(|held| !held.is_of(model.targets)) {
            self.held = None;
        }
        let mut queue = std::mem::take(&mut self.waiting);
        queue.extend(presses);
        let mut is_typed = false;
        for (place, press) in queue.iter().enumerate() {
            let is_for_number = self.held.as_ref().is_some_and(|held| held.waits_for(press));
            if is_typed && !is_for_number {
                self.waiting = queue.split_off(place);
                ui.request_repaint();
                break;
            }
            is_typed |= is_for_number;
            if !self.take_key(press, pointer, screen, model, commands) {
                rest.presses.push(*press);
            }
        }
        match self.held.as_ref().map(|held| held.by) {
            Some(Hold::Keys) if pressed => {
                let untouched = self.held.take().is_some_and(|held| held.drag.typed.is_empty());
                rest.pointer = untouched;
            }
            Some(Hold::Pointer) if pressed => {
                let cancels = ui.input(|input| input.pointer.button_pressed(PointerButton::Secondary));
                self.finish(cancels, commands);
                rest.pointer = false;
            }
            Some(Hold::Button) if !down => {
                self.held = None;
                rest.pointer = false;
            }
            Some(hold) => rest.pointer = hold == Hold::Keys,
            None => {}
        }
        if self.held.is_none() && rest.pointer {
            rest.pointer = !self.take_hold(ui, response, pointer, screen, model);
        }
        if let Some(held) = &mut self.held {
            let pointer = pointer.unwrap_or(screen.picture.center());
            held.follow(ui, screen, pointer, model, commands);
        }
        rest
    }

    /// Finds the handle under the pointer and begins a drag when it is pressed; returns whether the gizmo uses the
    /// pointer.
    fn take_hold(
        &mut self,
        ui: &Ui,
        response: &Response,
        pointer: Option<Pos2>,
        screen: &Screen,
        model: &GizmoModel,
    ) -> bool {
        let handles = shown(screen, model);
        let is_free = is_over(ui, response) && !ui.input(|input| input.modifiers.alt);
        // The pointer may have moved on since the press.
        let pressed_at = ui.input(|input| input.pointer.press_origin());
        let pointer = pressed_at.or(pointer).filter(|_| is_free);
        let is_down = ui.input(|input| input.pointer.any_down());
        let pressed = ui.input(|input| input.pointer.button_pressed(PointerButton::Primary));
        if !is_down || pressed {
            self.lit = pointer.and_then(|pointer| handles::handle_at(&handles, pointer));
        }
        let (Some(constraint), Some(pointer), true) = (self.lit, pointer, pressed) else {
            return false;
        };
        self.begin(constraint, pointer, Hold::Button, model.settings, screen, model);
        self.held.is_some()
    }

    fn begin(
        &mut self,
        constraint: Constraint,
        pointer: Pos2,
        by: Hold,
        settings: GizmoSettings,
        screen: &Screen,
        model: &GizmoModel,
    ) {
        self.begun = true;
        let entities: Vec<Entity> = model.targets.iter().map(|target| target.entity).collect();
        self.held = frame(model.targets, &settings, ahead(screen, model)).map(|frame| Held {
            drag: Drag::new(frame, model.targets.to_vec(), settings, constraint, pointer).with_unit(model.unit),
            by,
            change: None,
            solids: match settings.mode {
                Mode::Move => solids_of(model.packed, &entities),
                _ => Vec::new(),
            },
            snapped: None,
        });
    }

    fn finish(&mut self, cancels: bool, commands: &mut Vec<Command>) {
        if let Some(held) = self.held.take()
            && cancels
            && held.change.is_some()
        {
            let before = held.drag.targets.iter().map(|target| (target.entity, target.to_world));
            commands.push(ValueEdit::Transform(before.collect()).into());
        }
    }

    /// Handles a key; returns whether the drag used it.
    fn take_key(
        &mut self,
        press: &Press,
        pointer: Option<Pos2>,
        screen: &Screen,
        model: &GizmoModel,
        commands: &mut Vec<Command>,
    ) -> bool {
        let pointer = pointer.unwrap_or(screen.picture.center());
        let mode = mode_of(press, model.bound);
        let Some(held) = &mut self.held else {
            // The key chooses the mode as well.
            if let Some(mode) = mode {
                let settings = GizmoSettings { mode, ..model.settings };
                self.begin(Constraint::Free, pointer, Hold::Keys, settings, screen, model);
            }
            return false;
        };
        if mode == Some(held.drag.mode()) && held.by == Hold::Keys {
            held.by = Hold::Pointer;
            held.drag.take_hold(pointer);
            return true;
        }
        let is_shortcut = press.modifiers.command || press.modifiers.alt;
        match (press.key, axis_of(press.key)) {
            (Key::Escape, _) => self.finish(true, commands),
            (Key::Enter, _) => self.finish(false, commands),
            (_, Some(axis)) if !is_shortcut => held.drag.constrain(if press.modifiers.shift {
                Constraint::Plane(axis)
            } else {
                Constraint::Axis(axis)
            }),
            _ if !is_shortcut && held.drag.press(press) => {}
            // While something follows the pointer, other keys wait; before that they act as usual.
            _ if held.by == Hold::Keys => {
                self.held = None;
                return self.take_key(press, Some(pointer), screen, model, commands);
            }
            _ => {}
        }
        true
    }

    /// Paints the handles, or the active drag. `pointer` highlights the handle under it.
    pub fn paint_handles(&self, painter: &Painter, screen: &Screen, model: &GizmoModel, pointer: Option<Pos2>) {
        match &self.held {
            Some(held) if held.by != Hold::Keys || held.change.is_some() => {
                paint::paint_drag(painter, &held.drag, held.change, screen, pointer);
                if let Some(point) = &held.snapped {
                    paint::paint_snap(painter, point, screen);
                }
                if let (Some(change), Some(pointer), true) = (held.change, pointer, held.by != Hold::Keys) {
                    let text = held.drag.text(change, model.step(screen, held.drag.mode()));
                    tag_beside(painter, pointer + READ_OUT, &text);
                }
            }
            _ => paint::paint(painter, &shown(screen, model), model.settings.mode, self.lit),
        }
    }

    /// The text about a drag by the keyboard; None without one.
    pub fn note(&self, screen: &Screen, model: &GizmoModel) -> Option<String> {
        // The text about a drag by the mouse is shown at the pointer.
        let held = self.held.as_ref().filter(|held| held.by == Hold::Keys)?;
        if held.change.is_none() {
            let same = actions::key_text(action_of(held.drag.mode()), model.bound);
            return Some(format!(
                "X Y Z: axis   0-9: amount   {same}: follow the mouse   Esc: leave"
            ));
        }
        Some(held.drag.text(held.change?, model.step(screen, held.drag.mode())))
    }
}

impl Held {
    /// Whether the key is part of an amount that is being typed.
    fn waits_for(&self, press: &Press) -> bool {
        let is_plain = !press.modifiers.command && !press.modifiers.alt;
        let is_amount = axis_of(press.key).is_some() || self.drag.clone().press(press);
        self.by == Hold::Keys && is_plain && is_amount
    }

    /// Whether the drag moves exactly these objects.
    fn is_of(&self, targets: &[Target]) -> bool {
        let dragged = self.drag.targets.iter().map(|target| target.entity);
        dragged.eq(targets.iter().map(|target| target.entity))
    }

    fn follow(&mut self, ui: &Ui, screen: &Screen, pointer: Pos2, model: &GizmoModel, commands: &mut Vec<Command>) {
        if self.by == Hold::Keys && self.drag.typed.is_empty() {
            if self.change.take().is_some() {
                // The number was deleted again.
                let before = self.drag.targets.iter().map(|target| (target.entity, target.to_world));
                commands.push(ValueEdit::Transform(before.collect()).into());
            }
            return;
        }
        let modifiers = ui.input(|input| input.modifiers);
        self.snapped = None;
        let may_rest = self.drag.mode() == Mode::Move && self.drag.constraint == Constraint::Free;
        let change = if may_rest && modifiers.shift && self.drag.typed.is_empty() {
            let is_dragged = |entity| self.drag.targets.iter().any(|target| target.entity == entity);
            let surface = picking::seen_surface(model.packed, &screen.ray(pointer), is_dragged);
            surface
                .map(|seen| self.drag.onto_surface(seen.position, model.up))
                .or(self.change)
        } else {
            let snap = model.settings.snap;
            let snaps = match self.drag.mode() {
                Mode::Move => modifiers.command != snap.always,
                Mode::Rotate | Mode::Scale => modifiers.command,
            };
            let onto_things = snaps && snap.to.is_of_geometry() && self.drag.mode() == Mode::Move;
            let found = match onto_things && self.drag.typed.is_empty() {
                true => self.onto_things(screen, pointer, model),
                false => None,
            };
            let steps = snaps && !onto_things;
            let step = model.step(screen, self.drag.mode());
            Some(found.unwrap_or_else(|| self.drag.follow(screen, pointer, steps, step)))
        };
        // A press alone moves nothing.
        let is_begun = self.change.is_some() || change.is_some_and(|change| !change.is_none());
        if is_begun && change != self.change {
            self.change = change;
            commands.extend(change.map(|change| Command::from(ValueEdit::Transform(self.drag.apply(change)))));
        }
    }
}

impl Held {
    /// The change that snaps the dragged objects to the corner, edge or surface at the pointer; None if there is none.
    fn onto_things(&mut self, screen: &Screen, pointer: Pos2, model: &GizmoModel) -> Option<Change> {
        let drag = &mut self.drag;
        let is_dragged = |entity| drag.targets.iter().any(|target| target.entity == entity);
        let snap = model.settings.snap;
        let point = snapping::find(model.packed, screen, pointer, snap.to, is_dragged)?;
        self.snapped = Some(point);
        Some(match point.of {
            SnapTo::Faces => {
                let up = drag.targets.last().map(|active| upper_side(active, model.up));
                let aligned_from = up.filter(|_| snap.aligns);
                drag.onto_plane(screen, &self.solids, point.place, point.normal, aligned_from)
            }
            _ => {
                let corners: Vec<Vec3> = self.solids.iter().flat_map(Solid::corners).collect();
                drag.onto_place(screen, pointer, &corners, point.place)
            }
        })
    }
}

/// The axis of an object, or its opposite, that points up most.
fn upper_side(target: &Target, up: Vec3) -> Vec3 {
    let matrix = target.to_world.matrix3;
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| Vec3::from(axis).normalize_or_zero());
    let steepness = |axis: &Vec3| axis.dot(up).abs();
    let axis = axes.into_iter().max_by(|a, b| steepness(a).total_cmp(&steepness(b)));
    axis.map_or(up, |axis| axis * axis.dot(up).signum())
}

fn shown(screen: &Screen, model: &GizmoModel) -> Vec<Handle> {
    if model.settings.is_hidden {
        return Vec::new();
    }
    let frame = frame(model.targets, &model.settings, ahead(screen, model));
    frame.map_or(Vec::new(), |frame| {
        handles::handles(&frame, model.settings.mode, screen)
    })
}

/// The square around all handles; None without any.
pub(crate) fn place_of_handles(screen: &Screen, model: &GizmoModel) -> Option<Rect> {
    if model.settings.is_hidden {
        return None;
    }
    let frame = frame(model.targets, &model.settings, ahead(screen, model))?;
    let middle = screen.project(frame.origin)?;
    Some(Rect::from_center_size(middle, Vec2::splat(2.0 * handles::SPAN)))
}

/// The point about which something without a place is turned: straight ahead of the camera.
fn ahead(screen: &Screen, model: &GizmoModel) -> Vec3 {
    screen.unproject(screen.picture.center(), model.length_step.max(f32::MIN_POSITIVE) * 50.0)
}

/// The action whose key chooses the mode.
fn action_of(mode: Mode) -> &'static str {
    match mode {
        Mode::Move => "gizmo-move",
        Mode::Rotate => "gizmo-rotate",
        Mode::Scale => "gizmo-scale",
    }
}

fn mode_of(press: &Press, bound: &KeyBindings) -> Option<Mode> {
    let is_pressed =
        |mode: &Mode| actions::find(action_of(*mode)).is_some_and(|action| action.is_pressed(press, bound));
    [Mode::Move, Mode::Rotate, Mode::Scale].into_iter().find(is_pressed)
}

fn axis_of(key: Key) -> Option<usize> {
    [Key::X, Key::Y, Key::Z].iter().position(|axis| *axis == key)
}
