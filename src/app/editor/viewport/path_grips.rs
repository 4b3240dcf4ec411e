//! The handles of the points of the selected path: they are dragged over the ground, with Shift upwards. A dot in the
//! middle of a leg becomes a new point when it is dragged, and Delete removes the point under the pointer.

use bevy::math::Vec3;
use bevy::prelude::Entity;
use bevy_egui::egui::{Color32, Key, Painter, PointerButton, Pos2, Response, Stroke, Ui};

use super::blocking::marks;
use super::blocking::spot::on_plane;
use super::gizmo::interaction::Rest;
use super::icons::MarkerPath;
use super::over_picture::is_over;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::Command;
use crate::app::editor::command::properties::{PropertyChange, PropertyEdit, PropertyOwner};
use crate::app::editor::input::press::Press;
use crate::scene::marker::{POINTS, points_value};

/// The radius of a handle, and that of the dot in the middle of a leg, in points.
const RADIUS: f32 = 4.5;
const SMALL: f32 = 2.5;
/// The distance from its middle within which a handle is held, in points.
const REACH: f32 = 8.0;
/// The least number of points of a path.
const FEWEST: usize = 2;
/// The most points of a path that have handles.
const MOST: usize = 400;

/// The data that the handles act on.
#[derive(Clone, Copy, Debug)]
pub struct PathGripModel<'a> {
    /// The path that alone is selected and can be edited.
    pub path: Option<&'a MarkerPath>,
    /// The step of the grid, in world units; 0 for none.
    pub step: f32,
    /// The world's upward direction, an axis.
    pub up: Vec3,
}

/// A handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Handle {
    /// The point of this number.
    Point(usize),
    /// The middle between the point of this number and the next one.
    Middle(usize),
}

/// The state of the handles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathGripState {
    hovered: Option<Handle>,
    held: Option<Held>,
}

#[derive(Clone, Debug, PartialEq)]
struct Held {
    entity: Entity,
    /// The points in the world at the press, with the new one if a middle was pressed.
    points: Vec<Vec3>,
    number: usize,
    /// The points in the path's own space before the press.
    before: Vec<Vec3>,
    /// The place of the point now.
    now: Vec3,
    pressed_at: Pos2,
}

impl PathGripState {
    /// Whether a handle is held.
    pub fn is_busy(&self) -> bool {
        self.held.is_some()
    }

    /// Ends a drag where it is.
    pub fn let_go(&mut self) {
        self.held = None;
    }

    /// Follows the mouse and the keys of one frame.
    pub fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        screen: &Screen,
        model: &PathGripModel,
        presses: &[Press],
        commands: &mut Vec<Command>,
    ) -> Rest {
        let mut rest = Rest {
            pointer: true,
            presses: presses.to_vec(),
        };
        let Some(path) = model.path else {
            *self = Self::default();
            return rest;
        };
        self.held = self.held.take().filter(|held| held.entity == path.entity);
        let (pointer, pressed, down, modifiers) = ui.input(|input| {
            (
                input.pointer.latest_pos(),
                input.pointer.button_pressed(PointerButton::Primary),
                input.pointer.button_down(PointerButton::Primary),
                input.modifiers,
            )
        });
        let pressed_at = ui.input(|input| input.pointer.press_origin()).filter(|_| pressed);
        let pointer = pressed_at.or(pointer).unwrap_or(screen.picture.center());
        if self.held.is_none() {
            let is_free = is_over(ui, response) && !modifiers.alt;
            self.hovered = if is_free { at(screen, path, pointer) } else { None };
            if pressed {
                self.held = self.hovered.map(|handle| Held::new(path, handle, pointer));
            }
        }
        rest.presses.retain(|press| !self.takes(press, path, commands));
        if let Some(held) = &mut self.held {
            let step = if modifiers.command { 0.0 } else { model.step };
            if let Some(now) = held.place(screen, model.up, pointer, step, modifiers.shift)
                && now != held.now
            {
                held.now = now;
                commands.extend(held.edit(path));
            }
            rest.pointer = false;
            if !down {
                self.held = None;
            }
            ui.ctx().request_repaint();
        }
        rest
    }

    /// Takes Delete for a point, and Esc for a drag. Other keys wait for the end of a drag.
    fn takes(&mut self, press: &Press, path: &MarkerPath, commands: &mut Vec<Command>) -> bool {
        match (press.key, &self.held, self.hovered) {
            (Key::Escape, Some(held), _) => {
                commands.push(set_points(path.entity, &held.before));
                self.held = None;
                true
            }
            (Key::Delete, None, Some(Handle::Point(number)))
                if press.modifiers.is_none() && path.points.len() > FEWEST =>
            {
                let mut points = path.points.clone();
                points.remove(number);
                commands.push(set_points(path.entity, &points));
                self.hovered = None;
                true
            }
            (_, held, _) => held.is_some(),
        }
    }

    /// Paints the handles.
    pub fn paint(&self, painter: &Painter, screen: &Screen, model: &PathGripModel) {
        let Some(path) = model.path else { return };
        let held = self.held.as_ref().map(|held| Handle::Point(held.number));
        let edge = Stroke::new(1.2, Color32::from_black_alpha(200));
        for (handle, place) in handles(screen, path) {
            let is_lit = held.or(self.hovered) == Some(handle);
            let radius = match handle {
                Handle::Point(_) => RADIUS,
                Handle::Middle(_) => SMALL,
            };
            let fill = if is_lit { marks::COLOR } else { Color32::WHITE };
            painter.circle(place, radius, fill, edge);
        }
    }
}

impl Held {
    fn new(path: &MarkerPath, handle: Handle, pressed_at: Pos2) -> Self {
        let mut points: Vec<Vec3> = path
            .points
            .iter()
            .map(|point| path.pose.transform_point3(*point))
            .collect();
        let number = match handle {
            Handle::Point(number) => number,
            Handle::Middle(number) => {
                let next = points[(number + 1) % points.len()];
                points.insert(number + 1, points[number].midpoint(next));
                number + 1
            }
        };
        Self {
            entity: path.entity,
            now: points[number],
            points,
            number,
            before: path.points.clone(),
            pressed_at,
        }
    }

    /// The place of the point with the pointer here: in the level plane through it, or above it. None where the plane
    /// is seen from its edge.
    fn place(&self, screen: &Screen, up: Vec3, pointer: Pos2, step: f32, is_upwards: bool) -> Option<Vec3> {
        let start = self.points[self.number];
        let normal = match is_upwards {
            true => screen.forward().reject_from(up).try_normalize()?,
            false => up,
        };
        let by = on_plane(screen, pointer, start, normal)? - on_plane(screen, self.pressed_at, start, normal)?;
        let by = if is_upwards { by.project_onto(up) } else { by };
        if !by.is_finite() {
            return None;
        }
        if pointer == self.pressed_at || step <= 0.0 {
            return Some(start + by);
        }
        // The coordinates that change are multiples of the step.
        let free = if is_upwards { up.abs() } else { Vec3::ONE - up.abs() };
        let place = start + by;
        Some(Vec3::select(
            free.cmpgt(Vec3::splat(0.5)),
            (place / step).round() * step,
            place,
        ))
    }

    /// The edit that puts the point where it is now; None where the path has no space of its own.
    fn edit(&self, path: &MarkerPath) -> Option<Command> {
        let own_from_world = path.pose.inverse();
        let mut points = self.before.clone();
        if self.points.len() > points.len() {
            points.insert(self.number, Vec3::ZERO);
        }
        points[self.number] = own_from_world.transform_point3(self.now);
        let is_finite = points[self.number].is_finite();
        is_finite.then(|| set_points(self.entity, &points))
    }
}

fn set_points(path: Entity, points: &[Vec3]) -> Command {
    PropertyEdit {
        owner: PropertyOwner::Things(vec![path]),
        name: POINTS.to_owned(),
        change: PropertyChange::Set(points_value(points)),
    }
    .into()
}

/// The handles in the picture with their places on the screen: points last, so that they are over the dots.
fn handles(screen: &Screen, path: &MarkerPath) -> Vec<(Handle, Pos2)> {
    let world: Vec<Vec3> = path
        .points
        .iter()
        .map(|point| path.pose.transform_point3(*point))
        .take(MOST)
        .collect();
    let middles =
        (0..world.len().saturating_sub(1)).map(|leg| (Handle::Middle(leg), world[leg].midpoint(world[leg + 1])));
    let points = world
        .iter()
        .enumerate()
        .map(|(number, point)| (Handle::Point(number), *point));
    let all = middles.chain(points);
    let seen = all.filter_map(|(handle, place)| Some((handle, screen.project(place)?)));
    seen.filter(|(_, place)| screen.picture.contains(*place)).collect()
}

/// The handle at the pointer; a point wins over a dot.
fn at(screen: &Screen, path: &MarkerPath, pointer: Pos2) -> Option<Handle> {
    let all = handles(screen, path);
    let near = all
        .iter()
        .rev()
        .map(|(handle, place)| (handle, place.distance(pointer)));
    let nearest = near
        .filter(|(_, distance)| *distance <= REACH)
        .min_by(|a, b| a.1.total_cmp(&b.1));
    nearest.map(|(handle, _)| *handle)
}

#[cfg(test)]
mod tests {
    use bevy::math::Affine3A;
    use bevy::prelude::World;
    use bevy_egui::egui::vec2;

    use super::*;
    use crate::app::editor::camera::screen::tests::perspective;

    fn path() -> MarkerPath {
        MarkerPath {
            entity: World::new().spawn_empty().id(),
            points: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0)],
            pose: Affine3A::IDENTITY,
            line: Vec::new(),
            tint: Color32::WHITE,
        }
    }

    #[test]
    fn a_drag_moves_a_point_in_its_plane_by_steps() {
        let (screen, path) = (perspective(), path());
        let places = handles(&screen, &path);
        let (_, place) = places
            .iter()
            .find(|(handle, _)| *handle == Handle::Point(1))
            .expect("it is seen");
        assert_eq!(at(&screen, &path, *place + vec2(3.0, 0.0)), Some(Handle::Point(1)));
        let held = Held::new(&path, Handle::Point(1), *place);
        // The view is along -z, so that a plane whose normal is z is seen from the front.
        let to = *place + vec2(40.0, -30.0);
        let free = held.place(&screen, Vec3::Z, to, 0.0, false).expect("the plane is seen");
        assert!(free.z.abs() < 1e-4 && free.distance(Vec3::X) > 0.01, "{free}");
        let snapped = held
            .place(&screen, Vec3::Z, to, 0.25, false)
            .expect("the plane is seen");
        assert!(
            ((snapped * 4.0).round() - snapped * 4.0).abs().max_element() < 1e-4,
            "{snapped}"
        );
        assert_eq!(held.place(&screen, Vec3::Z, *place, 0.25, false), Some(Vec3::X));
    }

    #[test]
    fn a_dragged_middle_becomes_a_point() {
        let path = path();
        let mut held = Held::new(&path, Handle::Middle(0), Pos2::ZERO);
        assert_eq!((held.number, held.now), (1, 0.5 * Vec3::X));
        held.now = Vec3::Y;
        let expected = [Vec3::ZERO, Vec3::Y, Vec3::X, Vec3::new(1.0, 1.0, 0.0)];
        assert_eq!(held.edit(&path), Some(set_points(path.entity, &expected)));
    }
}
