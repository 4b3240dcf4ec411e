//! The tools that block out a building in the picture: drawing boxes, floors and walls, pushing and pulling faces,
//! cutting doors and windows.
//!
//! They use the left button and, while something is being drawn or pushed, the number keys, Enter and Escape. All other
//! input, such as looking around with the right button, works as without them.

mod catch;
pub mod cut;
pub mod draw;
mod floor;
pub mod grips;
pub mod hand;
pub(super) mod marks;
pub mod push;
pub(super) mod spot;

use bevy::prelude::Entity;
use bevy_egui::egui::{InputState, Key, Painter, PointerButton, Response, Ui};

use super::gizmo::interaction::Rest;
use super::gizmo::typed::Typed;
use super::over_picture::is_over;
use crate::app::editor::camera::picking::{self, SeenSurface};
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::Command;
use crate::app::editor::command::tool::Tool;
use crate::app::editor::input::press::Press;
use cut::CutState;
use draw::DrawState;
use hand::{BlockingModel, Hand};
use push::PushState;

/// The state that the tools keep between frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BlockingState {
    /// The shapes under the pointer and around it, which are looked up for the next frame.
    pub(crate) near: Vec<Entity>,
    /// The surface under the pointer.
    seen: Option<SeenSurface>,
    /// Moments at which the button went down or up near shapes that are not looked up yet, and the keys after them.
    waiting: Vec<Hand>,
    waiting_keys: Vec<Press>,
    pub(super) draw: DrawState,
    pub(super) push: PushState,
    pub(super) cut: CutState,
}

impl BlockingState {
    /// Whether something is being drawn or pushed.
    pub(crate) fn is_busy(&self) -> bool {
        self.draw.is_busy() || self.push.is_busy() || self.cut.is_busy()
    }

    /// Drops the unfinished drawing when the tool is left. The heights used last stay.
    pub(crate) fn leave(&mut self) {
        self.draw.cancel();
        *self = Self {
            draw: std::mem::take(&mut self.draw),
            ..Self::default()
        };
    }

    /// The hint for the next step of the drawing, the push or the cut.
    pub(super) fn next_step(&self, model: &BlockingModel) -> Option<String> {
        match model.tool {
            Tool::Draw(kind) => self.draw.hint(kind, model.unit),
            Tool::Push => self.push.hint().map(str::to_owned),
            Tool::Cut(_) => self.cut.hint().map(str::to_owned),
            _ => None,
        }
    }

    /// Follows the mouse and the keys of one frame.
    pub fn follow_blocks(
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
        if !matches!(model.tool, Tool::Cut(_)) {
            self.cut = CutState::default();
        }
        let is_over = is_over(ui, response);
        let (end, moments) = ui.input(|input| {
            let end = Hand {
                pointer: input.pointer.latest_pos().unwrap_or(screen.picture.center()),
                pressed: false,
                is_turn: false,
                down: input.pointer.button_down(PointerButton::Primary),
                step: step(input, model),
            };
            (end, hand::moments(&input.events, is_over, end))
        });
        let late = std::mem::take(&mut self.waiting);
        let has_waited = !late.is_empty();
        let mut rest = std::mem::take(&mut self.waiting_keys);
        rest.extend_from_slice(presses);
        let mut take_keys = |this: &mut Self, commands: &mut Vec<Command>| {
            rest.retain(|press| !this.take_key(press, screen, model, &end, commands));
        };
        // Keys and mouse events come without a common order. Before a drawing begins the tool uses no keys, so that
        // they count as pressed after its begin.
        let keys_first = self.is_busy() && !self.draw.is_dragging();
        if keys_first {
            take_keys(self, commands);
        }
        let mut moments: Vec<Hand> = late.into_iter().chain(moments).collect();
        let mut uses_pointer = false;
        for at in 0..moments.len() {
            let hand = moments[at];
            let is_known = self.look(ui, screen, model, is_over, &hand);
            // A shape that is still unknown after a frame is none that the tools can edit.
            if hand.is_turn && !is_known && !(has_waited && at == 0) {
                self.waiting = moments.split_off(at).into_iter().filter(|hand| hand.is_turn).collect();
                break;
            }
            uses_pointer |= self.act(screen, model, &hand, commands);
        }
        if !keys_first && self.waiting.is_empty() {
            take_keys(self, commands);
        }
        if !self.waiting.is_empty() {
            self.waiting_keys = std::mem::take(&mut rest);
            ui.ctx().request_repaint();
        }
        if self.is_busy() {
            // The preview follows the pointer.
            ui.ctx().request_repaint();
        }
        Rest {
            // A press that waits for the shape to be looked up may be meant for the tool.
            pointer: !uses_pointer && self.waiting.is_empty(),
            presses: rest,
        }
    }

    /// Follows the mouse at a moment; returns whether the left button is used by the tool.
    fn act(&mut self, screen: &Screen, model: &BlockingModel, hand: &Hand, commands: &mut Vec<Command>) -> bool {
        let seen = self.seen.as_ref();
        match model.tool {
            Tool::Draw(kind) => self.draw.follow(kind, seen, screen, model, hand, commands),
            Tool::Push => self.push.follow(seen, screen, model, hand, commands),
            Tool::Cut(kind) => self.cut.follow(kind, seen, screen, model, hand, commands),
            _ => false,
        }
    }

    /// Finds the surface under the pointer and the shapes around it; returns false if some of these are not looked up
    /// yet.
    fn look(&mut self, ui: &Ui, screen: &Screen, model: &BlockingModel, is_over: bool, hand: &Hand) -> bool {
        let draws = matches!(model.tool, Tool::Draw(_));
        if self.is_busy() && !draws && !self.push.waits() {
            return true;
        }
        let seen = picking::seen_surface(model.packed, &screen.ray(hand.pointer), |_| false).filter(|_| is_over);
        let is_free = |entity: &Entity| !model.locked.contains(entity);
        let near = match draws && is_over {
            true => catch::shapes_around(model.packed, screen, hand.pointer),
            false => seen.map(|seen| seen.entity).filter(is_free).into_iter().collect(),
        };
        let is_known = near.iter().all(|entity| model.target(*entity).is_some());
        if self.seen != seen || self.near != near {
            ui.ctx().request_repaint();
        }
        (self.seen, self.near) = (seen, near);
        is_known
    }

    /// Handles a key; returns whether it was used by the drawing or the push.
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
                self.cut.cancel();
                self.push.cancel(commands);
            }
            Key::Enter => match model.tool {
                Tool::Draw(kind) => {
                    let seen = self.seen.as_ref();
                    self.draw.confirm(kind, seen, screen, model, hand, commands);
                }
                Tool::Cut(kind) => self.cut.confirm(kind, screen, model, hand.step, commands),
                _ => self.push.let_go(),
            },
            key => {
                let typed: Option<&mut Typed> = match model.tool {
                    Tool::Draw(_) => self.draw.typed(),
                    Tool::Cut(_) => self.cut.typed(),
                    _ => self.push.typed(),
                };
                let with_shift = press.modifiers.shift;
                return typed.is_some_and(|typed| typed.press(key) || typed.press_unit(key, with_shift));
            }
        }
        true
    }

    /// Paints the drawing, the face under the pointer or the opening there.
    pub fn paint_blocks(&self, painter: &Painter, screen: &Screen, model: &BlockingModel) {
        match model.tool {
            Tool::Draw(kind) => self.draw.paint(painter, screen, kind, model),
            Tool::Push => self.push.paint(painter, screen, self.seen.as_ref(), model),
            Tool::Cut(kind) => {
                let step = painter.ctx().input(|input| step(input, model));
                self.cut.paint(painter, screen, kind, self.seen.as_ref(), model, step);
            }
            _ => {}
        }
    }
}

/// The step to which places are rounded: that of the grid, or none with Control.
fn step(input: &InputState, model: &BlockingModel) -> f32 {
    if input.modifiers.command { 0.0 } else { model.step }
}
