//! The tools that block out a building in the picture: drawing boxes, floors and walls, pushing and pulling faces, cutting doors and windows.
//!
//! They use the left button and, while something is being drawn or pushed, the number keys, Enter and Escape. Everything else, such as looking
//! around with the right button, is as without them.

pub mod cut;
pub mod draw;
pub mod hand;
pub(super) mod marks;
pub mod push;
mod spot;

use bevy::prelude::Entity;
use bevy_egui::egui::{InputState, Key, Painter, PointerButton, Pos2, Response, Ui};

use super::gizmo::interaction::Rest;
use super::gizmo::typed::Typed;
use super::over_picture::is_over;
use crate::app::editor::camera::picking::{self, SeenSurface};
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::Command;
use crate::app::editor::command::tool::Tool;
use crate::app::editor::input::press::Press;
use draw::DrawState;
use hand::{BlockingModel, Hand};
use push::PushState;

/// The state that the tools keep between frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BlockingState {
    /// The shape under the pointer, which is looked up for the next frame.
    pub(crate) hovered: Option<Entity>,
    /// The surface under the pointer.
    seen: Option<SeenSurface>,
    /// A press on a shape that is not looked up yet.
    waiting: Option<Pos2>,
    pub(super) draw: DrawState,
    pub(super) push: PushState,
}

impl BlockingState {
    /// Whether something is being drawn or pushed.
    pub(crate) fn is_busy(&self) -> bool {
        self.draw.is_busy() || self.push.is_busy()
    }

    /// Forgets what was under way when the tool was left. The heights that were given last stay.
    pub(crate) fn leave(&mut self) {
        self.draw.cancel();
        *self = Self {
            draw: std::mem::take(&mut self.draw),
            ..Self::default()
        };
    }

    /// Follows the mouse and the keys of one frame.
    pub fn follow(
        &mut self,
        ui: &Ui,
        response: &Response,
        screen: &Screen,
        model: &BlockingModel,
        presses: &[Press],
        commands: &mut Vec<Command>,
    ) -> Rest {
        if !matches!(model.tool, Tool::Draw(_)) {
            self.draw.cancel();
        }
        if model.tool != Tool::Push {
            self.push = PushState::default();
        }
        let is_over = is_over(ui, response);
        // The call locks egui's context, so that it must not be locked here already.
        let clicked = response.clicked_by(PointerButton::Primary);
        let mut hand = ui.input(|input| Hand {
            pointer: input.pointer.latest_pos().unwrap_or(screen.picture.center()),
            pressed: is_over && input.pointer.button_pressed(PointerButton::Primary) && !input.modifiers.alt,
            clicked: clicked && !input.modifiers.alt,
            down: input.pointer.button_down(PointerButton::Primary),
            step: step(input, model),
        });
        self.look(ui, screen, model, is_over, &mut hand);
        let rest: Vec<Press> = presses
            .iter()
            .filter(|press| !self.take_key(press, screen, model, &hand, commands))
            .copied()
            .collect();
        let uses_pointer = match model.tool {
            Tool::Draw(kind) => self
                .draw
                .follow(kind, self.seen.as_ref(), screen, model, &hand, commands),
            Tool::Push => self.push.follow(self.seen.as_ref(), screen, model, &hand, commands),
            Tool::Cut(kind) => {
                cut::follow(kind, self.seen.as_ref(), model, &hand, commands);
                false
            }
            _ => false,
        };
        if self.is_busy() {
            // The preview follows the pointer.
            ui.ctx().request_repaint();
        }
        Rest {
            // A press that waits for the shape to be looked up may be meant for the tool.
            pointer: !uses_pointer && self.waiting.is_none(),
            presses: rest,
        }
    }

    /// Finds the surface under the pointer. A press on a shape that is not looked up yet waits for the next frame.
    fn look(&mut self, ui: &Ui, screen: &Screen, model: &BlockingModel, is_over: bool, hand: &mut Hand) {
        if self.is_busy() {
            return;
        }
        let needs_target = matches!(model.tool, Tool::Push | Tool::Cut(_));
        let asked = match model.tool {
            Tool::Cut(_) => &mut hand.clicked,
            _ => &mut hand.pressed,
        };
        let waited = self.waiting.take();
        if let Some(place) = waited {
            hand.pointer = place;
            *asked = true;
        }
        let seen = picking::seen_surface(model.packed, &screen.ray(hand.pointer), |_| false).filter(|_| is_over);
        let hovered = seen
            .map(|seen| seen.entity)
            .filter(|entity| !model.locked.contains(entity));
        if needs_target && hovered.is_some() && model.target.map(|target| target.entity) != hovered {
            // If nothing is known of the shape after a frame, it is none that the tools can change.
            let is_new = std::mem::take(asked) && waited.is_none();
            self.waiting = is_new.then_some(hand.pointer);
        }
        if self.seen != seen || self.waiting.is_some() {
            ui.ctx().request_repaint();
        }
        (self.seen, self.hovered) = (seen, hovered);
    }

    /// Handles a key; true if it was for what is being drawn or pushed.
    fn take_key(
        &mut self,
        press: &Press,
        screen: &Screen,
        model: &BlockingModel,
        hand: &Hand,
        commands: &mut Vec<Command>,
    ) -> bool {
        if !self.is_busy() || press.modifiers.command || press.modifiers.alt {
            return false;
        }
        match press.key {
            Key::Escape => {
                self.draw.cancel();
                self.push.cancel(commands);
            }
            Key::Enter => {
                if let Tool::Draw(kind) = model.tool {
                    self.draw.confirm(kind, screen, model, hand, commands);
                }
                self.push.let_go();
            }
            key => {
                let typed: Option<&mut Typed> = match model.tool {
                    Tool::Draw(_) => self.draw.typed(),
                    _ => self.push.typed(),
                };
                let with_shift = press.modifiers.shift;
                return typed.is_some_and(|typed| typed.press(key) || typed.press_unit(key, with_shift));
            }
        }
        true
    }

    /// Draws what is being drawn, the face under the pointer or the opening there.
    pub fn paint(&self, painter: &Painter, screen: &Screen, model: &BlockingModel) {
        match model.tool {
            Tool::Draw(kind) => self.draw.paint(painter, screen, kind, model),
            Tool::Push => self.push.paint(painter, screen, self.seen.as_ref(), model),
            Tool::Cut(kind) => {
                let step = painter.ctx().input(|input| step(input, model));
                cut::paint(painter, screen, kind, self.seen.as_ref(), model, step);
            }
            _ => {}
        }
    }
}

/// The step to which places are rounded: that of the grid, or none with Control.
fn step(input: &InputState, model: &BlockingModel) -> f32 {
    if input.modifiers.command { 0.0 } else { model.step }
}
