//! The handles of the openings of the selected wall: they are dragged along the wall and upwards, and Delete fills the
//! opening whose handle was clicked or is under the pointer.

use bevy::math::Vec3;
use bevy::prelude::Entity;
use bevy_egui::egui::{Color32, Key, Painter, PointerButton, Pos2, Rect, Response, Stroke, StrokeKind, Ui, vec2};

use super::cut::caption;
use super::hand::BlockTarget;
use super::{marks, spot};
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::blocking::grips::Grip;
use crate::app::editor::command::blocking::openings::Cut;
use crate::app::editor::command::blocking::{OpeningKind, Reshaping, snapped};
use crate::app::editor::command::{Command, SceneEdit};
use crate::app::editor::input::press::Press;
use crate::app::editor::viewport::gizmo::interaction::Rest;
use crate::app::editor::viewport::over_picture::is_over;
use crate::scene::{LengthUnit, Opening, Shape, ShapeKind, Solid};

/// The size of a handle, and the distance from its middle within which it is held, in points.
const SIZE: f32 = 8.0;
const REACH: f32 = 8.0;
/// The least distance of two opposite edges in the picture for these to have handles, in points.
const LEAST_EXTENT: f32 = 34.0;
/// The distance within which edges snap to those of other openings, in points.
const ATTRACTION: f32 = 6.0;
/// The largest cosine between the direction of sight and a wall that is seen too much from its end.
const END_ON: f32 = 0.05;

/// The data that the handles act on.
#[derive(Clone, Copy, Debug)]
pub struct GripModel<'a> {
    /// The selected wall; None unless it alone is selected, has openings and can be edited.
    pub wall: Option<&'a BlockTarget>,
    /// The step of the grid, in world units.
    pub step: f32,
    /// The world's upward direction.
    pub up: Vec3,
    /// The unit of the scene.
    pub unit: LengthUnit,
}

/// The state of the handles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GripState {
    /// The handle under the pointer: the number of the opening, and its part.
    hovered: Option<(usize, Grip)>,
    /// The opening whose handle was clicked last.
    chosen: Option<usize>,
    /// The wall of both, and the number of its openings.
    of: Option<(Entity, usize)>,
    held: Option<Held>,
}

#[derive(Clone, Debug, PartialEq)]
struct Held {
    /// The wall as it was at the press.
    target: BlockTarget,
    number: usize,
    grip: Grip,
    /// The place of the press on the wall's face, in its own units.
    from: [f32; 2],
    /// The opening as it is now.
    now: Opening,
}

impl GripState {
    /// Whether a handle is held.
    pub fn is_busy(&self) -> bool {
        self.held.is_some()
    }

    /// Ends a drag where it is.
    pub fn let_go(&mut self) {
        self.held = None;
    }

    /// Follows the mouse and the keys of one frame.
    pub fn follow_grips(
        &mut self,
        ui: &Ui,
        response: &Response,
        screen: &Screen,
        model: &GripModel,
        presses: &[Press],
        commands: &mut Vec<Command>,
    ) -> Rest {
        let mut rest = Rest {
            pointer: true,
            presses: presses.to_vec(),
        };
        let Some(wall) = model.wall else {
            *self = Self::default();
            return rest;
        };
        let is_of_wall = |held: &Held| held.target.entity == wall.entity;
        self.held = self.held.take().filter(is_of_wall);
        let of = Some((wall.entity, openings(wall).len()));
        if self.of != of {
            (self.hovered, self.chosen, self.of) = (None, None, of);
        }
        let (pointer, pressed, down, no_snap, alt) = ui.input(|input| {
            (
                input.pointer.latest_pos(),
                input.pointer.button_pressed(PointerButton::Primary),
                input.pointer.button_down(PointerButton::Primary),
                input.modifiers.command,
                input.modifiers.alt,
            )
        });
        let pressed_at = ui.input(|input| input.pointer.press_origin()).filter(|_| pressed);
        let pointer = pressed_at.or(pointer).unwrap_or(screen.picture.center());
        let step = if no_snap { 0.0 } else { model.step };
        if self.held.is_none() {
            let is_free = is_over(ui, response) && !alt;
            self.hovered = if is_free { at(screen, wall, pointer) } else { None };
            if pressed && is_free {
                self.chosen = self.hovered.map(|(number, _)| number);
                self.held = self.hovered.and_then(|grip| Held::new(screen, wall, grip, pointer));
            }
        }
        self.take_keys(wall, &mut rest.presses, commands);
        if let Some(held) = &mut self.held {
            if let Some(now) = held.opening(screen, model, pointer, step)
                && now != held.now
            {
                held.now = now;
                commands.push(reshaped(&held.target, Reshaping::Move, |all| all[held.number] = now));
            }
            rest.pointer = false;
            if !down {
                self.held = None;
            }
            ui.ctx().request_repaint();
        }
        rest
    }

    /// Takes Delete for an opening, and Esc for a drag. Other keys wait for the end of a drag, which would undo their
    /// effect on the wall.
    fn take_keys(&mut self, wall: &BlockTarget, presses: &mut Vec<Press>, commands: &mut Vec<Command>) {
        presses.retain(|press| {
            let is_plain = press.modifiers.is_none();
            match press.key {
                Key::Escape if self.held.is_some() => {
                    if let Some(held) = self.held.take() {
                        commands.push(reshaped(&held.target, Reshaping::Move, |_| {}));
                    }
                    false
                }
                Key::Delete if is_plain && self.held.is_none() => {
                    let number = self.hovered.map(|(number, _)| number).or(self.chosen);
                    let Some(number) = number.filter(|number| *number < openings(wall).len()) else {
                        return true;
                    };
                    commands.push(reshaped(wall, Reshaping::Fill, |all| _ = all.remove(number)));
                    *self = Self::default();
                    false
                }
                _ => self.held.is_none(),
            }
        });
    }

    /// Paints the handles, the edges of the opening that is held, chosen or under the pointer, and in the view with
    /// the pointer the measures of an opening that is held or under it.
    pub fn paint_grips(&self, painter: &Painter, screen: &Screen, model: &GripModel, has_pointer: bool) {
        let Some(wall) = model.wall else { return };
        let held = self.held.as_ref().map(|held| (held.number, held.grip));
        let pointed = held.or(self.hovered).map(|(number, _)| number);
        let lit = pointed.or(self.chosen);
        if let Some(opening) = lit.and_then(|number| openings(wall).get(number)) {
            let cut = Cut {
                wall: match &wall.shape.kind {
                    ShapeKind::Solid(part) => part.clone(),
                    _ => return,
                },
                pose: wall.pose,
                opening: *opening,
                is_hole: is_lying(wall, model.up),
            };
            let corners = cut.corners();
            marks::ring(painter, screen, &corners[..4]);
            marks::ring(painter, screen, &corners[4..]);
            if has_pointer && pointed.is_some() {
                let kind = match opening.sill {
                    0.0 => OpeningKind::Door,
                    _ => OpeningKind::Window,
                };
                let place = place_of(screen, wall, Grip::Top.place(opening));
                let text = caption(&cut, kind, "", model.unit);
                let keys = if held.is_some() { "" } else { "   (Del: fill it)" };
                marks::text(painter, screen, place, &format!("{text}{keys}"));
            }
        }
        for (number, grip, place) in shown(screen, wall) {
            let is_lit = held.or(self.hovered) == Some((number, grip));
            let fill = if is_lit { marks::COLOR } else { Color32::WHITE };
            let square = Rect::from_center_size(place, vec2(SIZE, SIZE));
            let rounding = if grip == Grip::Middle { 0.5 * SIZE } else { 1.0 };
            let edge = Stroke::new(1.2, Color32::from_black_alpha(200));
            painter.rect(square, rounding, fill, edge, StrokeKind::Outside);
        }
    }
}

impl Held {
    fn new(screen: &Screen, wall: &BlockTarget, (number, grip): (usize, Grip), pointer: Pos2) -> Option<Self> {
        Some(Self {
            target: wall.clone(),
            number,
            grip,
            from: on_face(screen, wall, pointer)?,
            now: *openings(wall).get(number)?,
        })
    }

    /// The opening with the handle at the pointer.
    fn opening(&self, screen: &Screen, model: &GripModel, pointer: Pos2, step: f32) -> Option<Opening> {
        let ShapeKind::Solid(part) = &self.target.shape.kind else {
            return None;
        };
        let before = openings(&self.target).get(self.number)?;
        let to = on_face(screen, &self.target, pointer)?;
        let units = [0, 2].map(|axis| Vec3::from(self.target.pose.matrix3.col(axis)).length());
        let place = place_of(screen, &self.target, to);
        let reach = ATTRACTION * screen.units_per_point(screen.depth(place));
        // A click and the jitter of a straight drag change nothing.
        let slack = reach.min(0.5 * step);
        let by = [0, 1].map(|axis| {
            let by = to[axis] - self.from[axis];
            if by.abs() * units[axis] < slack { 0.0 } else { by }
        });
        let snap = |place: f32, axis: usize| {
            if step <= 0.0 {
                return place;
            }
            let off = |edge: &f32| (edge - place).abs() * units[axis];
            let nearest = self.edges(axis).min_by(|one, other| off(one).total_cmp(&off(other)));
            match nearest.filter(|edge| off(edge) <= reach) {
                Some(edge) => edge,
                None => snapped(place * units[axis], step) / units[axis],
            }
        };
        self.grip
            .dragged(part, before, by, !is_lying(&self.target, model.up), snap)
    }

    /// The edges of the other openings, along the wall (axis 0) or upwards.
    fn edges(&self, axis: usize) -> impl Iterator<Item = f32> {
        let all = openings(&self.target).iter().enumerate();
        let others = all.filter(|(number, _)| *number != self.number);
        others.flat_map(move |(_, opening)| match axis {
            0 => [opening.from, opening.from + opening.width],
            _ => [opening.sill, opening.sill + opening.height],
        })
    }
}

/// The openings of a wall; none for other shapes.
pub(in crate::app::editor::viewport) fn openings(wall: &BlockTarget) -> &[Opening] {
    match &wall.shape.kind {
        ShapeKind::Solid(Solid::Wall { openings, .. }) => openings,
        _ => &[],
    }
}

/// The command that changes the openings of a wall.
fn reshaped(wall: &BlockTarget, how: Reshaping, change: impl FnOnce(&mut Vec<Opening>)) -> Command {
    let mut shape: Shape = wall.shape.clone();
    if let ShapeKind::Solid(Solid::Wall { openings, .. }) = &mut shape.kind {
        change(openings);
    }
    SceneEdit::Reshape(wall.entity, shape, wall.pose, how).into()
}

/// Whether the wall lies, as a floor does whose openings are holes.
fn is_lying(wall: &BlockTarget, up: Vec3) -> bool {
    Vec3::from(wall.pose.matrix3.z_axis).normalize_or_zero().dot(up).abs() < 0.5
}

/// The face of the wall that is turned to the camera, as the y of its own space.
fn face(screen: &Screen, wall: &BlockTarget) -> f32 {
    let half = match wall.shape.kind {
        ShapeKind::Solid(Solid::Wall { thickness, .. }) => 0.5 * thickness,
        _ => 0.0,
    };
    let ray = screen.ray(screen.picture.center());
    let across = Vec3::from(wall.pose.matrix3.y_axis);
    // A parallel view has a direction and no place.
    let towards = match screen.camera.is_orthographic() {
        true => -ray.dir,
        false => ray.origin - Vec3::from(wall.pose.translation),
    };
    if towards.dot(across) < 0.0 { -half } else { half }
}

/// The place in the world of a point of the face that is turned to the camera.
fn place_of(screen: &Screen, wall: &BlockTarget, [along, upward]: [f32; 2]) -> Vec3 {
    wall.pose.transform_point3(Vec3::new(along, face(screen, wall), upward))
}

/// The point of the face under the pointer, in the wall's units; None if the wall is seen from its end.
fn on_face(screen: &Screen, wall: &BlockTarget, pointer: Pos2) -> Option<[f32; 2]> {
    let normal = Vec3::from(wall.pose.matrix3.y_axis).normalize_or_zero();
    let ray = screen.ray(pointer);
    if ray.dir.normalize_or_zero().dot(normal).abs() < END_ON {
        return None;
    }
    let place = spot::on_plane(screen, pointer, place_of(screen, wall, [0.0; 2]), normal)?;
    let local = wall.pose.inverse().transform_point3(place);
    local.is_finite().then_some([local.x, local.z])
}

/// The handles in the picture: the number of the opening, its part and the place on the screen.
fn shown(screen: &Screen, wall: &BlockTarget) -> Vec<(usize, Grip, Pos2)> {
    let mut all = Vec::new();
    for (number, opening) in openings(wall).iter().enumerate() {
        let place = |grip: Grip| screen.project(place_of(screen, wall, grip.place(opening)));
        let is_wide = |one: Grip, other: Grip| {
            place(one)
                .zip(place(other))
                .is_some_and(|(one, other)| one.distance(other) >= LEAST_EXTENT)
        };
        let (has_sides, has_ends) = (is_wide(Grip::Left, Grip::Right), is_wide(Grip::Bottom, Grip::Top));
        for grip in Grip::ALL {
            let is_shown = match grip {
                Grip::Middle => true,
                Grip::Left | Grip::Right => has_sides,
                Grip::Bottom | Grip::Top => has_ends,
            };
            if let Some(at) = place(grip).filter(|_| is_shown) {
                all.push((number, grip, at));
            }
        }
    }
    all
}

/// The handle under the pointer.
fn at(screen: &Screen, wall: &BlockTarget, pointer: Pos2) -> Option<(usize, Grip)> {
    // A wall that is seen from its end has handles that cannot be dragged.
    on_face(screen, wall, pointer)?;
    let near = shown(screen, wall)
        .into_iter()
        .map(|(number, grip, at)| (at.distance(pointer), (number, grip)));
    near.filter(|(distance, _)| *distance <= REACH)
        .min_by(|(one, _), (other, _)| one.total_cmp(other))
        .map(|(_, grip)| grip)
}
