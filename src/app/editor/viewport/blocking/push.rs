//! Pushing and pulling the face under the pointer along its normal.

use bevy::math::Vec3;
use bevy_egui::egui::{Painter, Pos2};

use super::hand::{BlockTarget, BlockingModel, Hand, along_line, is_drag};
use super::marks;
use crate::app::editor::camera::picking::SeenSurface;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::blocking::faces::{Face, extent_across, pushed};
use crate::app::editor::command::blocking::{Reshaping, snapped};
use crate::app::editor::command::{Command, SceneEdit};
use crate::app::editor::viewport::gizmo::typed::Typed;
use crate::scene::Shape;

/// The state of the push tool.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::app::editor::viewport) struct PushState {
    held: Option<Held>,
}

#[derive(Clone, Debug, PartialEq)]
struct Held {
    /// The shape as it was at the press.
    target: BlockTarget,
    face: Face,
    /// The point of the press on the face, in the world.
    grabbed: Vec3,
    pressed_at: Pos2,
    /// Whether the button is still down. After a click it is not, and only a typed number moves the face.
    is_dragged: bool,
    /// The distance that the face has moved so far, in world units.
    by: f32,
    typed: Typed,
}

impl PushState {
    pub fn is_busy(&self) -> bool {
        self.held.is_some()
    }

    /// Whether a face was clicked and a number is awaited.
    pub fn waits(&self) -> bool {
        self.held.as_ref().is_some_and(|held| !held.is_dragged)
    }

    pub fn typed(&mut self) -> Option<&mut Typed> {
        self.held.as_mut().map(|held| &mut held.typed)
    }

    /// The hint for the next step while a face is held.
    pub fn hint(&self) -> Option<&'static str> {
        self.held.as_ref().map(|held| match held.is_dragged {
            true => {
                "Let go where it is to be, or type how far it goes and Enter (Ctrl: off the grid, Esc: put it back)"
            }
            false => "Type how far it goes and Enter, or drag a face (Esc: put it back)",
        })
    }

    pub fn let_go(&mut self) {
        self.held = None;
    }

    /// Moves the face back to where it was at the press.
    pub fn cancel(&mut self, commands: &mut Vec<Command>) {
        if let Some(held) = self.held.take().filter(|held| held.by != 0.0) {
            let BlockTarget { entity, shape, pose } = held.target;
            commands.push(SceneEdit::Reshape(entity, shape, pose, Reshaping::Push).into());
        }
    }

    /// Follows the mouse; returns whether the left button is used by the tool.
    pub fn follow(
        &mut self,
        seen: Option<&SeenSurface>,
        screen: &Screen,
        model: &BlockingModel,
        hand: &Hand,
        commands: &mut Vec<Command>,
    ) -> bool {
        if hand.pressed {
            // The face that was clicked before stays where it is now.
            self.held = None;
        }
        if hand.pressed
            && let Some((target, face)) = under(seen, model)
        {
            self.held = Some(Held {
                target: target.clone(),
                face,
                grabbed: seen.map_or(Vec3::ZERO, |seen| seen.position),
                pressed_at: hand.pointer,
                is_dragged: true,
                by: 0.0,
                typed: Typed::default(),
            });
        }
        let Some(held) = &mut self.held else {
            return false;
        };
        // A number that was typed before the button was released counts, too.
        if let Some(by) = held.way(screen, model, hand)
            && by != held.by
            && let Some((kind, pose)) = pushed(&held.target.shape.kind, &held.target.pose, held.face, by)
        {
            held.by = by;
            let shape = Shape {
                kind,
                ..held.target.shape.clone()
            };
            commands.push(SceneEdit::Reshape(held.target.entity, shape, pose, Reshaping::Push).into());
        }
        let was_dragged = held.is_dragged;
        if !hand.down && was_dragged {
            held.is_dragged = false;
            if held.by != 0.0 || !held.typed.is_empty() || is_drag(held.pressed_at, hand.pointer) {
                self.held = None;
            }
        }
        was_dragged
    }

    pub fn paint(&self, painter: &Painter, screen: &Screen, seen: Option<&SeenSurface>, model: &BlockingModel) {
        let (target, face, by) = match &self.held {
            Some(held) => (&held.target, held.face, held.by),
            None => match under(seen, model) {
                Some((target, face)) => (target, face, 0.0),
                None => return,
            },
        };
        let moved = pushed(&target.shape.kind, &target.pose, face, by);
        let Some(corners) = moved.and_then(|(kind, pose)| face.corners(&kind, &pose)) else {
            return;
        };
        marks::area(painter, screen, &corners);
        marks::ring(painter, screen, &corners);
        let middle = 0.25 * corners.iter().copied().sum::<Vec3>();
        let (outward, _) = face.outward(&target.pose);
        let reach = 40.0 * screen.units_per_point(screen.depth(middle));
        marks::segment(painter, screen, middle, middle + outward * reach);
        if let Some(held) = &self.held {
            let before = extent_across(&target.shape.kind, &target.pose, face).unwrap_or(0.0);
            let typed = if held.typed.is_empty() {
                String::new()
            } else {
                format!("   [{}]", held.typed.text())
            };
            let sign = if by < 0.0 { "" } else { "+" };
            let text = format!(
                "{sign}{} = {}{typed}",
                model.unit.text(by),
                model.unit.text(before + by)
            );
            marks::text(painter, screen, middle, &text);
        }
    }
}

impl Held {
    /// The distance of the push: the typed number, or the distance to the pointer, rounded to the world's grid if the
    /// face is parallel to it.
    fn way(&self, screen: &Screen, model: &BlockingModel, hand: &Hand) -> Option<f32> {
        if let Some(&[number]) = self.typed.lengths(model.unit).as_deref() {
            return Some(number);
        }
        if !self.is_dragged {
            return Some(0.0);
        }
        let (outward, _) = self.face.outward(&self.target.pose);
        let way = along_line(screen, hand.pointer, self.grabbed, outward)?;
        let is_on_grid = outward.abs().max_element() > 0.9999;
        let start = if is_on_grid { self.grabbed.dot(outward) } else { 0.0 };
        // A press alone moves nothing.
        if way.abs() < 0.5 * hand.step {
            return Some(0.0);
        }
        Some(snapped(start + way, hand.step) - start)
    }
}

fn under<'a>(seen: Option<&SeenSurface>, model: &BlockingModel<'a>) -> Option<(&'a BlockTarget, Face)> {
    let seen = seen?;
    let target = model.target(seen.entity)?;
    let face = Face::at(&target.shape.kind, &target.pose, seen.position, seen.normal)?;
    Some((target, face))
}
